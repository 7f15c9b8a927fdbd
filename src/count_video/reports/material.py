"""What the evidence is made of: answer and track in units, and what is kept of the frames."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Collision, Floats, MotionLine, Track, TrialResult

Luma = NDArray[np.uint8]
Point = tuple[float, float]
Range = tuple[float, float]
DENSE_SHARE = 0.6
"""The enlarged stretch is the shortest that holds this share of the burst."""
ENLARGED_SHARE = 0.5
"""What takes more than this share of the whole is not worth a panel that enlarges it."""
MARGIN_SHARE = 0.06
"""Share of a stretch of frames that is shown on either side of it."""
BESIDE_DIAMETERS = 0.35
"""Shown beyond the ball's path, towards the wall and towards the heavy body."""
HALF_WIDTH_DIAMETERS = 0.1
"""The line is averaged this far to either side, in ball diameters: noise goes, edges stay."""
CUT_DIAMETERS = (2.4, 1.5)
"""Size of the enlarged surroundings of a contact, along and across the line."""
CUT_WIDTH_PX = 300
JPEG_QUALITY = 82


@dataclass(frozen=True)
class SpaceTime:
    """The space-time image: the line of motion, cut out of every frame and laid row upon row."""

    frame: Floats
    """Frame coordinates of the rows, shape (n,)."""
    image: Luma
    """Brightness, shape (n, length): row by frame, column by position along the line in px."""


@dataclass(frozen=True)
class Pendulum:
    """How the heavy body swings, as measured."""

    rate_squared: float
    """Square of the angular rate in (radians per frame) squared."""
    centre_px: float
    """Distance of its face from the wall's side where the threads hang straight down, in px along
    the line, growing away from the wall."""


@dataclass(frozen=True)
class Material:
    """All that pictures and tables of one clip are made from."""

    result: TrialResult
    track: Track
    space_time: SpaceTime | None
    """None of a trial that is planned and not filmed; the wall then stands at 0."""
    pendulum: Pendulum | None
    """None where the swing does not show."""

    @property
    def outward(self) -> int:
        """+1 where positions grow away from the wall, -1 where they fall."""
        return 1 if self.track.wall_side == "left" else -1

    @cached_property
    def burst(self) -> tuple[Collision, ...]:
        """The collisions that count, or would if the clip were counted."""
        return tuple(c for c in self.result.collisions if c.number <= self.result.burst_size)

    @cached_property
    def shown_frames(self) -> Range:
        """First and last frame of the whole picture: all collisions, or the clip without any."""
        first, last = float(self.track.frame[0]), float(self.track.frame[-1])
        times = [c.frame for c in self.result.collisions] or [first, last]
        margin = max(10.0, 2 * MARGIN_SHARE * (times[-1] - times[0]))
        return max(first, times[0] - margin), min(last, times[-1] + margin)

    @cached_property
    def dense_frames(self) -> Range:
        """The shortest stretch of frames that holds most of the burst."""
        times = [collision.frame for collision in self.burst]
        if len(times) < 3:
            return self.shown_frames
        held = max(3, round(DENSE_SHARE * len(times))) - 1
        low, high = min(zip(times, times[held:], strict=False), key=lambda ends: ends[1] - ends[0])
        margin = MARGIN_SHARE * (high - low) + 1.0
        return low - margin, high + margin

    @cached_property
    def is_dense(self) -> bool:
        """Whether the burst has a part that is worth enlarging."""
        (low, high), (first, last) = self.dense_frames, self.shown_frames
        return high - low < ENLARGED_SHARE * (last - first)

    def shown_places(self, frames: Range) -> Range:
        """Lowest and highest position shown: from the wall to the heavy body's face, and beyond."""
        track = self.track
        inside = (track.frame >= frames[0]) & (track.frame <= frames[1])
        lines = [*ball_edges_px(track), *([] if track.heavy is None else [track.heavy.position_px])]
        values = np.concatenate([line[inside] for line in lines])
        values = values[np.isfinite(values)]
        if values.size == 0:
            return 0.0, 1.0 if self.space_time is None else float(self.space_time.image.shape[1])
        beside = BESIDE_DIAMETERS * track.ball_diameter_px
        return float(values.min()) - beside, float(values.max()) + beside


def contact_px(collision: Collision, track: Track) -> float:
    """Place along the line where the ball touches: its edge turned to heavy body or wall."""
    low = (track.wall_side == "left") == (collision.kind == "wall")
    return collision.position_px + (track.ball.low_edge_px if low else track.ball.high_edge_px)


def ball_edges_px(track: Track) -> tuple[Floats, Floats]:
    """Outline of the ball along the line, at smaller and at larger positions, shape (n,) each."""
    ball = track.ball
    return ball.position_px + ball.low_edge_px, ball.position_px + ball.high_edge_px


# ---- units ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scale:
    """Turns px and frames into what the axes say."""

    length: float
    """Millimetres a px, or 1."""
    length_unit: str
    time: float
    """Milliseconds a frame, or 1."""
    time_unit: str

    @property
    def speed(self) -> float:
        """Speed units a px per frame; mm/ms is m/s."""
        return self.length / self.time

    @property
    def speed_unit(self) -> str:
        """``m/s`` where both scales are known."""
        unit = f"{self.length_unit}/{self.time_unit}"
        return "m/s" if unit == "mm/ms" else unit


def scale_of(result: TrialResult) -> Scale:
    """Best units that are known."""
    length, fps = result.millimetres_per_px, result.capture_fps
    time = (1000.0 / fps, "ms") if fps else (1.0, "frame")
    return Scale(*((length, "mm") if length else (1.0, "px")), *time)


# ---- places ------------------------------------------------------------------------------------


def image_point(line: MotionLine, position_px: float, shift: Point = (0.0, 0.0)) -> Point:
    """Image x and y of a position along the line of motion, in a picture shifted so far."""
    slope = np.tan(np.radians(line.tilt_deg))
    x, y = position_px, line.anchor_y_px + slope * (position_px - line.anchor_x_px)
    if line.upright:
        x, y = line.anchor_x_px + slope * (position_px - line.anchor_y_px), position_px
    return x + shift[0], y + shift[1]


def shift_of(track: Track, row: int) -> Point:
    """How far the picture of one row of a track is shifted by the camera's motion, by x and y."""
    if track.shift_px is None:
        return 0.0, 0.0
    x, y = track.shift_px[row]
    return float(x), float(y)


def touching(
    track: Track, collisions: tuple[Collision, ...], swing: Pendulum | None
) -> tuple[Track, Pendulum | None]:
    """Shift the heavy body's face, and its swing, to where the ball touches it, in the median.

    Its face is learnt from the picture, and a rim, a shadow or a reflection can pass for it. The
    track is not wrong by that, only shifted by a constant; and the collisions between the bodies
    give the constant, for there the heavy body's face is where the ball's outline is.
    """
    contacts = [c for c in collisions if c.kind == "bodies" and c.seen]
    if track.heavy is None or not contacts or not np.isfinite(track.heavy.position_px).any():
        return track, swing
    place = track.heavy.position_px
    seen = np.isfinite(place)
    face = np.interp([c.frame for c in contacts], track.frame[seen], place[seen])
    shift = float(np.median(np.array([contact_px(c, track) for c in contacts]) - face))
    heavy = replace(
        track.heavy,
        position_px=place + shift,
        low_edge_px=track.heavy.low_edge_px - shift,
        high_edge_px=track.heavy.high_edge_px - shift,
    )
    if swing is not None:
        outward = 1 if track.wall_side == "left" else -1
        swing = replace(swing, centre_px=swing.centre_px + outward * shift)
    return replace(track, heavy=heavy), swing


# ---- what is kept of the frames ----------------------------------------------------------------


def line_of_motion(luma: Luma, track: Track, row: int) -> Luma:
    """Brightness along the line of motion in the picture of one row of a track, shape (length,).

    Beyond the picture's border its last pixel goes on.
    """
    line = track.line
    half = max(1, round(HALF_WIDTH_DIAMETERS * track.ball_diameter_px))
    begin = np.array(image_point(line, 0.0, shift_of(track, row)))
    along, across = np.array([1.0, np.tan(np.radians(line.tilt_deg))]), np.array([0.0, 1.0])
    if line.upright:
        along, across = along[::-1], across[::-1]
    band = cv2.warpAffine(
        np.ascontiguousarray(luma),
        np.column_stack([along, across, begin - half * across]),
        (luma.shape[0] if line.upright else luma.shape[1], 2 * half + 1),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return np.asarray(np.rint(band.mean(axis=0)), np.uint8)


def contact_jpeg(luma: Luma, collision: Collision, track: Track, row: int) -> bytes:
    """Cut the surroundings of a contact out of the picture of one row of a track, enlarged."""
    x, y = image_point(track.line, contact_px(collision, track), shift_of(track, row))
    sides = [max(10, round(share * track.ball_diameter_px)) for share in CUT_DIAMETERS]
    width, height = np.minimum(sides[::-1] if track.line.upright else sides, luma.shape[::-1])
    left = int(np.clip(round(x - width / 2), 0, luma.shape[1] - width))
    top = int(np.clip(round(y - height / 2), 0, luma.shape[0] - height))
    piece = np.ascontiguousarray(luma[top : top + height, left : left + width])
    scale = CUT_WIDTH_PX / width
    size = (CUT_WIDTH_PX, max(1, round(height * scale)))
    smooth = cv2.INTER_CUBIC if scale > 1 else cv2.INTER_AREA
    shown = cv2.resize(piece, size, interpolation=smooth)
    return bytes(cv2.imencode(".jpg", shown, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1])

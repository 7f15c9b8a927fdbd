"""What the evidence is made of: answer and track in units, and what is kept of the frames."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Collision, Floats, Frame, MotionLine, Track, TrialResult

Luma = NDArray[np.uint8]
Point = tuple[float, float]
Range = tuple[float, float]
DENSE_SHARE = 0.6
"""The enlarged stretch is the shortest that holds this share of the burst."""
MARGIN_SHARE = 0.06
"""Share of a stretch of frames that is shown on either side of it."""
BESIDE_DIAMETERS = 0.35
"""Shown beyond the ball's path, towards the wall and towards the heavy body."""
HALF_WIDTH_DIAMETERS = 0.1
"""The line is averaged this far to either side, in ball diameters: noise goes, edges stay."""
WIDTH_DIAMETERS = 2.4
HEIGHT_DIAMETERS = 1.5
SHOWN_WIDTH_PX = 300
JPEG_QUALITY = 82
BESIDE = (-1, 0, 1)
"""Frames cut out, counted from the one nearest to the contact."""


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
        frames = self.track.frame
        ends = (float(frames[0]), float(frames[-1]))
        collisions = self.result.collisions
        if not collisions:
            return ends
        low, high = collisions[0].frame, collisions[-1].frame
        margin = max(10.0, 2 * MARGIN_SHARE * (high - low))
        return max(ends[0], low - margin), min(ends[1], high + margin)

    @cached_property
    def dense_frames(self) -> Range:
        """The shortest stretch of frames that holds most of the burst."""
        times = [collision.frame for collision in self.burst]
        if len(times) < 3:
            return self.shown_frames
        held = max(3, round(DENSE_SHARE * len(times)))
        starts = range(len(times) - held + 1)
        start = min(starts, key=lambda first: times[first + held - 1] - times[first])
        low, high = times[start], times[start + held - 1]
        margin = MARGIN_SHARE * (high - low) + 1.0
        return low - margin, high + margin

    def shown_places(self, frames: Range) -> Range:
        """Lowest and highest position shown: from the wall to the heavy body's face, and beyond."""
        track = self.track
        inside = (track.frame >= frames[0]) & (track.frame <= frames[1])
        low, high = (edge[inside] for edge in ball_edges_px(track))
        face = track.heavy.position_px[inside] if track.heavy is not None else high
        values = np.concatenate([low, high, face])
        values = values[np.isfinite(values)]
        if values.size == 0:
            return 0.0, 1.0 if self.space_time is None else float(self.space_time.image.shape[1])
        beside = BESIDE_DIAMETERS * track.ball_diameter_px
        return float(values.min()) - beside, float(values.max()) + beside


def contact_px(collision: Collision, track: Track) -> float:
    """Place along the line where the ball touches: its edge turned to heavy body or wall."""
    to_wall_low = track.wall_side == "left"
    low = to_wall_low == (collision.kind == "wall")
    edge = track.ball.low_edge_px if low else track.ball.high_edge_px
    return collision.position_px + edge


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
        if (self.length_unit, self.time_unit) == ("mm", "ms"):
            return "m/s"
        return f"{self.length_unit}/{self.time_unit}"


def scale_of(result: TrialResult) -> Scale:
    """Best units that are known."""
    millimetres, fps = result.millimetres_per_px, result.capture_fps
    return Scale(
        length=millimetres or 1.0,
        length_unit="mm" if millimetres else "px",
        time=1000.0 / fps if fps else 1.0,
        time_unit="ms" if fps else "frame",
    )


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


def touching(track: Track, collisions: tuple[Collision, ...]) -> Track:
    """Shift the heavy body's reference point to where the ball touches it, in the median.

    Its face is learnt from the picture, and a rim, a shadow or a reflection can pass for it. The
    track is not wrong by that, only shifted by a constant; and the collisions between the bodies
    give the constant, for there the heavy body's face is where the ball's outline is.
    """
    contacts = [c for c in collisions if c.kind == "bodies" and c.seen]
    if track.heavy is None or not contacts or not np.isfinite(track.heavy.position_px).any():
        return track
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
    return replace(track, heavy=heavy)


FRAMES_ENOUGH = 8
REACH_DIAMETERS = 0.3
STEP_PX = 0.5
BESIDE_RIM_PX = 1.5
"""Brightness is compared this far inside and outside of the circle."""
ANGLES_DEG = np.concatenate([np.arange(40, 141, 4), np.arange(220, 321, 4)])
"""The upper and the lower arc, which a shift across the line moves off the rim."""
CLEARER = 1.3
"""The best height is believed if it is so much clearer than the typical one."""


def levelled(track: Track, frames: list[Frame]) -> Track:
    """Shift the line of motion across itself so that the ball's circle lies on its rim.

    The track follows motion along the line and measures the line's height only roughly. Place and
    radius along the line being known, the height is where the brightness steps from inside to
    outside all around the circle. Where no rim shows (the body is no ball) the track is left as it
    is. A few frames are enough.
    """
    diameter = track.ball_diameter_px
    offsets = np.arange(-REACH_DIAMETERS, REACH_DIAMETERS, STEP_PX / diameter) * diameter
    clearness = np.zeros(len(offsets))
    rows = {int(index): row for row, index in enumerate(track.frame)}
    for frame in frames:
        row = rows.get(frame.index)
        if row is not None and np.isfinite(track.ball.position_px[row]):
            clearness += _rim_clearness(frame, track, row, offsets)
    best = int(np.argmax(clearness))
    if clearness[best] <= CLEARER * float(np.median(clearness)):
        return track
    anchor = "anchor_x_px" if track.line.upright else "anchor_y_px"
    height = getattr(track.line, anchor) + float(offsets[best])
    return replace(track, line=replace(track.line, **{anchor: height}))


def _rim_clearness(frame: Frame, track: Track, row: int, offsets: Floats) -> Floats:
    """Step of the brightness across the circle, for each offset across the line, shape (n,)."""
    from scipy.ndimage import map_coordinates  # noqa: PLC0415 - not for who only counts

    radius = track.ball_diameter_px / 2
    angle = np.radians(ANGLES_DEG)
    middle = image_point(track.line, float(track.ball.position_px[row]), shift_of(track, row))
    along, across = middle[::-1] if track.line.upright else middle
    picture = (frame.luma.T if track.line.upright else frame.luma).astype(np.float64)

    def brightness(size: float) -> Floats:
        x = np.broadcast_to(along + size * np.cos(angle), (len(offsets), len(angle)))
        y = across + offsets[:, None] + size * np.sin(angle)
        values: Floats = map_coordinates(picture, [y, x], order=1, mode="nearest")
        return values

    step = np.abs(brightness(radius + BESIDE_RIM_PX) - brightness(radius - BESIDE_RIM_PX))
    return np.asarray(step.mean(axis=1), np.float64)


# ---- what is kept of the frames ----------------------------------------------------------------


class SpaceTimeSampler:
    """Takes the line of motion out of each frame."""

    def __init__(self, line: MotionLine, ball_diameter_px: float, shape: tuple[int, int]) -> None:
        """``shape`` is that of the pictures: (height, width)."""
        self._upright = line.upright
        across, along = shape[::-1] if line.upright else shape
        anchor = (line.anchor_x_px, line.anchor_y_px)
        anchor_along, anchor_across = anchor[::-1] if line.upright else anchor
        place = np.arange(along)
        slope = np.tan(np.radians(line.tilt_deg))
        middle = np.rint(anchor_across + slope * (place - anchor_along)).astype(np.intp)
        half = max(1, round(HALF_WIDTH_DIAMETERS * ball_diameter_px))
        aside = np.arange(-half, half + 1)
        self._across = middle + aside[:, None]
        self._along = np.broadcast_to(place, self._across.shape)
        self._size = (across, along)

    def row(self, luma: Luma, shift: Point) -> Luma:
        """Brightness along the line of one picture that lies shifted by x and y, shape (length,).

        Beyond the picture's border its last pixel goes on.
        """
        picture = luma.T if self._upright else luma
        along, across = shift[::-1] if self._upright else shift
        rows = np.clip(self._across + round(across), 0, self._size[0] - 1)
        columns = np.clip(self._along + round(along), 0, self._size[1] - 1)
        row: Luma = np.rint(picture[rows, columns].mean(axis=0)).astype(np.uint8)
        return row


@dataclass(frozen=True)
class ContactFrame:
    """The surroundings of a contact in one frame, enlarged."""

    frame: int
    """Index of the frame it is from."""
    jpeg: bytes


@dataclass
class ContactFrames:
    """The frames just before, at and after each contact, for a person to judge."""

    track: Track
    found: dict[int, list[ContactFrame]] = field(default_factory=lambda: defaultdict(list))
    """Frames of each collision, by its number, in order of time."""
    _wanted: dict[int, list[Collision]] = field(default_factory=lambda: defaultdict(list))

    def want(self, collisions: tuple[Collision, ...]) -> None:
        """Ask for the frames of these collisions, before the first frame comes."""
        for collision in collisions:
            nearest = int(np.argmin(np.abs(self.track.frame - collision.frame)))
            for step in BESIDE:
                if 0 <= nearest + step < len(self.track.frame):
                    index = int(self.track.frame[nearest + step])
                    self._wanted[index].append(collision)

    def take(self, index: int, luma: Luma) -> None:
        """Cut out what is wanted of the next frame, whose brightness has shape (height, width)."""
        for collision in self._wanted.get(index, ()):
            row = int(np.searchsorted(self.track.frame, index))
            cut = _cut(luma, collision, self.track, shift_of(self.track, row))
            _, data = cv2.imencode(".jpg", cut, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
            self.found[collision.number].append(ContactFrame(index, bytes(data)))


def _cut(luma: Luma, collision: Collision, track: Track, shift: Point) -> Luma:
    x, y = image_point(track.line, contact_px(collision, track), shift)
    along = max(16, round(WIDTH_DIAMETERS * track.ball_diameter_px))
    across = max(10, round(HEIGHT_DIAMETERS * track.ball_diameter_px))
    width, height = (across, along) if track.line.upright else (along, across)
    width, height = min(width, luma.shape[1]), min(height, luma.shape[0])
    left = int(np.clip(round(x - width / 2), 0, luma.shape[1] - width))
    top = int(np.clip(round(y - height / 2), 0, luma.shape[0] - height))
    piece = luma[top : top + height, left : left + width]
    scale = SHOWN_WIDTH_PX / width
    size = (SHOWN_WIDTH_PX, max(1, round(height * scale)))
    smooth = cv2.INTER_CUBIC if scale > 1 else cv2.INTER_AREA
    return np.asarray(cv2.resize(np.ascontiguousarray(piece), size, interpolation=smooth), np.uint8)

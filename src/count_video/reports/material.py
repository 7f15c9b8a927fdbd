"""What the evidence is made of: answer and track in units, and what is kept of the frames."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import cv2
import numpy as np

from count_video.records import BodyTrack, Collision, Floats, Frame, Luma, Point, Track, TrialResult

Range = tuple[float, float]


@dataclass(frozen=True)
class States:
    """The state before the first collision of the burst and after each; n states.

    The coordinates are those of G. Galperin (Playing pool with pi, 2003), in which every collision
    without loss is a reflection and the energy is the square of the distance from the origin.
    """

    scaled: Floats
    """V1 = sqrt(M) v1 and V2 = sqrt(m) v2, away from the wall, in units of the first state's
    length, shape (2, n); NaN if unknown."""
    sigma: Floats
    """Standard uncertainties of these, in the same unit, which counts as exact; NaN if unknown."""
    swing_energy: Floats | None
    """Energy of both bodies' heights on their threads, in units of the first state's kinetic one,
    shape (n,); None where no fitted motion shows it."""


@dataclass(frozen=True)
class Material:
    """All that pictures and tables of one clip are made from."""

    result: TrialResult
    track: Track
    lines: list[Luma] = field(default_factory=list)
    """Brightness along the line of motion in the frames of the track that were decoded so far,
    shape (length,) each: the space-time image. Empty of a trial that is planned and not filmed;
    the wall then stands at 0."""
    cuts: dict[int, list[tuple[int, bytes]]] = field(default_factory=lambda: defaultdict(list))
    """The frames before, at and after each contact, by the collision's number: the index of each,
    and its surroundings of the contact, enlarged, as JPEG."""

    def keeping(self, frames: Iterable[tuple[Frame, int]]) -> Iterator[tuple[Frame, int]]:
        """Yield frames and their rows of the track, and keep what pictures and page need."""
        nearest = [int(np.argmin(abs(self.track.frame - c.frame))) for c in self.result.collisions]
        for frame, row in frames:
            self.lines.append(self.line_of_motion(frame.luma, row))
            for collision, own in zip(self.result.collisions, nearest, strict=True):
                if abs(row - own) <= 1:
                    jpeg = self._contact_jpeg(frame.luma, collision, row)
                    self.cuts[collision.number].append((frame.index, jpeg))
            yield frame, row

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
        margin = max(10.0, 0.12 * (times[-1] - times[0]))
        return max(first, times[0] - margin), min(last, times[-1] + margin)

    @cached_property
    def dense_frames(self) -> Range:
        """The shortest stretch of frames that holds 60 % of the burst."""
        times = [collision.frame for collision in self.burst]
        if len(times) < 3:
            return self.shown_frames
        held = max(3, round(0.6 * len(times))) - 1
        low, high = min(zip(times, times[held:], strict=False), key=lambda ends: ends[1] - ends[0])
        margin, (first, last) = 0.06 * (high - low) + 1.0, self.shown_frames
        return max(first, low - margin), min(last, high + margin)

    @cached_property
    def is_dense(self) -> bool:
        """Whether the burst has a part that is worth enlarging: less than half of what is shown."""
        (low, high), (first, last) = self.dense_frames, self.shown_frames
        return high - low < 0.5 * (last - first)

    def shown_places(self, frames: Range) -> Range:
        """Lowest and highest position shown: from the wall to the heavy body's face, and beyond."""
        track = self.track
        inside = (track.frame >= frames[0]) & (track.frame <= frames[1])
        paths = [*self.ball_edges_px, *([] if track.heavy is None else [track.heavy.position_px])]
        values = np.concatenate([path[inside] for path in paths])
        values = values[np.isfinite(values)]
        if values.size == 0:
            return 0.0, float(len(self.lines[0])) if self.lines else 1.0
        beside = 0.35 * track.ball_diameter_px
        return float(values.min()) - beside, float(values.max()) + beside

    @property
    def ball_edges_px(self) -> tuple[Floats, Floats]:
        """Outline of the ball on the line, at smaller and at larger positions, shape (n,) each."""
        ball = self.track.ball
        return ball.position_px + ball.low_edge_px, ball.position_px + ball.high_edge_px

    def contact_px(self, collision: Collision) -> float:
        """Place along the line where the ball touches: its edge turned to heavy body or wall.

        A body alone may have a stop on either side: each pushes it away.
        """
        track = self.track
        low = (track.wall_side == "left") == (collision.kind == "wall")
        if track.heavy is None and collision.push:
            low = collision.push > 0
        return collision.position_px + (track.ball.low_edge_px if low else track.ball.high_edge_px)

    def image_point(self, row: int, position_px: float) -> Point:
        """Image x and y of a position along the line of motion, in the picture of one row."""
        track, line = self.track, self.track.line
        slope = np.tan(np.radians(line.tilt_deg))
        x, y = position_px, line.anchor_y_px + slope * (position_px - line.anchor_x_px)
        if line.upright:
            x, y = line.anchor_x_px + slope * (position_px - line.anchor_y_px), position_px
        for moved in (track.beside_px, track.shift_px):
            x, y = (x, y) if moved is None else (x + moved[row, 0], y + moved[row, 1])
        point = float(x), float(y)
        return point if track.turned is None else track.turned.of(row, point)

    def _face_px(self, heavy: BodyTrack, frames: Sequence[float]) -> Floats:
        """Place of the heavy body's face, seen in part, at some frame coordinates."""
        seen = np.isfinite(heavy.position_px)
        return np.interp(frames, self.track.frame[seen], heavy.position_px[seen])

    def touching(self) -> Material:
        """Shift the heavy body's face to where the ball touches it, in the median.

        Its face is learnt from the picture, and a rim, a shadow or a reflection can pass for it.
        The track is not wrong by that, only shifted by a constant; and the collisions between the
        bodies give the constant, for there the heavy body's face is where the ball's outline is.
        """
        heavy = self.track.heavy
        contacts = [c for c in self.result.collisions if c.kind == "bodies" and c.seen]
        if heavy is None or not contacts or not np.isfinite(heavy.position_px).any():
            return self
        touched = np.array([self.contact_px(c) for c in contacts])
        shift = float(np.median(touched - self._face_px(heavy, [c.frame for c in contacts])))
        return replace(self, track=replace(self.track, heavy=heavy.about(shift)))

    @property
    def speed_scale(self) -> tuple[float, str]:
        """Factor from px a frame to the best unit of speed that is known, and that unit."""
        result = self.result
        length = (result.millimetres_per_px, "mm") if result.millimetres_per_px else (1.0, "px")
        time = (1000.0 / result.capture_fps, "ms") if result.capture_fps else (1.0, "frame")
        unit = f"{length[1]}/{time[1]}"
        return length[0] / time[0], "m/s" if unit == "mm/ms" else unit

    @cached_property
    def states(self) -> States | None:
        """States of the burst; None where the mass ratio or the first state is not known."""
        burst, ratio = self.burst, self.result.mass_ratio
        if not burst or ratio is None:
            return None
        velocities = [burst[0].velocity_before, *(c.velocity_after for c in burst)]
        roots = np.array([[math.sqrt(ratio)], [1.0]])
        scaled = roots * np.transpose([(v.heavy_px_frame, v.ball_px_frame) for v in velocities])
        sigma = roots * np.transpose(
            [(v.heavy_sigma_px_frame, v.ball_sigma_px_frame) for v in velocities]
        )
        length = math.hypot(*scaled[:, 0])
        if not (length > 0 and math.isfinite(length)):
            return None
        raised = self._raised(ratio)
        swing = None if raised is None else raised / length**2
        return States(self.outward * scaled / length, sigma / length, swing)

    def _raised(self, ratio: float) -> Floats | None:
        """Energy of the heights at the first state and all others, in halves of the ball's mass.

        Both bodies first meet where the ball hangs at rest; how far from there the heavy body does,
        and both periods, are those of the fitted motion.
        """
        setup, heavy, burst = self.result.setup, self.track.heavy, self.burst
        if setup is None or heavy is None or not np.isfinite(heavy.position_px).any():
            return None
        states = [burst[0], *burst]
        ball = np.array([one.position_px for one in states])
        face = self._face_px(heavy, [one.frame for one in states])
        ball, face = (self.outward * (place - place[0]) for place in (ball, face))
        periods = setup.heavy_period_frames.value, setup.ball_period_frames.value
        heavy_rate, ball_rate = (2 * math.pi / period for period in periods)
        from_rest = face - setup.bodies_gap_px.value
        return np.asarray(ratio * (heavy_rate * from_rest) ** 2 + (ball_rate * ball) ** 2)

    def line_of_motion(self, luma: Luma, row: int) -> Luma:
        """Brightness along the line of motion in the picture of one row, shape (length,).

        It is averaged over a tenth of the ball's diameter to either side: noise goes, edges stay.
        Beyond the picture's border its last pixel goes on.
        """
        line = self.track.line
        half = max(1, round(0.1 * self.track.ball_diameter_px))
        begin = np.array(self.image_point(row, 0.0))
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

    def _contact_jpeg(self, luma: Luma, collision: Collision, row: int) -> bytes:
        """Cut 2.4 by 1.5 ball diameters around a contact out of the picture of a row, enlarged."""
        x, y = self.image_point(row, self.contact_px(collision))
        sides = [max(10, round(share * self.track.ball_diameter_px)) for share in (2.4, 1.5)]
        width, height = np.minimum(
            sides[::-1] if self.track.line.upright else sides, luma.shape[::-1]
        )
        left = int(np.clip(round(x - width / 2), 0, luma.shape[1] - width))
        top = int(np.clip(round(y - height / 2), 0, luma.shape[0] - height))
        piece = np.ascontiguousarray(luma[top : top + height, left : left + width])
        size = (300, max(1, round(height * (300 / width))))
        smooth = cv2.INTER_CUBIC if width < 300 else cv2.INTER_AREA
        shown = cv2.resize(piece, size, interpolation=smooth)
        return bytes(cv2.imencode(".jpg", shown, [cv2.IMWRITE_JPEG_QUALITY, 82])[1])

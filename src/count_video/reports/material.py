"""What the evidence is made of: a clip's answer, its track, and how to say both in units."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from count_video.records import Collision, Floats, Track, TrialResult

Luma = NDArray[np.uint8]
Point = tuple[float, float]
Range = tuple[float, float]
DENSE_SHARE = 0.6
"""The enlarged stretch is the shortest that holds this share of the burst."""
MARGIN_SHARE = 0.06
"""Of a stretch of frames, shown on either side of it."""
BESIDE_DIAMETERS = 0.35
"""Shown beyond the ball's path, towards the wall and towards the heavy body."""


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
    space_time: SpaceTime
    pendulum: Pendulum | None
    """None where the swing does not show."""

    @property
    def outward(self) -> int:
        """+1 where positions grow away from the wall, -1 where they fall."""
        return 1 if self.track.wall_side == "left" else -1

    @cached_property
    def burst(self) -> tuple[Collision, ...]:
        """The collisions that count, or would if the clip were counted."""
        size = burst_size(self.result)
        return tuple(c for c in self.result.collisions if c.number <= size)

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
            return 0.0, float(self.space_time.image.shape[1])
        beside = BESIDE_DIAMETERS * track.ball_diameter_px
        return float(values.min()) - beside, float(values.max()) + beside


def burst_size(result: TrialResult) -> int:
    """How many of the collisions found belong to the burst, counted or not."""
    return result.count if result.count is not None else result.seen or 0


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

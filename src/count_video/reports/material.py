"""What the evidence is made of: a clip's answer, its track, and how to say both in units."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from count_video.records import Collision, Floats, Track, TrialResult
from count_video.reports.space_time import SpaceTime


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

    @property
    def burst(self) -> tuple[Collision, ...]:
        """The collisions that count, or would if the clip were counted."""
        size = self.result.count if self.result.count is not None else self.result.seen or 0
        return tuple(c for c in self.result.collisions if c.number <= size)


def contact_px(collision: Collision, track: Track) -> float:
    """Place along the line where the ball touches: its edge turned to heavy body or wall."""
    to_wall_low = track.wall_side == "left"
    low = to_wall_low == (collision.kind == "wall")
    edge = track.ball.low_edge_px if low else track.ball.high_edge_px
    return collision.position_px + edge


def heavy_at(material: Material, frame: float) -> float:
    """Place of the heavy body's face at a frame coordinate, between its sightings; else NaN."""
    heavy = material.track.heavy
    if heavy is None:
        return math.nan
    seen = np.isfinite(heavy.position_px)
    if not seen.any():
        return math.nan
    return float(np.interp(frame, material.track.frame[seen], heavy.position_px[seen]))


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
    millimetres = result.millimetres_per_px
    fps = result.capture_fps
    return Scale(
        length=millimetres or 1.0,
        length_unit="mm" if millimetres else "px",
        time=1000.0 / fps if fps else 1.0,
        time_unit="ms" if fps else "frame",
    )


def ball_edges_px(track: Track) -> tuple[Floats, Floats]:
    """Outline of the ball along the line, at smaller and at larger positions, shape (n,) each."""
    ball = track.ball
    return ball.position_px + ball.low_edge_px, ball.position_px + ball.high_edge_px

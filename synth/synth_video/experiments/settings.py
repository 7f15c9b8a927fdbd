"""Which experiment a scene shows, and how it starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from synth_video.looks import require

ExperimentKind = Literal[
    "pi", "bounce", "stops", "pendulum", "pucks", "pendulums", "swing", "throw", "passing", "cradle"
]
NOTHING_TO_COUNT = ("swing", "throw", "passing", "cradle")
"""Experiments in which nothing collides, or more than can be told apart."""


@dataclass(frozen=True)
class ExperimentSettings:
    """What happens; sizes, masses, threads and restitution are those of ``setup``.

    - ``pi``: the ball between cylinder and wall; nothing else of this section matters;
    - ``bounce``: the ball falls on a table;
    - ``stops``: it runs on a level or inclined track, against one stop or between two;
    - ``pendulum``: it swings against the wall;
    - ``pucks``: it slides toward another like it, that lies still;
    - ``pendulums``: it swings toward another like it, that hangs still;
    - ``swing``, ``throw``: it swings or flies, and meets nothing;
    - ``passing``: two like it swing toward each other and back, and never touch;
    - ``cradle``: five like it hang in a row.
    """

    kind: ExperimentKind = "pi"
    start_m: float = 0.3
    """Where the first body starts: height over the table, way to the stop or to the other body, or
    how far a pendulum is drawn aside."""
    speed_m_s: float = 0.0
    """Its velocity at the start, away from the table, the stop or the other body."""
    drift_m_s: float = 0.0
    """Its velocity across, to the right in the picture (``bounce``, ``throw``)."""
    slope: float = 0.0
    """Part of the gravity that drives it to the stop (``stops``): sine of the track's incline. The
    camera is inclined with the track."""
    span_m: float = 0.0
    """From one stop to the other (``stops``); 0 for one stop."""
    offset_m: float = 0.0
    """How far it would miss the other's centre (``pucks``); the least gap (``passing``)."""
    slow_m_s: float = 0.03
    """An impact no faster than this ends the bouncing: the body stays."""
    impacts: int = 0
    """The clip ends half-way to the impact after this one; 0 lets it run for ``duration_s``."""
    duration_s: float = 3.0
    """Longest time that is shown, from the start."""
    held_s: float = 0.0
    """The clip starts so long before the body is let go."""

    def __post_init__(self) -> None:
        for name in ("span_m", "slow_m_s", "impacts", "held_s"):
            require(getattr(self, name) >= 0, f"experiment.{name} must not be negative")
        require(0 <= self.slope <= 1, "experiment.slope must lie between 0 and 1")
        require(self.duration_s > 0, "experiment.duration_s must be positive")

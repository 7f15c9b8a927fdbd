"""What happens in an experiment: where its bodies are at any time, and when they collide."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from count_video.physics.flights import Law, Pendulum
from count_video.physics.setup import Setup
from count_video.records import CollisionKind, Floats

Place = Callable[[Floats], tuple[Floats, Floats]]
"""From times of any shape to distance from the wall and height over the rest line, both in m."""
SPARE_S = 1.0
"""Motions are known so long beyond the time that is shown: an exposure may end after it."""


@dataclass(frozen=True)
class Contact:
    """One collision."""

    time_s: float
    kind: CollisionKind


@dataclass(frozen=True)
class Course:
    """One run of an experiment."""

    contacts: tuple[Contact, ...]
    """In order of time, up to the longest time that may be shown."""
    places: tuple[Place, ...]
    """For each body where its centre is."""
    hangers_m: tuple[float, ...] = ()
    """For each body the distance of its threads' upper ends from the wall; empty without."""


def pendulum_of(setup: Setup, rest_m: float) -> Pendulum:
    """Law of the ball on its thread."""
    thread_m, damping = setup.light_thread_m, setup.light_damping_per_s
    return Pendulum.from_thread(thread_m, setup.gravity_m_s2, damping, rest_m)


def free_run(law: Law, start_m: float, speed_m_s: float = 0.0) -> Callable[[Floats], Floats]:
    """Position, at times of any shape, of a body that is let go at time 0 and meets nothing."""

    def at(times_s: Floats) -> Floats:
        start, speed = np.full_like(times_s, start_m), np.full_like(times_s, speed_m_s)
        return start + law.advance(start, speed, np.maximum(times_s, 0.0))[0]

    return at

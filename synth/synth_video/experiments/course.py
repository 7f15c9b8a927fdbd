"""What happens in an experiment: where its bodies are at any time, and when they collide."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from count_video.physics.flights import Pendulum
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


def swing(law: Pendulum, start_m: float, times_s: Floats) -> Floats:
    """Displacement, at times of any shape, of a pendulum that is let go at time 0."""
    start = np.full_like(times_s, start_m)
    since = np.maximum(times_s, 0.0)
    return start + law.advance_many(start, np.zeros_like(start), since)[0]

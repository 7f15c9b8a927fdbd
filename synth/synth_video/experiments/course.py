"""What happens in an experiment: where its bodies are at any time, and when they collide."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from count_video.physics.laws import Law
from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion
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
    fastest_m_s: float | None = None
    """Greatest speed of a body; None where it is to be read off the places."""


def rise_m(setup: Setup, displacement_m: Floats, thread_m: float) -> Floats:
    """Height gained on the arc of a thread; 0 for bodies that do not hang."""
    if setup.mounting != "suspended":
        return np.zeros_like(displacement_m)
    return thread_m - np.sqrt(np.clip(thread_m**2 - displacement_m**2, 0, None))


def pendulum_of(setup: Setup, rest_m: float) -> Law:
    """Law of the ball on its thread."""
    thread_m, damping = setup.light_thread_m, setup.light_damping_per_s
    return Law.hanging(thread_m, setup.gravity_m_s2, damping, rest_m)


def free_run(law: Law, start_m: float, speed_m_s: float = 0.0) -> Callable[[Floats], Floats]:
    """Position, at times of any shape, of a body that is let go at time 0 and meets nothing."""

    def at(times_s: Floats) -> Floats:
        start, speed = np.full_like(times_s, start_m), np.full_like(times_s, speed_m_s)
        return np.asarray(start + law.advance(start, speed, np.maximum(times_s, 0.0))[0])

    return at


def course_of_trial(motion: Motion, *, rising: bool) -> Course:
    """Course of the ball between cylinder and wall: the ball's centre, then the cylinder's face.

    ``rising``: bodies on threads rise on their arcs, as they do before a camera.
    """
    setup = motion.setup

    def ball(times_s: Floats) -> tuple[Floats, Floats]:
        face_m = motion.sample(times_s.ravel()).ball_far_face_m.reshape(times_s.shape)
        along_m, rest_m = face_m + setup.ball_diameter_m / 2, setup.wall_gap_m
        return along_m, up_m(along_m - (rest_m + setup.ball_diameter_m / 2), setup.light_thread_m)

    def heavy(times_s: Floats) -> tuple[Floats, Floats]:
        along_m = motion.sample(times_s.ravel()).heavy_face_m.reshape(times_s.shape)
        return along_m, up_m(along_m - setup.heavy_rest_m, setup.heavy_thread_m)

    def up_m(aside_m: Floats, thread_m: float) -> Floats:
        return rise_m(setup, aside_m, thread_m) if rising else np.zeros_like(aside_m)

    contacts = tuple(Contact(hit.time_s, hit.kind) for hit in motion.collisions)
    speeds = [(abs(hit.heavy_before_m_s), abs(hit.light_after_m_s)) for hit in motion.collisions]
    fastest_m_s = max((max(pair) for pair in speeds), default=0.0)
    return Course(contacts, (ball, heavy), fastest_m_s=fastest_m_s)

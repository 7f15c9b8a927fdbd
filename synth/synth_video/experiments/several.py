"""Several like bodies without a wall: they collide with each other, or never touch."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.records import Floats
from synth_video.experiments.course import (
    SPARE_S,
    Contact,
    Course,
    Place,
    free_run,
    pendulum_of,
    rise_m,
)
from synth_video.scene import ExperimentSettings

# ---- two discs on a plane ------------------------------------------------------------------------
# Two discs that slide freely on a plane: when they meet, and how they part.
#
# Points of the plane are complex numbers, in metres: what matters of two points is their
# difference, and its length and direction are then at hand. Two free discs meet at most once.

Points = NDArray[np.complex128]


@dataclass(frozen=True)
class Disc:
    """One disc at time 0."""

    mass_kg: float
    radius_m: float
    place_m: complex
    velocity_m_s: complex


@dataclass(frozen=True)
class DiscMotion:
    """Two discs before and after they meet."""

    discs: tuple[Disc, Disc]
    contact_s: float
    """Time at which they touch; inf if they never do."""
    after_m_s: tuple[complex, complex]
    """Velocities after the contact; those before it if there is none."""

    def sample(self, times_s: Floats) -> tuple[Points, Points]:
        """Centres of both at times of any shape, also before time 0."""
        times = np.asarray(times_s, dtype=np.float64)
        until = np.minimum(times, self.contact_s)
        since = times - until
        first, second = (
            disc.place_m + disc.velocity_m_s * until + after * since
            for disc, after in zip(self.discs, self.after_m_s, strict=True)
        )
        return first, second


def collide(first: Disc, second: Disc, restitution: float) -> DiscMotion:
    """Let two smooth discs meet: the impulse acts along the line of their centres.

    Raises
    ------
    UsageError
        If the discs overlap at time 0 or the restitution is not between 0 and 1.
    """
    if not 0.0 <= restitution <= 1.0:
        raise UsageError(f"restitution is {restitution:g}; it must lie between 0 and 1")
    apart = second.place_m - first.place_m
    if abs(apart) < first.radius_m + second.radius_m:
        raise UsageError("the discs overlap at the start; move them apart")
    drift = second.velocity_m_s - first.velocity_m_s
    contact_s = _contact_s(apart, drift, first.radius_m + second.radius_m)
    before = first.velocity_m_s, second.velocity_m_s
    if contact_s == math.inf:
        return DiscMotion((first, second), contact_s, before)
    line = apart + drift * contact_s
    line /= abs(line)
    approach = -(drift * line.conjugate()).real
    push = (1.0 + restitution) * approach / (first.mass_kg + second.mass_kg)
    after = before[0] - second.mass_kg * push * line, before[1] + first.mass_kg * push * line
    return DiscMotion((first, second), contact_s, after)


def _contact_s(apart_m: complex, drift_m_s: complex, reach_m: float) -> float:
    """First time t ≥ 0 with |apart + drift t| = reach; inf if there is none.

    Of the roots of |drift|² t² + 2 b t + c = 0 with b = Re(apart* drift) the smaller is wanted,
    written as c / (−b + root) so that nothing cancels.
    """
    inward = -(apart_m.conjugate() * drift_m_s).real
    beyond = abs(apart_m) ** 2 - reach_m**2
    level = inward**2 - abs(drift_m_s) ** 2 * beyond
    if inward <= 0.0 or level <= 0.0:  # going apart, or past each other; a graze is no push
        return math.inf
    return max(0.0, beyond) / (inward + math.sqrt(level))


# ---- from a scene --------------------------------------------------------------------------------
# Several like bodies without a wall: they collide with each other, or never touch.

CRADLE_BODIES = 5


def two_discs(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let a puck or a cart slide toward another; the point of touch at no offset is at 0."""
    radius_m, mass_kg = setup.ball_diameter_m / 2, setup.light_mass_kg
    first = Disc(mass_kg, radius_m, complex(-radius_m - experiment.start_m, experiment.offset_m),
                 complex(-experiment.speed_m_s, 0.0))  # fmt: skip
    second = Disc(mass_kg, radius_m, complex(radius_m, 0.0), 0j)
    motion = collide(first, second, setup.restitution_bodies)
    contacts = (Contact(motion.contact_s, "bodies"),) if motion.contact_s < math.inf else ()

    def place(body: int) -> Place:
        def at(times_s: Floats) -> tuple[Floats, Floats]:
            points = motion.sample(times_s)[body]
            return points.real.copy(), points.imag.copy()

        return at

    return Course(contacts, (place(0), place(1)))


_FAR_WALL_M = 100.0
"""A wall that no pendulum reaches."""


def two_pendulums(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let a ball swing toward another that hangs at rest beside it, at 0."""
    like = replace(
        setup,
        mounting="suspended",
        heavy_mass_kg=setup.light_mass_kg,
        heavy_thread_m=setup.light_thread_m,
        heavy_damping_per_s=setup.light_damping_per_s,
        wall_gap_m=_FAR_WALL_M,
        release_m=experiment.start_m,
    )
    motion = simulate(like, until_s=SPARE_S + experiment.duration_s)
    contacts = tuple(Contact(hit.time_s, hit.kind) for hit in motion.collisions)
    radius_m = setup.ball_diameter_m / 2

    def left(times_s: Floats) -> tuple[Floats, Floats]:
        aside_m = motion.sample(times_s.ravel()).ball_far_face_m.reshape(times_s.shape)
        aside_m = aside_m - _FAR_WALL_M
        return aside_m - radius_m, rise_m(setup, aside_m, setup.light_thread_m)

    def right(times_s: Floats) -> tuple[Floats, Floats]:
        face_m = motion.sample(times_s.ravel()).heavy_face_m.reshape(times_s.shape)
        aside_m = face_m - like.heavy_rest_m
        return aside_m + like.bodies_gap_m + radius_m, rise_m(setup, aside_m, setup.light_thread_m)

    hangers_m = -radius_m, like.bodies_gap_m + radius_m
    return Course(contacts, (left, right), hangers_m)


def passing(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let two pendulums swing toward each other, up to the least gap, and back."""
    start_m, radius_m = experiment.start_m, setup.ball_diameter_m / 2
    swing = free_run(pendulum_of(setup, 0.0), start_m)
    middle_m = start_m + experiment.offset_m / 2 + radius_m

    def place(side: int) -> Place:
        def at(times_s: Floats) -> tuple[Floats, Floats]:
            aside_m = side * swing(times_s)
            return side * middle_m + aside_m, rise_m(setup, aside_m, setup.light_thread_m)

        return at

    return Course((), (place(-1), place(1)), (-middle_m, middle_m))


def cradle(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let five balls hang in a row and one at the end swing in.

    Equal balls that exchange their velocities move like balls that pass through each other and
    change names: the k-th from the left is always the k-th smallest of five free swings.
    """
    swing = free_run(pendulum_of(setup, 0.0), experiment.start_m)
    bodies = range(CRADLE_BODIES)
    hangers_m = [(body - (CRADLE_BODIES - 1) / 2) * setup.ball_diameter_m for body in bodies]

    def place(body: int) -> Place:
        def at(times_s: Floats) -> tuple[Floats, Floats]:
            aside = swing(times_s)
            # One swings, four rest at 0: it is the last of the row while it is beyond them.
            ends = {0: np.minimum(aside, 0.0), CRADLE_BODIES - 1: np.maximum(aside, 0.0)}
            aside_m = ends.get(body, np.zeros_like(aside))
            return aside_m + hangers_m[body], rise_m(setup, aside_m, setup.light_thread_m)

        return at

    return Course((), tuple(place(body) for body in bodies), tuple(hangers_m))

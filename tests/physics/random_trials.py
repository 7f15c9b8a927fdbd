"""Random trials, simulated once for all the laws that they are held against."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion, simulate

NUMBER = 40
"""Trials of each kind."""


def random_setup(rng: np.random.Generator, *, hung: bool, lossy: bool) -> Setup:
    """Draw bodies on two threads of any length, or free ones; with losses of all kinds, or none."""

    def sometimes(plain: float, low: float, high: float) -> float:
        return plain if rng.random() < 0.3 else float(rng.uniform(low, high))

    release_m = float(rng.uniform(0.02, 0.2))
    setup = Setup(
        heavy_mass_kg=float(np.exp(rng.uniform(np.log(0.5), np.log(200.0)))),
        light_mass_kg=1.0,
        wall_gap_m=release_m * float(rng.uniform(0.0, 1.0)),
        release_m=release_m,
        mounting="suspended" if hung else "free",
        heavy_velocity_m_s=0.0 if hung else float(rng.uniform(-2.0, -0.1)),
    )
    if hung:
        setup = replace(
            setup,
            bodies_gap_m=sometimes(0.0, -0.2 * release_m, 0.5 * release_m),
            heavy_thread_m=sometimes(1.0, 0.3, 2.0),
            light_thread_m=sometimes(1.0, 0.3, 2.0),
        )
    if lossy:
        setup = replace(
            setup,
            heavy_damping_per_s=sometimes(0.0, 0.0, 0.5),
            light_damping_per_s=sometimes(0.0, 0.0, 0.5),
            restitution_bodies=sometimes(1.0, 0.9, 1.0),
            restitution_wall=sometimes(1.0, 0.9, 1.0),
            restitution_bodies_sd=sometimes(0.0, 0.0, 0.02),
            restitution_wall_sd=sometimes(0.0, 0.0, 0.02),
        )
    return setup


@cache
def trials(*, hung: bool, lossy: bool) -> tuple[Motion, ...]:
    """Return simulated trials of one kind."""
    rng = np.random.default_rng([1, hung, lossy])
    return tuple(simulate(random_setup(rng, hung=hung, lossy=lossy), seed=k) for k in range(NUMBER))


def all_trials() -> list[Motion]:
    """Return those of all kinds."""
    return [
        motion
        for hung in (True, False)
        for lossy in (True, False)
        for motion in trials(hung=hung, lossy=lossy)
    ]


def lossless_trials() -> list[Motion]:
    """Return those without losses."""
    return [*trials(hung=True, lossy=False), *trials(hung=False, lossy=False)]

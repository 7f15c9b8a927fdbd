"""What a counted clip should have counted: by its masses alone, and by its threads and losses."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from count_video.errors import UsageError
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.physics.theory import collision_count
from count_video.records import Estimate, FittedSetup, TrialResult

SIGMAS = 2.0
"""A mass ratio lies this many standard uncertainties about its value with a chance of 95 %."""


@dataclass(frozen=True)
class Expected:
    """Counts to hold the counted number against."""

    free: tuple[int, int]
    """Fewest and most collisions of free bodies without losses, within the uncertainty of the mass
    ratio."""
    hanging: int | None
    """The same bodies with the threads, gaps and release of the fit; None where none was made."""
    with_losses: int | None
    """With the restitutions of the fit as well."""


def expected_counts(result: TrialResult) -> Expected | None:
    """Return what the result's own physics says of its count; None without a mass ratio."""
    if result.mass_ratio is None or not result.mass_ratio > 0:
        return None
    low, high = ratio_range(result)
    free = (collision_count(low), collision_count(high))
    if result.setup is None:
        return Expected(free, None, None)
    hung = _as_fitted(result.setup, result.mass_ratio)
    lossy = None
    if hung is not None and result.restitution_bodies and result.restitution_wall:
        lossy = replace(
            hung,
            restitution_bodies=_share(result.restitution_bodies),
            restitution_wall=_share(result.restitution_wall),
        )
    return Expected(free, _count(hung), _count(lossy))


def ratio_range(result: TrialResult) -> tuple[float, float]:
    """Return the mass ratios that are likely, low and high; both alike where it was given."""
    ratio, sigma = result.mass_ratio or math.nan, result.mass_ratio_sigma or 0.0
    reach = min(SIGMAS * sigma, 0.5 * ratio)  # a ratio stays above 0, however little is known
    return ratio - reach, ratio + reach


def _as_fitted(fitted: FittedSetup, mass_ratio: float) -> Setup | None:
    """Return the fitted set-up, lossless; None where it is none.

    The swings are small, hence linear, and no count depends on the units: a px stands for a metre
    and a frame for a second.
    """
    periods = fitted.heavy_period_frames.value, fitted.ball_period_frames.value
    try:
        standard = Setup()
        heavy, ball = (
            standard.gravity_m_s2 * (period / (2.0 * math.pi)) ** 2 for period in periods
        )
        return replace(
            standard,
            heavy_mass_kg=mass_ratio,
            light_mass_kg=1.0,
            heavy_thread_m=heavy,
            light_thread_m=ball,
            wall_gap_m=fitted.gap_px.value,
            bodies_gap_m=fitted.bodies_gap_px.value,
            release_m=fitted.release_px.value,
        )
    except UsageError:  # a fit may leave a period at infinity, where no threads show
        return None


def _count(setup: Setup | None) -> int | None:
    try:
        return None if setup is None else simulate(setup).count
    except UsageError:
        return None


def _share(restitution: Estimate) -> float:
    """Return a restitution as the simulator takes it: a measured one may exceed 1 a little."""
    return min(max(restitution.value, 0.0), 1.0)

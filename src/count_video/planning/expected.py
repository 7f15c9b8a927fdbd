"""What a counted clip should have counted: by its masses alone, and by its threads and losses."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from count_video.errors import UsageError
from count_video.physics.many import ManySetups, simulate_many
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.physics.theory import collision_count
from count_video.planning.request import most_collisions
from count_video.records import FittedSetup, TrialResult

SIGMAS = 2.0
"""A mass ratio lies this many standard uncertainties about its value with a chance of 95 %."""

TOUCHING_SHARE = 1e-6
"""Of the release: a ball that is pressed against the wall hangs at this gap instead."""


@dataclass(frozen=True)
class Expected:
    """Counts to hold the counted number against."""

    free: tuple[int, int]
    """Fewest and most collisions of free bodies without losses, within the uncertainty of the mass
    ratio."""
    hanging: int | None
    """The same bodies with the threads, gaps and release of the fit; None where none was made."""
    with_losses: int | None
    """With the restitutions of the fit as well; None where the bodies would then come to rest on
    each other in ever smaller bounces, of which there is no number."""


def expected_counts(result: TrialResult) -> Expected | None:
    """Return what the result's own physics says of its count; None without a mass ratio."""
    ratio = result.mass_ratio
    if ratio is None or not (math.isfinite(ratio) and ratio > 0):
        return None
    low, high = ratio_range(result)
    free = (collision_count(low), collision_count(high))
    if result.setup is None:
        return Expected(free, None, None)
    hung = _as_fitted(result.setup, ratio)
    lossy = None if hung is None else _with_losses(hung, result)
    most = most_collisions(max(free))
    with_losses = None if lossy is None or _is_endless(lossy, most) else _count(lossy)
    if with_losses is not None and with_losses > most:
        with_losses = None
    return Expected(free, _count(hung), with_losses)


def ratio_range(result: TrialResult) -> tuple[float, float]:
    """Return the mass ratios that are likely, low and high; both alike where it was given."""
    ratio, sigma = result.mass_ratio or math.nan, result.mass_ratio_sigma or 0.0
    # A ratio stays above 0, however little is known of it.
    reach = min(SIGMAS * sigma, 0.5 * ratio) if math.isfinite(sigma) else 0.5 * ratio
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


def _is_endless(setup: Setup, most: int) -> bool:
    """Return whether a set-up has more collisions than any that ends; quick, unlike following it.

    The gap between the bodies, which hardly matters for that, is added to the release.
    """
    try:
        alike = ManySetups.of(
            mass_ratio=setup.heavy_mass_kg / setup.light_mass_kg,
            wall_gap_m=max(setup.wall_gap_m, TOUCHING_SHARE * setup.release_m),
            release_m=setup.release_m + setup.bodies_gap_m,
            heavy_thread_m=setup.heavy_thread_m,
            light_thread_m=setup.light_thread_m,
            restitution_bodies=setup.restitution_bodies,
            restitution_wall=setup.restitution_wall,
        )
    except UsageError:
        return False
    return bool(simulate_many(alike, most).endless[0])


def _count(setup: Setup | None) -> int | None:
    try:
        return None if setup is None else simulate(setup).count
    except UsageError:
        return None


def _with_losses(lossless: Setup, result: TrialResult) -> Setup | None:
    """Return a set-up with the restitutions of a result; None where these are not known."""
    shares = [
        min(max(one.value, 0.0), 1.0)  # a measured one may exceed 1 a little
        for one in (result.restitution_bodies, result.restitution_wall)
        if one is not None and math.isfinite(one.value)
    ]
    if len(shares) < 2:
        return None
    return replace(lossless, restitution_bodies=shares[0], restitution_wall=shares[1])

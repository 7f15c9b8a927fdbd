"""The mass ratio in an answer, and the bounds on pi that rest on it and on the count."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from count_video.physics.theory import pi_bounds
from count_video.records import Estimate, TrialResult

RELATIVE_SIGMA_AT_MOST = 0.1
"""A measured mass ratio is told only if it is known to this share."""
WEIGHED_SHARE = 0.01
"""Standard uncertainty of a mass ratio that somebody gives: kitchen scales, tape on the ball."""
CONTRADICTING_SIGMAS = 4.0
"""Given masses contradict the motion beyond this many standard uncertainties of both."""


def with_masses(result: TrialResult, heavy: Fraction, light: Fraction) -> TrialResult:
    """Complete an answer by masses that the user gave, exact and in any one unit."""
    return _bounded(replace(result, mass_ratio=float(heavy / light)), heavy, light)


def contradiction(given: float, measured: Estimate) -> tuple[str, ...]:
    """Say that a given mass ratio contradicts the motion, as a sentence; empty if it does not."""
    sigma = math.hypot(WEIGHED_SHARE * given, measured.sigma)
    known = measured.sigma <= RELATIVE_SIGMA_AT_MOST * measured.value
    if not known or abs(given - measured.value) <= CONTRADICTING_SIGMAS * sigma:
        return ()
    return (
        f"the masses given have the ratio {given:.4g}, the motion shows {measured.value:.4g} +- "
        f"{measured.sigma:.2g}: check --masses, the cylinder's first",
    )


def with_mass_ratio(result: TrialResult, measured: Estimate) -> TrialResult:
    """Complete an answer by a measured mass ratio, instead of one that was measured before.

    What the user gave stands. A ratio that the motion hardly tells is left out.
    """
    if result.mass_ratio is not None and result.mass_ratio_sigma is None:
        return _bounded(result, result.mass_ratio, 1)
    if measured.sigma > RELATIVE_SIGMA_AT_MOST * measured.value:
        return result
    told = replace(result, mass_ratio=measured.value, mass_ratio_sigma=measured.sigma)
    return _bounded(told, measured.value, 1)


def _bounded(result: TrialResult, heavy: Fraction | float, light: Fraction | float) -> TrialResult:
    """Bound pi by N theta and (N + 1) theta; no count bounds nothing."""
    if not result.count:
        return result
    pi = pi_bounds(result.count, heavy, light)
    return replace(result, pi_low=pi.low, pi_high=pi.high)

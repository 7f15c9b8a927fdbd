"""The mass ratio in an answer, and the bounds on pi that rest on it and on the count."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from count_video.physics.theory import pi_bounds
from count_video.records import Estimate, TrialResult

RELATIVE_SIGMA_AT_MOST = 0.1
"""A measured mass ratio is told only if it is known to this share."""


def with_masses(result: TrialResult, heavy: Fraction, light: Fraction) -> TrialResult:
    """Complete an answer by masses that the user gave, exact and in any one unit."""
    return _bounded(replace(result, mass_ratio=float(heavy / light)), heavy, light)


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

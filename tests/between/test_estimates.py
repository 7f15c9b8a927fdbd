from __future__ import annotations

import numpy as np
import pytest

from count_video.motion.estimates import estimate, mass_ratio, shares_of
from count_video.motion.parameters import FIRST_DEVIATION, Column
from count_video.motion.posterior import Weighed
from count_video.motion.solving import Solution

SIGMA = 0.01
NOTHING = np.zeros(0)


def fit(count: int, lightness: float) -> Solution:
    values = np.zeros(FIRST_DEVIATION)
    values[Column.LIGHTNESS] = lightness
    hessian = np.eye(FIRST_DEVIATION) / SIGMA**2
    return Solution(count, values, 0.0, hessian, NOTHING, NOTHING)


def weighed(*fits: tuple[int, float, float]) -> Weighed:
    """Weigh fits of a count, an evidence and a lightness, each with a scatter of its own."""
    pairs = enumerate(fits)
    return {(n, 0.001 * place): (evidence, fit(n, value)) for place, (n, evidence, value) in pairs}


def test_a_single_fit_is_given_as_it_is() -> None:
    one = weighed((31, 5.0, -4.6))
    stated = estimate(one, shares_of(one, {31: 1.0}), Column.LIGHTNESS)
    assert stated.value == pytest.approx(-4.6)
    assert stated.sigma == pytest.approx(SIGMA)


def test_within_a_count_the_evidence_decides() -> None:
    two = weighed((31, 0.0, -4.6), (31, np.log(3.0), -4.5))
    assert shares_of(two, {31: 1.0}) == pytest.approx([0.25, 0.75])


def test_between_counts_their_chances_decide() -> None:
    two = weighed((31, 50.0, -4.6), (33, 0.0, -4.5))
    assert shares_of(two, {31: 0.6, 33: 0.4}) == pytest.approx([0.6, 0.4])


def test_fits_that_disagree_make_the_estimate_less_sure() -> None:
    apart = 0.2
    two = weighed((311, 0.0, -9.2), (313, 0.0, -9.2 - apart))
    stated = estimate(two, shares_of(two, {311: 0.5, 313: 0.5}), Column.LIGHTNESS)
    assert stated.value == pytest.approx(-9.2 - apart / 2)
    assert stated.sigma == pytest.approx(np.hypot(SIGMA, apart / 2))


def test_the_mass_ratio_has_the_relative_uncertainty_of_the_lightness() -> None:
    one = weighed((31, 0.0, -np.log(100.0)))
    ratio = mass_ratio(one, shares_of(one, {31: 1.0}))
    assert ratio.value == pytest.approx(100.0)
    assert ratio.sigma == pytest.approx(100.0 * SIGMA)

from __future__ import annotations

import numpy as np
import pytest

from count_video.motion.estimates import estimate, mass_ratio, mixed
from count_video.motion.parameters import FIRST_DEVIATION, Column
from count_video.motion.posterior import Weighed, probabilities, shares_of
from count_video.motion.priors import BELIEVED
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
    stated = estimate(one, shares_of(one), Column.LIGHTNESS)
    assert stated.value == pytest.approx(-4.6)
    assert stated.sigma == pytest.approx(SIGMA)


def test_a_part_of_the_evidence_decides_between_explanations() -> None:
    two = weighed((31, 0.0, -4.6), (31, np.log(3.0) / BELIEVED, -4.5))
    assert shares_of(two) == pytest.approx([0.25, 0.75])


def test_a_count_has_the_probability_of_all_its_explanations() -> None:
    three = weighed((31, 0.0, -4.6), (33, 0.0, -4.5), (31, 0.0, -4.7))
    assert probabilities(three) == pytest.approx({31: 2 / 3, 33: 1 / 3})


def test_what_explanations_disagree_in_is_a_part_of_the_uncertainty() -> None:
    values = np.array([[1.0, 5.0], [3.0, 5.0]])
    mean, sigma = mixed(np.array([0.75, 0.25]), values, np.full((2, 2), SIGMA**2))
    assert mean == pytest.approx([1.5, 5.0])
    assert sigma == pytest.approx([np.hypot(SIGMA, np.sqrt(0.75 * 0.25) * 2.0), SIGMA])


def test_fits_that_disagree_make_the_estimate_less_sure() -> None:
    apart = 0.2
    two = weighed((311, 0.0, -9.2), (313, 0.0, -9.2 - apart))
    stated = estimate(two, shares_of(two), Column.LIGHTNESS)
    assert stated.value == pytest.approx(-9.2 - apart / 2)
    assert stated.sigma == pytest.approx(np.hypot(SIGMA, apart / 2))


def test_the_mass_ratio_has_the_relative_uncertainty_of_the_lightness() -> None:
    one = weighed((31, 0.0, -np.log(100.0)))
    ratio = mass_ratio(one, shares_of(one))
    assert ratio.value == pytest.approx(100.0)
    assert ratio.sigma == pytest.approx(100.0 * SIGMA)

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from count_video.motion.parameters import FIRST_DEVIATION, Column
from count_video.motion.posterior import mixed, setup_estimates, shares_of
from count_video.records import Floats

SIGMA = 0.01


@dataclass
class Weighed:
    """What a fit with some restitution of the bodies says."""

    count: int
    evidence: float
    restitution: float = 1.0
    lightness: float = 0.0
    data: Floats = field(default_factory=lambda: np.zeros(1))
    correlations: Floats = field(default_factory=lambda: np.eye(1))

    @property
    def values(self) -> Floats:
        values = np.zeros(FIRST_DEVIATION)
        values[Column.BODIES], values[Column.LIGHTNESS] = self.restitution, self.lightness
        return values

    @property
    def covariance(self) -> Floats:
        return np.eye(FIRST_DEVIATION) * SIGMA**2

    def correlated(self, values: Floats) -> Floats:
        return self.correlations @ values


def test_a_single_fit_is_given_as_it_is() -> None:
    _, bodies, *_ = setup_estimates([Weighed(31, 5.0, 0.96)])
    assert bodies.value == pytest.approx(0.96)
    assert bodies.sigma == pytest.approx(SIGMA)


def shares_of_two(difference: Floats, lasts_frames: float) -> Floats:
    """One is likelier by a factor of 3; both differ by some standard deviations in each frame."""
    clock = np.arange(float(len(difference)))
    correlations = np.exp(-np.abs(clock[:, None] - clock) / lasts_frames)
    likelier = Weighed(31, np.log(3.0), data=np.zeros_like(difference), correlations=correlations)
    return shares_of([likelier, Weighed(33, 0.0, data=difference)])


def test_evidence_holds_where_errors_are_new_in_every_frame() -> None:
    assert shares_of_two(np.ones(40), lasts_frames=1e-3) == pytest.approx([0.75, 0.25])


def test_errors_that_last_make_lasting_differences_prove_little() -> None:
    likelier, other = shares_of_two(np.ones(40), lasts_frames=1e3)
    assert likelier == pytest.approx(other, rel=0.05)


def test_errors_that_last_take_nothing_from_what_changes_from_frame_to_frame() -> None:
    shares = shares_of_two((-1.0) ** np.arange(40), lasts_frames=8.0)
    assert shares == pytest.approx([0.75, 0.25])


def test_what_explanations_disagree_in_is_a_part_of_the_uncertainty() -> None:
    values = np.array([[1.0, 5.0], [3.0, 5.0]])
    mean, sigma = mixed(np.array([0.75, 0.25]), values, np.full((2, 2), SIGMA**2))
    assert mean == pytest.approx([1.5, 5.0])
    assert sigma == pytest.approx([np.hypot(SIGMA, np.sqrt(0.75 * 0.25) * 2.0), SIGMA])


def test_fits_that_disagree_make_the_estimate_less_sure() -> None:
    apart = 0.2
    _, bodies, *_ = setup_estimates([Weighed(311, 0.0, 0.96), Weighed(313, 0.0, 0.96 - apart)])
    assert bodies.value == pytest.approx(0.96 - apart / 2)
    assert bodies.sigma == pytest.approx(np.hypot(SIGMA, apart / 2))


def test_the_mass_ratio_has_the_relative_uncertainty_of_the_lightness() -> None:
    ratio, *_ = setup_estimates([Weighed(31, 0.0, 0.96, lightness=-np.log(100.0))])
    assert ratio.value == pytest.approx(100.0)
    assert ratio.sigma == pytest.approx(100.0 * SIGMA)

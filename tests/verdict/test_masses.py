"""Which mass ratio an answer gives, and what follows for pi."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from count_video.records import Estimate, TrialResult
from count_video.verdict.answers import (
    RELATIVE_SIGMA_AT_MOST,
    contradiction,
    unread_result,
    with_mass_ratio,
    with_masses,
)

COUNTED = replace(unread_result(str(Path("a.mp4")), ""), status="counted", count=31)
ROUNDING = 1e-9


def bounds(ratio: float) -> tuple[float, float]:
    theta = math.atan(math.sqrt(1 / ratio))
    return 31 * theta, 32 * theta


def stated(result: TrialResult) -> tuple[float | None, float | None]:
    return result.mass_ratio, result.mass_ratio_sigma


def test_a_later_measurement_takes_the_place_of_an_earlier_one_and_bounds_pi() -> None:
    first = with_mass_ratio(COUNTED, Estimate(102.0, 0.9))
    second = with_mass_ratio(first, Estimate(100.0, 0.3))
    assert stated(second) == (100.0, 0.3)
    assert (second.pi_low, second.pi_high) == pytest.approx(bounds(100.0), rel=ROUNDING)


def test_masses_that_were_given_stand() -> None:
    given = with_masses(COUNTED, Fraction("1.050"), Fraction("0.0105"))
    after = with_mass_ratio(given, Estimate(97.0, 0.3))
    assert stated(after) == (100.0, None)
    assert (after.pi_low, after.pi_high) == pytest.approx(bounds(100.0), rel=ROUNDING)


def test_a_count_that_changes_moves_the_bounds_though_the_masses_stand() -> None:
    given = with_masses(replace(COUNTED, count=30), Fraction(100), Fraction(1))
    after = with_mass_ratio(replace(given, count=31), Estimate(97.0, 0.3))
    assert (after.pi_low, after.pi_high) == pytest.approx(bounds(100.0), rel=ROUNDING)


def test_a_ratio_that_is_hardly_measured_is_left_out() -> None:
    vague = Estimate(100.0, 1.01 * RELATIVE_SIGMA_AT_MOST * 100.0)
    assert stated(with_mass_ratio(COUNTED, vague)) == (None, None)


def test_without_a_count_nothing_bounds_pi() -> None:
    open_still = with_mass_ratio(replace(COUNTED, count=None), Estimate(100.0, 0.3))
    assert stated(open_still) == (100.0, 0.3)
    assert open_still.pi_low is open_still.pi_high is None


@pytest.mark.parametrize(
    ("given", "measured", "clash"),
    [
        (100.0, Estimate(100.5, 0.2), False),
        (10.0, Estimate(15.9, 0.1), True),
        (100.0, Estimate(103.0, 0.1), False),  # within what scales and tape leave
        (10.0, Estimate(15.9, 4.0), False),  # the motion hardly shows it
    ],
)
def test_masses_that_contradict_the_motion_are_named(
    given: float, measured: Estimate, clash: bool
) -> None:
    said = contradiction(given, measured)
    assert len(said) == clash
    assert all("--masses" in sentence for sentence in said)

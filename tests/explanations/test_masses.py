"""Which mass ratio an answer gives, and what follows for pi."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from explained import at_a_wall, bouncing

from count_video.answers import RELATIVE_SIGMA_AT_MOST, answer, measured_ratios, weighed
from count_video.motion.priors import SWING_RATIO_SHARE
from count_video.motion.swing import Swing
from count_video.records import (
    Estimate,
    FootageInfo,
    FootageReport,
    TrialResult,
)
from count_video.settings import TrialSettings

COUNTED = TrialResult("a.mp4", "counted", "", count=31)
ROUNDING = 1e-9


def bounds(ratio: float) -> tuple[float, float]:
    theta = math.atan(math.sqrt(1 / ratio))
    return 31 * theta, 32 * theta


def stated(result: TrialResult) -> tuple[float | None, float | None]:
    return result.mass_ratio, result.mass_ratio_sigma


def test_the_best_measurement_bounds_pi() -> None:
    result = weighed(COUNTED, [Estimate(100.0, 0.3), Estimate(102.0, 0.9)], None)
    assert stated(result) == (100.0, 0.3)
    assert (result.pi_low, result.pi_high) == pytest.approx(bounds(100.0), rel=ROUNDING)


def test_masses_that_were_given_stand() -> None:
    given = weighed(COUNTED, [Estimate(97.0, 0.3)], (Fraction("1.050"), Fraction("0.0105")))
    assert stated(given) == (100.0, None)
    assert (given.pi_low, given.pi_high) == pytest.approx(bounds(100.0), rel=ROUNDING)


def test_a_ratio_that_is_hardly_measured_is_left_out() -> None:
    vague = Swing(100.0, 1.01 * RELATIVE_SIGMA_AT_MOST, 0.0, 0.0, 0.0, 100, fits=True)
    sharp = replace(vague, mass_ratio_relative_sigma=0.01)
    trial = at_a_wall(path_shows=True)
    assert trial.found is not None

    known_by_swing = Estimate(100.0, 100.0 * math.hypot(0.01, SWING_RATIO_SHARE))
    for swing, known in ((vague, []), (sharp, [known_by_swing])):
        found: Any = SimpleNamespace(path_fits=True, swing=swing)
        assert measured_ratios(replace(trial, found=found)) == known
    assert stated(weighed(COUNTED, [], None)) == (None, None)


def test_without_a_count_nothing_bounds_pi() -> None:
    open_still = weighed(replace(COUNTED, count=None), [Estimate(100.0, 0.3)], None)
    assert stated(open_still) == (100.0, 0.3)
    assert open_still.pi_low is open_still.pi_high is None


@pytest.mark.parametrize(
    ("given", "measured", "clash"),
    [
        (100.0, [Estimate(100.5, 0.2)], False),
        (10.0, [Estimate(15.9, 0.1)], True),
        (100.0, [Estimate(103.0, 0.1)], False),  # within what scales and tape leave
        (10.0, [], False),  # the motion hardly shows it
    ],
)
def test_masses_that_contradict_the_motion_are_named(
    given: float, measured: list[Estimate], clash: bool
) -> None:
    said = weighed(COUNTED, measured, (Fraction(given), Fraction(1))).warnings
    assert len(said) == clash
    assert all("--masses" in sentence for sentence in said)


@pytest.mark.parametrize("masses", [(Fraction(100), Fraction(1)), None])
def test_masses_say_nothing_of_one_body_alone(masses: tuple[Fraction, Fraction] | None) -> None:
    info = FootageInfo(Path("a.mp4"), 64, 64, 0, None, 30.0, None, "unknown")
    report = FootageReport(40, None, ())
    result = answer(bouncing(4), info, report, TrialSettings(masses=masses))
    assert (result.count, *stated(result), result.pi_low) == (4, None, None, None)
    assert sum("--masses" in warning for warning in result.warnings) == (masses is not None)


@pytest.mark.parametrize("counts", [True, False])
def test_without_a_count_no_mass_ratio_is_measured(counts: bool) -> None:
    info = FootageInfo(Path("a.mp4"), 64, 64, 0, None, 30.0, None, "unknown")
    trial = at_a_wall(path_shows=True, counts=counts)
    swing = Swing(100.0, 0.01, 0.0, 0.0, 0.0, 100, fits=True)
    found: Any = SimpleNamespace(path_fits=True, swing=swing)
    report = FootageReport(40, None, ())
    result = answer(replace(trial, found=found), info, report, TrialSettings())
    assert (result.mass_ratio is not None) == counts


@pytest.mark.parametrize(("most", "said"), [(0.98, False), (1.05, False), (1.3, True)])
def test_energy_that_bodies_gain_is_said(most: float, said: bool) -> None:
    unknown: Any = None
    setup: Any = SimpleNamespace(ball_period_frames=Estimate(100.0, 1.0))
    fit: Any = SimpleNamespace(
        energy_kept=(0.99, most, 0.97),
        restitution_bodies=unknown,
        restitution_wall=unknown,
        ending=unknown,
        setup=setup,
        mass_ratio=Estimate(16.0, 0.1),
    )
    trial = replace(at_a_wall(path_shows=True, counts=True), found=None, fit=fit)
    info = FootageInfo(Path("a.mp4"), 640, 240, 0, None, 30.0, None, "unknown")
    result = answer(trial, info, FootageReport(40, 40, ()), TrialSettings())
    assert any("gain energy (up to 130%" in one for one in result.warnings) is said

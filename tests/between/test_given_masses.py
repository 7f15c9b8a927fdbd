"""Masses that are given narrow a count down, unless the motion contradicts them."""

from __future__ import annotations

from functools import cache

import pytest
from synthetic_tracks import Filming, film

from count_video.motion.fitted import Between, fit_burst
from count_video.motion.parameters import CONTRADICTING_SIGMAS, Knowledge
from count_video.motion.priors import SHOWN_RATIO_SHARE
from count_video.motion.seen import seen_collisions
from count_video.physics.setup import Setup
from count_video.reasons import Cause, Reason
from count_video.records import Estimate
from tiers import rest_slow

SETUP = Setup(wall_gap_m=0.03, bodies_gap_m=0.002, restitution_bodies=0.98, restitution_wall=0.97)
RATIO = SETUP.heavy_mass_kg / SETUP.light_mass_kg
FPS, NOISE_PX = 240.0, 0.15
SIGMAS = 4.0
"""Of 10 000 independent values none is so far off."""


@cache
def fitted(given: float | None) -> Between:
    track = film(SETUP, Filming(FPS, clock_phase=0.3, noise_px=NOISE_PX), 1).track
    fit = fit_burst(track, seen_collisions(track), Knowledge(FPS, given))
    assert isinstance(fit, Between)
    assert fit.shown < fit.count
    return fit


def test_masses_that_the_motion_bears_out_make_the_count_surer() -> None:
    given, free = fitted(RATIO), fitted(None)
    assert given.count == free.count
    assert given.probability[given.count] > free.probability[free.count]


@pytest.mark.parametrize("given", [RATIO, None])
def test_the_fit_has_the_ratio_of_the_trial(given: float | None) -> None:
    shown = fitted(given).mass_ratio
    assert abs(shown.value - RATIO) < SIGMAS * shown.sigma


@pytest.mark.parametrize("given", [0.97 * RATIO, 1.03 * RATIO])
def test_masses_that_hinder_the_fit_do_not_hide_what_the_places_show(given: float) -> None:
    shown = fitted(given).mass_ratio
    assert not Knowledge(FPS, given).contradicts(shown)
    assert shown == fitted(None).mass_ratio


@pytest.mark.parametrize("given", rest_slow([1e4, None]))
def test_more_collisions_than_are_sought_are_not_counted(
    given: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    track = film(SETUP, Filming(FPS, clock_phase=0.3, noise_px=NOISE_PX), 1).track
    monkeypatch.setattr("count_video.motion.fitted.MOST_COLLISIONS", 40)
    fit = fit_burst(track, seen_collisions(track), Knowledge(FPS, given))
    assert fit == Reason(Cause.TOO_MANY, (40,))


def test_a_cylinder_much_lighter_than_the_ball_is_not_fitted() -> None:
    light = Setup(heavy_mass_kg=0.0035, light_mass_kg=0.0105, wall_gap_m=0.03)
    track = film(light, Filming(FPS, clock_phase=0.3, noise_px=NOISE_PX), 1).track
    fit = fit_burst(track, seen_collisions(track), Knowledge(FPS))
    assert fit == Reason(Cause.LIGHTER)


@pytest.mark.parametrize("given", rest_slow([0.9 * RATIO, 1.0, 0.8 * RATIO, 1.2 * RATIO], quick=2))
def test_masses_that_the_motion_contradicts_are_left_out_of_account(given: float) -> None:
    assert fitted(given) == fitted(None)
    assert Knowledge(FPS, given).contradicts(fitted(given).mass_ratio)


def test_a_ratio_is_contradicted_beyond_the_uncertainty_of_what_shows() -> None:
    shown = Estimate(100.0, 0.1)
    allowed = CONTRADICTING_SIGMAS * SHOWN_RATIO_SHARE * shown.value
    assert not Knowledge(mass_ratio=shown.value + 0.99 * allowed).contradicts(shown)
    assert Knowledge(mass_ratio=shown.value + 1.02 * allowed).contradicts(shown)
    assert not Knowledge().contradicts(shown)

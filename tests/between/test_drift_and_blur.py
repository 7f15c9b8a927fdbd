from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic_tracks import FilmedTrial, Filming, film

from count_video.motion.exposures import blur_of
from count_video.motion.fitted import Between, fit_burst
from count_video.motion.parameters import DRIFTS, FIRST_DEVIATION, Column, Knowledge, drift_shape
from count_video.motion.pendulums import follow
from count_video.motion.seen import seen_collisions
from count_video.physics.setup import Setup
from count_video.records import Floats, Track

FPS = 480.0
SETUP = Setup(wall_gap_m=0.03, bodies_gap_m=0.002, restitution_bodies=0.98, restitution_wall=0.97)
DRIFT_PX = 0.06
"""As large as rendered clips have it where ball, wall and heavy body are close."""
DRIFT_REACH_PX = 8.0
ESTIMATE_SIGMAS = 4.0
MOMENTS_SHARE = 0.005
"""Sixteen moments give the spread of a uniform path to a part in 2 * 16**2."""


def test_the_drift_is_whole_at_the_nearest_place_and_none_far_away() -> None:
    shape = drift_shape(np.array([3.0, 400.0, 2000.0, np.nan]))
    assert np.array_equal(shape[0], np.ones(DRIFTS))
    assert 0 < shape[1].sum() < DRIFTS
    assert not shape[2:].any()


def test_the_drift_falls_steadily_along_the_path() -> None:
    shape = drift_shape(np.linspace(0.0, 600.0, 500))
    assert (np.diff(shape, axis=0) <= 0).all()
    assert ((shape >= 0) & (shape <= 1)).all()


def test_an_outline_that_drifts_near_the_wall_changes_neither_count_nor_mass_ratio() -> None:
    trial = film(SETUP, Filming(FPS, clock_phase=0.3), seed=1)
    between = fit_burst(drifting(trial), seen_collisions(drifting(trial)), Knowledge(FPS))
    assert isinstance(between, Between)
    assert between.count == trial.count
    ratio = between.mass_ratio
    true_ratio = SETUP.heavy_mass_kg / SETUP.light_mass_kg
    assert abs(ratio.value - true_ratio) < ESTIMATE_SIGMAS * ratio.sigma


def drifting(trial: FilmedTrial) -> Track:
    """Let the cylinder's outline be seen too far out where it is near the wall."""
    heavy = trial.track.heavy
    assert heavy is not None
    far = heavy.position_px - np.nanmin(heavy.position_px)
    drifted = heavy.position_px + DRIFT_PX * np.exp(-far / DRIFT_REACH_PX)
    return replace(trial.track, heavy=replace(heavy, position_px=drifted))


@pytest.mark.parametrize("exposure", [0.2, 0.9])
def test_the_blur_of_a_free_ball_is_that_of_a_uniform_path(exposure: float) -> None:
    values = resting(exposure)
    frame = np.arange(10.0, 20.0)
    paths = follow(values[None], 1, -5.0)
    speed = abs(paths.states[3, 0, 1])
    expected = speed * exposure / np.sqrt(12)
    assert np.allclose(blur_of(paths, values, frame), expected, rtol=MOMENTS_SHARE)


def test_a_ball_at_rest_is_not_blurred() -> None:
    values = resting(0.5)
    assert np.allclose(blur_of(follow(values[None], 1, -5.0), values, np.array([-4.0, -3.0])), 0.0)


def resting(exposure: float) -> Floats:
    """Give a motion whose threads are so long that the ball flies straight after its first hit."""
    values = np.zeros(FIRST_DEVIATION)
    values[Column.HEAVY] = values[Column.BALL_REST] = 500.0
    values[Column.HEAVY_RATE] = -2.0
    values[Column.SWING] = np.log(1e-5)
    values[Column.EXPOSURE], values[Column.LIGHTNESS] = exposure, -np.log(100.0)
    values[Column.BODIES] = values[Column.BOUNCE] = 1.0
    return values

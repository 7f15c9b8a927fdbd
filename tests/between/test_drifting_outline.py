from __future__ import annotations

from dataclasses import replace

import numpy as np
from synthetic_tracks import FilmedTrial, Filming, film

from count_video.motion.fitted import Between, fit_burst
from count_video.motion.parameters import Knowledge
from count_video.motion.seen import seen_collisions
from count_video.physics.setup import Setup
from count_video.records import Track

FPS = 480.0
SETUP = Setup(wall_gap_m=0.03, bodies_gap_m=0.002, restitution_bodies=0.98, restitution_wall=0.97)
DRIFT_PX = 0.06
"""As large as rendered clips have it where ball, wall and heavy body are close."""
DRIFT_REACH_PX = 8.0
ESTIMATE_SIGMAS = 4.0


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

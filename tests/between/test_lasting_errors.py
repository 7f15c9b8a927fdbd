from __future__ import annotations

from dataclasses import replace

import numpy as np
from synthetic_tracks import FilmedTrial, Filming, film, setup_of

from count_video.motion.fitted import Between, fit_burst
from count_video.motion.parameters import Knowledge
from count_video.motion.seen import seen_collisions
from count_video.records import BodyTrack

LASTS_FRAMES, SIGMA_PX = 8.0, 0.1
TRIALS = 8


def with_lasting_errors(body: BodyTrack, rng: np.random.Generator) -> BodyTrack:
    keeps, error, errors = np.exp(-1 / LASTS_FRAMES), 0.0, []
    for new in rng.normal(0.0, SIGMA_PX, len(body.position_px)):
        error = keeps * error + np.sqrt(1 - keeps**2) * new
        errors.append(error)
    return replace(body, position_px=body.position_px + np.array(errors))


def filmed(seed: int) -> FilmedTrial:
    rng = np.random.default_rng([seed, 8])
    setup = setup_of(rng, 0.0, float(rng.uniform(9.0, 30.0)), least_restitution=0.95)
    trial = film(setup, Filming(480.0, noise_px=0.02, clock_phase=float(rng.random())), seed)
    track = trial.track
    assert track.heavy is not None
    ball, heavy = (with_lasting_errors(body, rng) for body in (track.ball, track.heavy))
    return replace(trial, track=replace(track, ball=ball, heavy=heavy))


def test_uncertainties_hold_errors_of_places_that_last() -> None:
    times, ratios = [], []
    for trial in map(filmed, range(TRIALS)):
        fit = fit_burst(trial.track, seen_collisions(trial.track), Knowledge(480.0))
        assert isinstance(fit, Between)
        assert fit.count == trial.count
        found = [(one.frame, one.frame_sigma) for one in fit.collisions]
        times += [(f - true) / s for (f, s), true in zip(found, trial.event_frames, strict=True)]
        setup = trial.motion.setup
        true = setup.heavy_mass_kg / setup.light_mass_kg
        ratios.append((fit.mass_ratio.value - true) / fit.mass_ratio.sigma)
    assert 0.75 < np.sqrt(np.mean(np.square(times))) < 1.3
    assert 0.5 < np.sqrt(np.mean(np.square(ratios))) < 1.7

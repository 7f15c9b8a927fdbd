from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic_tracks import FilmedTrial, Filming, film, random_setup, setup_of

from count_video.explanations import at_wall
from count_video.motion.fitted import Between, fit_burst
from count_video.motion.parameters import Knowledge
from count_video.motion.seen import seen_collisions
from count_video.records import BodyTrack
from tiers import rest_slow

LASTS_FRAMES, SIGMA_PX = 8.0, 0.1
TRIALS = 8
SWAY_PX, TREMBLE_SHARE = (0.5, 1.0, 2.0, 4.0), 0.2
"""How far a camera sways, and how much of it is a tremble."""
SWAYING = (6, 10), (16, 22)
"""Seeds of trials; where what a sway leaves unexplained counts as white noise all are wrong."""


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


def swaying(seed: int) -> FilmedTrial:
    """A trial before a background that shows nothing, filmed by hand."""
    rng = np.random.default_rng([seed, 99])
    setup = random_setup(rng)
    trial = film(setup, Filming(480.0, clock_phase=float(rng.random())), seed)
    track, frame = trial.track, trial.track.frame
    size_px = float(rng.choice(SWAY_PX))
    slow, fast = (
        share * size_px * np.sin(2 * np.pi * frame / rng.uniform(*periods) + rng.uniform(0, 6))
        for share, periods in ((1.0, (120, 400)), (TREMBLE_SHARE, (25, 60)))
    )
    assert track.heavy is not None
    ball, heavy = (
        replace(body, position_px=body.position_px + slow + fast)
        for body in (track.ball, track.heavy)
    )
    return replace(trial, track=replace(track, ball=ball, heavy=heavy))


@pytest.mark.parametrize("seeds", rest_slow([(seeds,) for seeds in SWAYING]))
def test_counts_are_claimed_no_surer_than_they_are_while_the_camera_sways(
    seeds: tuple[int, ...],
) -> None:
    wrong, chances = 0, []
    for trial in map(swaying, seeds):
        explained = at_wall(trial.track, Knowledge(480.0))
        if explained.counts:
            wrong += explained.count != trial.count
            chances.append(1 - explained.probability[explained.count])
    chance = np.array(chances)
    assert len(chance) >= len(seeds) / 2
    assert wrong <= chance.sum() + 2 * np.sqrt((chance * (1 - chance)).sum())

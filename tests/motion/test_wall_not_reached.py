"""Balls that their threads bring back before they reach the wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filmed_trials import FilmedTrial, Filming, film

from count_video.explanations import Explanation
from count_video.motion.fitted import NOTHING_KNOWN
from count_video.motion.gaps import gaps_of, turns_alone
from count_video.physics.setup import Setup
from count_video.scenes import of_pair

LIGHT_KG = 0.0105
LEAD_FRAMES, TAIL_FRAMES = 130, 130


def filmed(setup: Setup, seed: int = 0) -> FilmedTrial:
    filming = Filming(240.0, lead_frames=LEAD_FRAMES, tail_frames=TAIL_FRAMES)
    return film(setup, filming, seed)


def explained(trial: FilmedTrial) -> Explanation:
    return of_pair(trial.track, NOTHING_KNOWN, lambda _: (False, False))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("mass_ratio", [1.0, 3.0])
def test_bodies_that_meet_far_from_the_wall_are_counted_without_it(
    mass_ratio: float, seed: int
) -> None:
    """The ball's thread brings it back before it strikes the wall."""
    short = Setup(heavy_mass_kg=mass_ratio * LIGHT_KG, wall_gap_m=0.05, release_m=0.03)
    trial = filmed(short, seed)
    assert "wall" not in trial.kinds

    found = explained(trial)

    assert (found.scene, found.counts, found.count) == ("bodies", True, trial.motion.count)


@pytest.mark.parametrize("wall_gap_m", [0.01, 0.03, 0.05])
@pytest.mark.parametrize("unseen", [0, 5])
def test_a_ball_that_strikes_the_wall_does_not_turn_by_itself(
    wall_gap_m: float, unseen: int
) -> None:
    trial = filmed(Setup(heavy_mass_kg=LIGHT_KG, wall_gap_m=wall_gap_m))
    first, wall, second = trial.frames[:3]
    place = trial.track.ball.position_px.copy()
    place[np.abs(trial.track.frame - wall) < unseen / 2] = np.nan
    track = replace(trial.track, ball=replace(trial.track.ball, position_px=place))

    assert not turns_alone(gaps_of(track), (float(first), float(second)))

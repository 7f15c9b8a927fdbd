"""Planned set-ups, rendered and counted: they give the planned count and the planned set-up."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from planned_study import outcome_of

from count_video.planning.comparison import DIAMETER_SIGMA_PX

PLANS = 20
WITHIN_SIGMAS = 3.0
"""Of a hundred normal errors fewer than one lies beyond this, ..."""
BEYOND_SHARE = 0.03
"""... and a few more where places hang together from frame to frame."""


def test_a_planned_clip_gives_the_planned_count_and_set_up(tmp_path: Path) -> None:
    outcome = outcome_of(2, tmp_path, close=False)
    assert outcome.counted == outcome.planned
    assert outcome.explained_by == ()
    off = [abs(error) / sigma for error, sigma in outcome.quantities.values()]
    assert len(off) == 8
    assert max(off) <= WITHIN_SIGMAS


@pytest.mark.slow
def test_twenty_planned_clips_give_the_planned_counts_and_set_ups(tmp_path: Path) -> None:
    outcomes = [outcome_of(seed, tmp_path, close=False) for seed in range(PLANS)]
    assert [one.counted for one in outcomes] == [one.planned for one in outcomes]
    over = np.array([e / sigma for one in outcomes for e, sigma in one.quantities.values()])
    assert len(over) == 8 * PLANS
    assert np.mean(np.abs(over) > WITHIN_SIGMAS) <= BEYOND_SHARE
    # What is stated is true: neither too small nor, for fear, much too large.
    assert 0.5 <= np.sqrt(np.mean(over**2)) <= 1.3
    scale = np.array([one.diameter_error_px for one in outcomes])
    assert np.sqrt(np.mean(scale**2)) <= 1.3 * DIAMETER_SIGMA_PX

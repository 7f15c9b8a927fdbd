"""Trials drawn at random, filmed in many scenes, counted exactly.

Forty take minutes and run with ``pytest -m slow tests/counted``.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from counting import answer, assert_counted, truth_of

from synth_video.film import render_clip
from synth_video.scene_file import load_scene
from synth_video.variation import varied

SCENES = (
    *("paper", "black-cloth", "bright-wall", "shelf", "small-ball"),
    *("tilted", "low-light", "wall-right", "ratio16", "equal-masses"),
)
"""Each is filmed otherwise; masses, gaps, losses, side and rate are drawn anew for each trial."""
FIRST_SEED = 1000
TRIALS = range(40)


def trial_name(number: int) -> str:
    return f"{SCENES[number % len(SCENES)]}-{FIRST_SEED + number}"


@pytest.mark.slow
@pytest.mark.parametrize("number", TRIALS, ids=trial_name)
def test_a_random_resolved_trial_is_counted_exactly(number: int, tmp_path: Path) -> None:
    seed = FIRST_SEED + number
    scene = varied(load_scene(SCENES[number % len(SCENES)]), seed)
    clip = tmp_path / f"{trial_name(number)}.mp4"
    assert render_clip(scene, seed, clip).resolved
    assert_counted(answer(clip), truth_of(clip))

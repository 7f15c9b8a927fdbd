"""Accuracy under hard conditions only goes up: a few clips of the suite against their scores.

Three are filmed and counted with every run of the tests, all twelve with ``-m slow``.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from suite_scores import OUTCOMES, on_file, record_of, scored, takes

from synth_video.suite.filming import Take
from tiers import rest_slow

SAME_ERROR_FRAMES = 0.05
"""Another machine's rounding and another build's coder move a time by less."""


def test_every_chosen_clip_has_a_score_on_file_and_none_is_confidently_wrong() -> None:
    kept = on_file()
    assert sorted(kept) == sorted(Path(take.name).stem for take in takes())
    assert "confidently_wrong" not in {record["outcome"] for record in kept.values()}


@pytest.mark.parametrize("take", rest_slow(takes(), quick=3), ids=lambda take: Path(take.name).stem)
def test_a_clip_is_counted_as_well_as_the_scores_on_file_say(take: Take, tmp_path: Path) -> None:
    before, now = on_file()[Path(take.name).stem], record_of(scored(take, tmp_path))
    assert OUTCOMES.index(now["outcome"]) >= OUTCOMES.index(before["outcome"])
    assert now["wrong_kind"] <= before["wrong_kind"]
    if before["mean_time_error_frames"] is not None:
        most = before["mean_time_error_frames"] + SAME_ERROR_FRAMES
        assert now["mean_time_error_frames"] <= most

"""Accuracy under hard conditions only goes up: clips of the suite against their scores on file.

Of every cell (a condition at a strength) the track of one clip is stored and counted with every run
of the tests, but for one that takes long; one whole clip is filmed and counted. The rest runs
with ``-m slow``.
"""

from __future__ import annotations

from pathlib import Path

import pytest
import stored_tracks
from suite_scores import (
    CLIPS_FILE,
    OUTCOMES,
    TRACKS_FILE,
    Record,
    on_file,
    record_of,
    scored,
    takes,
)

from synth_video.suite.condition import STRENGTHS
from synth_video.suite.suites import SUITES, Take
from tiers import rest_slow

SAME_ERROR_FRAMES = 0.05
"""Another machine's rounding and another build's coder move a time by less."""
MOST_BYTES = 1_000_000
WITHOUT_TRACK = {"nothing"}
"""Conditions in which no bodies can be followed."""
SLOW_TRACKS = {"first_frame-full-000"}
"""Tracks that take 20 s; the same condition at its ordinary strength is counted with every run."""


def assert_no_worse(now: Record, before: Record) -> None:
    assert OUTCOMES.index(now["outcome"]) >= OUTCOMES.index(before["outcome"])
    assert now["wrong_kind"] <= before["wrong_kind"]
    if before["mean_time_error_frames"] is not None:
        most = before["mean_time_error_frames"] + SAME_ERROR_FRAMES
        assert now["mean_time_error_frames"] <= most


@pytest.mark.parametrize("file", [CLIPS_FILE, TRACKS_FILE], ids=lambda file: file.stem)
def test_none_on_file_is_confidently_wrong(file: Path) -> None:
    assert "confidently_wrong" not in {record["outcome"] for record in on_file(file).values()}


def test_every_chosen_clip_has_a_score_on_file() -> None:
    assert sorted(on_file(CLIPS_FILE)) == sorted(Path(take.name).stem for take in takes())


def test_every_cell_has_a_track_and_a_score_on_file() -> None:
    assert list(on_file(TRACKS_FILE)) == list(stored_tracks.on_file())
    cells = {name.rpartition("-")[0] for name in stored_tracks.on_file()}
    conditions = {condition.name for condition in SUITES["all"]} - WITHOUT_TRACK
    assert cells == {f"{name}-{strength}" for name in conditions for strength in STRENGTHS}
    assert stored_tracks.FILE.stat().st_size <= MOST_BYTES


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] if name in SLOW_TRACKS else [])
        for name in stored_tracks.on_file()
    ],
)
def test_a_track_is_counted_as_well_as_the_scores_on_file_say(name: str) -> None:
    found = stored_tracks.counted(stored_tracks.on_file()[name])
    assert_no_worse(record_of(found), on_file(TRACKS_FILE)[name])


@pytest.mark.parametrize("take", rest_slow(takes()), ids=lambda take: Path(take.name).stem)
def test_a_clip_is_counted_as_well_as_the_scores_on_file_say(take: Take, tmp_path: Path) -> None:
    found = scored(take, tmp_path)
    assert_no_worse(record_of(found), on_file(CLIPS_FILE)[Path(take.name).stem])

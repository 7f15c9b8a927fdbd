"""Clips that do not show the whole burst: never a smaller count, always the reason."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
from counting import FIXTURES, Answer, answer, assert_counted, truth_of

CLIPS = [
    FIXTURES / f"{stem}.mp4" for stem in ("ratio1-count3", "ratio16-count12", "cluttered-1to16")
]
SPARE_FRAMES = 8
"""So many frames before the first collision and after the last show what is needed there."""

on_each_clip = pytest.mark.parametrize("clip", CLIPS, ids=lambda clip: clip.stem)


def middles_of_flights(clip: Path) -> list[int]:
    """Return a frame in the middle between each collision and the next."""
    frames = [event["frame"] for event in truth_of(clip)["events"]]
    return [round((a + b) / 2) for a, b in pairwise(frames)]


def early_middle_and_late(flights: list[int]) -> list[int]:
    return sorted({flights[0], flights[len(flights) // 2], flights[-1]})


def assert_not_counted(said: Answer) -> None:
    assert (said["status"], said["count"]) == ("not_counted", None)
    assert said["reason"]


@on_each_clip
def test_a_clip_that_starts_after_the_first_collision_is_not_counted(clip: Path) -> None:
    for start in early_middle_and_late(middles_of_flights(clip)):
        assert_not_counted(answer(clip, "--start", str(start)))


@on_each_clip
def test_a_clip_that_ends_before_the_last_collision_is_not_counted(clip: Path) -> None:
    for end in early_middle_and_late(middles_of_flights(clip)):
        assert_not_counted(answer(clip, "--end", str(end)))


@pytest.mark.parametrize("clip", CLIPS[1:], ids=lambda clip: clip.stem)
def test_the_reason_tells_which_end_of_the_clip_is_missing(clip: Path) -> None:
    flights = middles_of_flights(clip)
    second, last_but_one = flights[1], flights[-2]
    assert "the clip starts after the first collision" in reason(clip, "--start", second)
    assert "the clip ends" in reason(clip, "--end", last_but_one)


def reason(clip: Path, option: str, frame: int) -> str:
    return str(answer(clip, option, str(frame))["reason"])


@on_each_clip
def test_the_burst_with_a_few_frames_at_either_end_is_enough(clip: Path) -> None:
    truth = truth_of(clip)
    first, last = (truth["events"][place]["frame"] for place in (0, -1))
    start, end = int(first) - SPARE_FRAMES, int(last) + 1 + SPARE_FRAMES
    said = answer(clip, "--start", str(start), "--end", str(end))
    assert_counted(said, truth)


@pytest.mark.parametrize("kept", [0.3, 0.7])
def test_a_file_cut_within_the_burst_is_not_counted_and_says_what_is_missing(
    kept: float, tmp_path: Path
) -> None:
    clip = FIXTURES / "ratio16-count12.mp4"
    cut = tmp_path / "trial.mp4"
    cut.write_bytes(clip.read_bytes()[: int(kept * clip.stat().st_size)])
    said, frames = answer(cut), len(truth_of(clip)["frames"])
    assert_not_counted(said)
    assert said["frames_promised"] == frames
    assert 0 < said["frames_decoded"] < frames
    numbers = [str(frames), str(said["frames_decoded"])]
    assert any(all(n in warning for n in numbers) for warning in said["warnings"])

"""Clips that do not show the whole burst: never a smaller count, always the reason."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
from counting import FIXTURES, Answer, answer, assert_counted, truth_of

from tiers import rest_slow

CLIPS = [
    FIXTURES / f"{stem}.mp4" for stem in ("ratio16-count12", "cluttered-1to16", "ratio1-count3")
]
SPARE_FRAMES = 8
"""So many frames before the first collision and after the last show what is needed there."""
WORDS = {"--start": "the clip starts after the first collision", "--end": "the clip ends"}
"""What is missing, by the option that takes it away."""


def middles_of_flights(clip: Path) -> list[int]:
    """Return a frame in the middle between each collision and the next."""
    frames = [event["frame"] for event in truth_of(clip)["events"]]
    return [round((a + b) / 2) for a, b in pairwise(frames)]


def assert_not_counted(said: Answer) -> None:
    assert (said["status"], said["count"]) == ("not_counted", None)
    assert said["reason"]


@pytest.mark.parametrize("option", WORDS)
@pytest.mark.parametrize("clip", rest_slow(CLIPS[:2]), ids=lambda clip: clip.stem)
def test_a_clip_that_lacks_a_collision_is_not_counted_and_says_at_which_end(
    clip: Path, option: str
) -> None:
    second, *_, last_but_one, _ = middles_of_flights(clip)
    said = answer(clip, option, str(second if option == "--start" else last_but_one))
    assert_not_counted(said)
    assert WORDS[option] in said["reason"]


@pytest.mark.slow
@pytest.mark.parametrize("option", WORDS)
@pytest.mark.parametrize("clip", CLIPS, ids=lambda clip: clip.stem)
def test_wherever_in_the_burst_a_clip_is_cut_it_is_not_counted(clip: Path, option: str) -> None:
    flights = middles_of_flights(clip)
    for frame in sorted({flights[0], flights[len(flights) // 2], flights[-1]}):
        assert_not_counted(answer(clip, option, str(frame)))


def test_like_bodies_of_which_one_comes_from_a_wall_are_not_counted() -> None:
    clip = FIXTURES / "ratio1-count3.mp4"
    _, wall, _ = (event["frame"] for event in truth_of(clip)["events"])
    for start in range(int(wall) + 1, int(wall) + 4):
        said = answer(clip, "--start", str(start))
        assert_not_counted(said)
        assert "comes from something that stands still" in said["reason"]


def test_what_follows_the_end_of_a_clip_is_foreseen_with_its_uncertainty() -> None:
    clip = FIXTURES / "ratio100-count29.mp4"
    truth = truth_of(clip)
    fifth, sixth = (truth["events"][place]["frame"] for place in (4, 5))
    said = answer(clip, "--end", str(round((fifth + sixth) / 2)))
    assert_not_counted(said)
    # Of 29 collisions the clip shows 5, which leave the others open but for a few.
    chances = {int(count): chance for count, chance in said["probability"].items()}
    assert chances[truth["count"]] > 0.05
    assert max(chances.values()) < 0.95


@pytest.mark.parametrize("clip", rest_slow(CLIPS[::-1]), ids=lambda clip: clip.stem)
def test_the_burst_with_a_few_frames_at_either_end_is_enough(clip: Path) -> None:
    truth = truth_of(clip)
    first, last = (truth["events"][place]["frame"] for place in (0, -1))
    start, end = int(first) - SPARE_FRAMES, int(last) + 1 + SPARE_FRAMES
    said = answer(clip, "--start", str(start), "--end", str(end))
    assert_counted(said, truth)


@pytest.mark.parametrize("kept", rest_slow([0.3, 0.7]))
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

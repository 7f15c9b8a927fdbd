"""Frames that are late, lost, shown twice or left out, and clips that show a part of the trial."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from filming import filmed, filmed_times, small_scene

from coded import time_stamps_s
from count_video.physics.simulator import Motion
from count_video.records import Frame
from count_video.video.reader import open_footage
from synth_video.film import render_clip
from synth_video.projection import projection_of
from synth_video.schedule import RAMP_APART_FRAMES, Schedule
from synth_video.truth import Truth, truth_of
from tiers import rest_slow

ROUNDING_S = 1e-9
TICK_S = 1 / 90_000
CODING_LEVELS = 2.0
"""The pictures are coded turned, which costs other details."""
SHORT = ("clip.frames=12", "encoding.crf=10")


def times(*settings: str) -> tuple[Motion, Schedule]:
    return filmed_times(small_scene("ratio16", *settings), 3)


def hits(motion: Motion, schedule: Schedule) -> list[float]:
    return [schedule.frame_coordinate(bounce.time_s) for bounce in motion.burst]


def truth(*settings: str) -> Truth:
    scene = small_scene("ratio16", *settings)
    motion, schedule = filmed_times(scene, 3)
    return truth_of(scene, 3, motion, schedule, projection_of(scene))


def test_without_any_of_it_frames_are_even_and_none_is_a_copy() -> None:
    _, schedule = times()
    assert np.ptp(np.diff(schedule.centre_s)) < ROUNDING_S
    assert not schedule.copies.any()


def test_jitter_moves_exposures_by_no_more_than_its_share() -> None:
    _, even = times()
    _, uneven = times("camera.jitter=0.2")
    off = (uneven.centre_s - even.centre_s) * 960
    assert 0.15 < np.abs(off).max() <= 0.2
    assert np.all(np.diff(uneven.centre_s) > 0)


def test_footage_times_follow_the_exposures_from_zero() -> None:
    _, uneven = times("camera.jitter=0.2")
    stamps = uneven.footage_s(960.0, 30.0)
    assert stamps[0] == 0
    assert np.diff(stamps) / np.diff(uneven.centre_s) == pytest.approx(960 / 30)


def test_pictures_shown_twice_make_the_clip_longer_and_push_later_frames_back() -> None:
    motion, even = times()
    _, doubled = times("encoding.repeat_every=5")
    assert doubled.copies.sum() == len(even.centre_s) // 5
    assert np.array_equal(doubled.centre_s[~doubled.copies], even.centre_s)
    for plain, pushed in zip(hits(motion, even), hits(motion, doubled), strict=True):
        assert pushed - plain == pytest.approx((int(plain) + 1) // 5)


def test_copies_in_the_place_of_lost_pictures_leave_the_count_of_frames_as_it_is() -> None:
    motion, even = times()
    _, lossy = times("encoding.repeat_every=5", "encoding.repeat_lost=true")
    assert len(lossy.centre_s) == len(even.centre_s)
    assert np.flatnonzero(lossy.copies).tolist() == list(range(4, len(even.centre_s), 5))
    assert hits(motion, lossy) == hits(motion, even)


@pytest.mark.parametrize("factor", [3, 3.5, 4])
def test_a_ramp_keeps_all_pictures_of_the_burst_and_few_of_the_rest(
    factor: float,
) -> None:
    motion, even = times()
    _, ramped = times(f"clip.ramp={factor}")
    steps = np.diff(ramped.centre_s) * 960
    assert np.count_nonzero(np.abs(steps - 1) < 1e-6) > 20
    assert steps[[0, -1]] == pytest.approx([factor, factor])
    assert np.all((steps > 1 - 1e-6) & (steps < factor + 1e-6))
    assert len(ramped.centre_s) < len(even.centre_s)
    assert min(b - a for a, b in pairwise(hits(motion, ramped))) >= min(
        RAMP_APART_FRAMES, *(b - a for a, b in pairwise(hits(motion, even)))
    )


def test_a_copy_in_the_pictures_is_the_picture_before_it() -> None:
    scene = small_scene("ratio16", "encoding.repeat_every=4", "clip.frames=9")
    _, schedule, pictures = filmed(scene)
    same = [False, *(np.array_equal(a, b) for a, b in pairwise(pictures))]
    assert same == schedule.copies.tolist()


def test_a_clip_of_the_whole_burst_is_whole_and_others_are_not() -> None:
    assert truth().countable
    assert truth("clip.end=turn").countable
    cuts = ("clip.start=second", "clip.start=middle", "clip.end=middle", "clip.end=penultimate")
    for cut in cuts:
        assert not truth(cut, "clip.lead_frames=1", "clip.tail_frames=1").countable
    assert not truth("clip.start=release", "clip.lead_frames=40", "clip.frames=30").countable


def test_a_clip_until_all_is_over_shows_the_second_swing() -> None:
    assert truth("clip.end=all").events_after_burst
    assert not truth("clip.end=burst").events_after_burst


@pytest.mark.parametrize("rotation_deg", rest_slow([90, 180, 270]))
def test_a_turned_file_is_shown_as_an_upright_one(rotation_deg: int, tmp_path: Path) -> None:
    plain, turned = (read(tmp_path, f"encoding.rotation_deg={turn}") for turn in (0, rotation_deg))
    assert turned[0].luma.shape == plain[0].luma.shape
    for one, other in zip(plain, turned, strict=True):
        difference = one.luma.astype(float) - other.luma.astype(float)
        assert np.sqrt(np.mean(difference**2)) < CODING_LEVELS


def test_the_time_stamps_of_a_variable_rate_are_in_the_file(tmp_path: Path) -> None:
    settings = ("camera.jitter=0.3", "encoding.variable_rate=true")
    read(tmp_path, *settings)
    steps = 30 * np.diff(time_stamps_s(tmp_path / "clip.mp4"))
    # Two neighbours are each off by 0.3 at most.
    assert np.all(np.abs(steps - 1) <= 0.6 + 30 * TICK_S)
    assert np.ptp(steps) > 0.3


def read(folder: Path, *settings: str) -> list[Frame]:
    """Render a short clip and read it again."""
    clip = folder / "clip.mp4"
    render_clip(small_scene("ratio16", *SHORT, *settings), 3, clip)
    with open_footage(clip) as footage:
        return list(footage.frames())

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numbered_frames import numbered, numbers_of, write_numbered

from count_video.errors import UsageError
from count_video.footage.pilot import RUN_FRAMES, _share_out
from count_video.footage.reader import open_footage, pilot_frames
from count_video.footage.writer import WriteOptions, write_clip
from count_video.records import Frame

FRAMES = 300
BUDGET = 60
LEAST_RUN = 8

FORMATS = {
    "H.264 in MP4": ("clip.mp4", "libx264", 25),
    "HEVC in MOV": ("clip.mov", "libx265", 40),
    "VP9 in WebM": ("clip.webm", "libvpx-vp9", 30),
    "H.264 in MKV": ("clip.mkv", "libx264", 25),
    "JPEG in AVI": ("clip.avi", "mjpeg", None),
    "FFV1 in MKV": ("clip.mkv", "ffv1", 12),
}


def written(folder: Path, kind: str, frames: int = FRAMES) -> Path:
    name, codec, gop = FORMATS[kind]
    return write_numbered(folder / name, frames, WriteOptions(codec=codec, gop=gop, b_frames=2))


def indices(runs: list[list[Frame]]) -> list[int]:
    return [frame.index for run in runs for frame in run]


@pytest.mark.parametrize("kind", FORMATS)
def test_every_frame_of_the_pilot_is_the_one_that_its_index_says(tmp_path: Path, kind: str) -> None:
    path = written(tmp_path, kind)
    runs = pilot_frames(path, budget=BUDGET)
    assert numbers_of([frame for run in runs for frame in run]) == indices(runs)
    wanted = {frame.index: frame for run in runs for frame in run}
    with open_footage(path) as footage:
        for frame in footage.frames():
            if pilot := wanted.get(frame.index):
                assert frame.footage_time_s == pilot.footage_time_s
                np.testing.assert_array_equal(frame.luma, pilot.luma)


@pytest.mark.parametrize("kind", FORMATS)
def test_runs_are_spread_over_the_clip_within_the_budget(tmp_path: Path, kind: str) -> None:
    runs = pilot_frames(written(tmp_path, kind), budget=BUDGET)
    assert BUDGET - len(runs) <= len(indices(runs)) <= BUDGET
    assert len(runs) == BUDGET // RUN_FRAMES
    assert runs[0][0].index == 0
    assert runs[-1][0].index >= 0.7 * FRAMES
    for run in runs:
        assert len(run) >= LEAST_RUN
        assert [frame.index for frame in run] == list(range(run[0].index, run[0].index + len(run)))
    assert all(before[-1].index < after[0].index for before, after in pairwise(runs))


@pytest.mark.parametrize(("start", "end"), [(100, 250), (37, None), (0, 120)])
def test_the_pilot_stays_in_the_part_that_it_is_given(
    tmp_path: Path, start: int, end: int | None
) -> None:
    runs = pilot_frames(written(tmp_path, "H.264 in MP4"), budget=BUDGET, start=start, end=end)
    found = indices(runs)
    assert found
    assert start <= min(found)
    assert max(found) < (FRAMES if end is None else end)
    assert numbers_of([frame for run in runs for frame in run]) == found


@pytest.mark.parametrize(("frames", "budget"), [(40, 60), (60, 60), (1, 5)])
def test_a_clip_within_the_budget_is_one_run(tmp_path: Path, frames: int, budget: int) -> None:
    runs = pilot_frames(written(tmp_path, "H.264 in MP4", frames), budget=budget)
    assert [indices([run]) for run in runs] == [list(range(frames))]


def test_a_clip_with_one_key_frame_gives_one_run_from_it(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 120, WriteOptions(gop=1000))
    (run,) = pilot_frames(path, budget=30)
    assert numbers_of(run) == list(range(30))


def test_where_no_key_frame_is_near_decoding_starts_before_the_part(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 120, WriteOptions(gop=1000))
    (run,) = pilot_frames(path, budget=30, start=50)
    assert numbers_of(run) == indices([run]) == list(range(50, 80))


def test_a_file_without_time_stamps_is_decoded_from_its_start(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.h264", 60)
    (run,) = pilot_frames(path, budget=20, start=5)
    assert numbers_of(run) == indices([run]) == list(range(5, 25))


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_a_cut_file_has_a_pilot_up_to_the_cut(tmp_path: Path, share: float) -> None:
    path = written(tmp_path, "H.264 in MP4")
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    runs = pilot_frames(path, budget=BUDGET)
    found = indices(runs)
    assert numbers_of([frame for run in runs for frame in run]) == found
    assert 0 in found
    assert len(runs) > 1


def test_a_pilot_of_a_part_behind_the_end_is_empty(tmp_path: Path) -> None:
    path = written(tmp_path, "H.264 in MP4", 40)
    assert pilot_frames(path, budget=10, start=100) == []
    assert pilot_frames(path, budget=10, start=20, end=20) == []


@pytest.mark.parametrize("budget", [0, -3])
def test_a_pilot_without_budget_is_refused(tmp_path: Path, budget: int) -> None:
    path = written(tmp_path, "H.264 in MP4", 5)
    with pytest.raises(UsageError, match="pilot"):
        pilot_frames(path, budget=budget)


def test_copies_are_marked_within_a_run(tmp_path: Path) -> None:
    path = tmp_path / "clip.avi"
    write_clip(path, [numbered(k // 2) for k in range(20)], WriteOptions(codec="mjpeg"))
    (run,) = pilot_frames(path, budget=30)
    assert [frame.repeats_previous for frame in run] == [False, True] * 10


@given(rooms=st.lists(st.integers(1, 50), min_size=1, max_size=12), budget=st.integers(1, 200))
def test_the_budget_is_shared_out_to_the_last_frame(rooms: list[int], budget: int) -> None:
    lengths = _share_out(budget, rooms)
    assert all(0 <= length <= room for length, room in zip(lengths, rooms, strict=True))
    assert sum(lengths) == min(budget, sum(rooms))


def test_of_each_picture_no_more_is_kept_than_was_asked_for(tmp_path: Path) -> None:
    path = written(tmp_path, "H.264 in MP4")

    whole = pilot_frames(path, budget=BUDGET)
    runs = pilot_frames(path, budget=BUDGET, reduced=lambda luma: luma[::2, ::2].copy())

    assert indices(runs) == indices(whole)
    for run, other in zip(runs, whole, strict=True):
        for frame, full in zip(run, other, strict=True):
            np.testing.assert_array_equal(frame.luma, full.luma[::2, ::2])
            assert frame.repeats_previous == full.repeats_previous

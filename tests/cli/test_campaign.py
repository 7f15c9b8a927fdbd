from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from stand_in import StandIn

from count_video.campaign import Outcome, clips_in, count_clips
from count_video.errors import FootageError, UsageError
from count_video.progress import Progress
from count_video.records import TrialResult
from count_video.trial import TrialSettings


def outcomes(*paths: Path) -> list[Outcome]:
    return list(count_clips(paths, TrialSettings()))


def failing(error: BaseException) -> object:
    def work(path: Path) -> TrialResult:
        raise error

    return work


def touch(folder: Path, *names: str) -> None:
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).touch()


def test_clips_are_counted_in_the_order_given(stand_in: StandIn) -> None:
    names = ["b.mp4", "a.mp4", "c.mp4"]
    assert [o.result.clip for o in outcomes(*map(Path, names))] == names


def test_the_settings_reach_every_clip(stand_in: StandIn) -> None:
    settings = TrialSettings(capture_fps=960.0, region=(1, 2, 3, 4))
    list(count_clips([Path("a.mp4"), Path("b.mp4")], settings))
    assert [asked for _, asked in stand_in.asked] == [settings, settings]


def test_each_clip_is_answered_before_the_next_is_begun(stand_in: StandIn) -> None:
    answers = count_clips([Path("a.mp4"), Path("b.mp4")], TrialSettings())
    next(answers)
    assert [path.name for path, _ in stand_in.asked] == ["a.mp4"]


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (FootageError("bad.mp4: the file is empty"), "the file is empty"),
        (UsageError("the region lies outside the picture"), "the region lies outside the picture"),
        (PermissionError(13, "Permission denied", "bad.mp4"), "Permission denied"),
        (OSError(), "OSError"),
    ],
    ids=["footage", "usage", "system", "system without a word"],
)
def test_a_bad_clip_has_its_reason_and_stops_no_other(
    stand_in: StandIn, error: Exception, reason: str
) -> None:
    stand_in.answers["bad.mp4"] = failing(error)
    bad, good = outcomes(Path("bad.mp4"), Path("good.mp4"))
    assert bad.error is error
    assert (bad.result.clip, bad.result.status, bad.result.reason) == (
        "bad.mp4",
        "not_counted",
        reason,
    )
    assert bad.result.count is None
    assert good.error is None
    assert good.result.status == "counted"


def test_a_fault_of_the_program_is_not_hidden_as_a_bad_clip(stand_in: StandIn) -> None:
    stand_in.answers["bad.mp4"] = failing(ZeroDivisionError("a fault"))
    with pytest.raises(ZeroDivisionError, match="a fault"):
        outcomes(Path("bad.mp4"))


@pytest.mark.parametrize("error", [None, FootageError("cut off"), KeyboardInterrupt()])
def test_the_progress_ends_with_every_clip(stand_in: StandIn, error: BaseException | None) -> None:
    class Recorder:
        calls: list[str] = []  # noqa: RUF012

        def start(self, total: int | None, label: str) -> None:
            self.calls.append("start")

        def advance(self, frames: int) -> None:
            self.calls.append("advance")

        def finish(self) -> None:
            self.calls.append("finish")

    recorder: Progress = Recorder()
    if error is not None:
        stand_in.answers["a.mp4"] = failing(error)
    try:
        list(count_clips([Path("a.mp4")], TrialSettings(), recorder))
    except KeyboardInterrupt:
        assert isinstance(error, KeyboardInterrupt)
    assert Recorder.calls == ["start", "finish"]


def test_a_folder_stands_for_the_video_files_in_it(tmp_path: Path) -> None:
    touch(tmp_path, "clip10.mp4", "clip2.MOV", "notes.txt", "clip1.mkv", "._clip1.mkv", "mp4")
    touch(tmp_path / "folder.mp4", "deeper.mp4")
    assert [clip.name for clip in clips_in(tmp_path)] == ["clip1.mkv", "clip2.MOV", "clip10.mp4"]


def test_a_folder_without_a_clip_is_told(tmp_path: Path) -> None:
    touch(tmp_path, "notes.txt")
    with pytest.raises(FootageError, match="no video file in this folder"):
        clips_in(tmp_path)


@given(st.lists(st.integers(0, 10**12), min_size=1, max_size=8, unique=True))
def test_numbered_clips_come_in_the_order_of_their_numbers(
    tmp_path_factory: pytest.TempPathFactory, numbers: list[int]
) -> None:
    folder = tmp_path_factory.mktemp("numbered")
    touch(folder, *(f"Clip {number} b.mp4" for number in numbers))
    assert clips_in(folder) == [folder / f"Clip {number} b.mp4" for number in sorted(numbers)]


def test_names_that_begin_with_a_number_and_with_a_letter_can_be_ordered(tmp_path: Path) -> None:
    touch(tmp_path, "2.mp4", "b.mp4", "10.mp4", "2b.mp4", "².mp4")
    assert [clip.name for clip in clips_in(tmp_path)][:3] == ["2.mp4", "2b.mp4", "10.mp4"]

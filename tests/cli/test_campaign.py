"""Many clips given to the command: in order, each answered at once, a bad one stops no other."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from stand_in import StandIn

from count_video import api, cli
from count_video.errors import FootageError, UsageError
from count_video.outputs import open_outputs
from count_video.progress import Progress
from count_video.records import TrialResult


def failing(error: BaseException) -> Callable[[Path], TrialResult]:
    def work(path: Path) -> TrialResult:
        raise error

    return work


def answers(capsys: pytest.CaptureFixture[str], *arguments: str) -> list[dict[str, object]]:
    cli.main(["--json", *arguments])
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def test_clips_are_counted_in_the_order_given(
    stand_in: StandIn, capsys: pytest.CaptureFixture[str]
) -> None:
    names = ["b.mp4", "a.mp4", "c.mp4"]
    assert [answer["clip"] for answer in answers(capsys, *names)] == names


def test_the_settings_reach_every_clip(
    stand_in: StandIn, capsys: pytest.CaptureFixture[str]
) -> None:
    answers(capsys, "a.mp4", "b.mp4", "--capture-fps", "960", "--region", "1,2,30,40")
    settings = [asked for _, asked in stand_in.asked]
    assert [(one.capture_fps, one.region) for one in settings] == [(960.0, (1, 2, 30, 40))] * 2


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
    stand_in: StandIn, capsys: pytest.CaptureFixture[str], error: Exception, reason: str
) -> None:
    stand_in.answers["bad.mp4"] = failing(error)
    bad, good = answers(capsys, "bad.mp4", "good.mp4")
    assert (bad["clip"], bad["status"], bad["count"]) == ("bad.mp4", "not_counted", None)
    assert str(bad["reason"]).startswith(reason)
    assert good["status"] == "counted"


@pytest.mark.parametrize("form", [[], ["--json"]], ids=["text", "json"])
def test_folders_without_a_clip_alone_are_a_wrong_request(
    stand_in: StandIn, capsys: pytest.CaptureFixture[str], tmp_path: Path, form: list[str]
) -> None:
    empty, results = tmp_path / "empty", tmp_path / "results"
    empty.mkdir()
    (empty / "notes.txt").touch()
    assert cli.main([*form, str(empty), "-o", str(results)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"count-video: {empty}: no video file in this folder (none that ends in ")
    assert err.count("\n") == 1
    assert not results.exists()


def test_a_scheduler_without_dask_is_one_line(
    stand_in: StandIn, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "dask", None)  # as if it were not installed
    assert cli.main(["--scheduler", "tcp://127.0.0.1:1", "a.mp4"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "pip install '.[distributed]'" in err
    assert err.count("\n") == 1


def test_clips_that_this_program_drew_are_left_out_where_files_are_named(
    stand_in: StandIn, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    outputs = open_outputs(tmp_path)
    outputs.write("a.annotated.mp4", b"drawn")
    own, other = (str(tmp_path / name) for name in ("a.annotated.mp4", "a.mp4"))
    assert [one["clip"] for one in answers(capsys, own, other)] == [other]
    assert cli.main([own, own]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"count-video: {own}: this program drew this; give the clip that was filmed"


def test_a_fault_of_the_program_is_not_hidden_as_a_bad_clip(stand_in: StandIn) -> None:
    stand_in.answers["bad.mp4"] = failing(ZeroDivisionError("a fault"))
    with pytest.raises(ZeroDivisionError, match="a fault"):
        cli.main(["bad.mp4"])


@pytest.mark.parametrize("error", [None, FootageError("cut off"), KeyboardInterrupt()])
def test_the_progress_ends_with_every_clip(stand_in: StandIn, error: BaseException | None) -> None:
    calls: list[str] = []

    class Recorder(Progress):
        def start(self, total: int | None, label: str) -> None:
            calls.append("start")

        def advance(self, frames: int) -> None:
            calls.append("advance")

        def finish(self) -> None:
            calls.append("finish")

    recorder: Progress = Recorder()
    if error is None:
        api.count("a.mp4", progress=recorder)
    else:
        stand_in.answers["a.mp4"] = failing(error)
        with pytest.raises(type(error)):
            api.count("a.mp4", progress=recorder)
    assert calls == ["start", "finish"]

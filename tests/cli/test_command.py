from __future__ import annotations

import errno
import json
import os
import pty
import shlex
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from stand_in import StandIn, counted

from count_video.cli import main
from count_video.errors import FootageError, UsageError
from count_video.pipeline import TrialSettings
from count_video.records import TrialResult


def unreadable(path: Path) -> TrialResult:
    raise FootageError(f"{path}: no such file; check the name")


def impossible(path: Path) -> TrialResult:
    raise UsageError("the region lies outside the picture")


def interrupted(path: Path) -> TrialResult:
    raise KeyboardInterrupt


@pytest.fixture
def command(stand_in: StandIn) -> StandIn:
    stand_in.answers |= {
        "missing.mp4": unreadable,
        "narrow.mp4": impossible,
        "long.mp4": interrupted,
        "odd\n\x1b[31m.mp4": unreadable,
        "partly.mp4": lambda path: replace(
            counted(path), status="not_counted", count=None, reason="it ends early"
        ),
    }
    return stand_in


@pytest.mark.parametrize(
    ("clips", "code"),
    [
        (["a.mp4"], 0),
        (["a.mp4", "b.mp4"], 0),
        (["still.mp4"], 1),
        (["missing.mp4"], 1),
        (["missing.mp4", "a.mp4"], 1),
        (["a.mp4", "partly.mp4"], 1),
        (["narrow.mp4"], 2),
        (["narrow.mp4", "still.mp4"], 2),
        ([], 2),
        (["a.mp4", "--wall", "up"], 2),
        (["long.mp4"], 130),
        (["--help"], 0),
        (["--version"], 0),
    ],
)
@pytest.mark.parametrize("form", [[], ["--json"]], ids=["text", "json"])
def test_the_exit_code_says_what_became_of_the_request(
    command: StandIn, clips: list[str], code: int, form: list[str]
) -> None:
    assert main([*form, *clips]) == code


def test_a_counted_clip_is_answered_on_stdout_alone(
    command: StandIn, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["clips/a.mp4"])
    out, err = capsys.readouterr()
    assert out.splitlines()[0] == "a.mp4: 1 collision"
    assert err == ""


@pytest.mark.parametrize(
    ("clip", "line"),
    [
        ("clips/missing.mp4", "count-video: clips/missing.mp4: no such file; check the name"),
        ("narrow.mp4", "count-video: narrow.mp4: the region lies outside the picture"),
        ("odd\n\x1b[31m.mp4", "count-video: odd\\n\\x1b[31m.mp4: no such file; check the name"),
    ],
)
def test_a_clip_that_cannot_be_read_is_one_line_on_stderr(
    command: StandIn, capsys: pytest.CaptureFixture[str], clip: str, line: str
) -> None:
    main([clip])
    assert capsys.readouterr() == ("", f"{line}\n")


@pytest.mark.parametrize(
    ("clip", "reason"), [("partly.mp4", "it ends early"), ("still.mp4", "nothing moves")]
)
def test_what_is_said_of_a_clip_that_is_not_counted_is_on_stdout_its_reason_on_both(
    command: StandIn, capsys: pytest.CaptureFixture[str], clip: str, reason: str
) -> None:
    main([clip])
    out, err = capsys.readouterr()
    assert out.startswith(f"{clip}: not counted\n\n  Why          {reason}\n")
    assert err == f"count-video: {clip}: {reason}\n"


def test_a_review_of_a_clip_that_is_not_counted_is_shown(
    command: StandIn, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    added = {"action": "missed", "kind": "wall", "frame": 7, "number": None}
    review = {"corrections_version": 1, "clip": "still.mp4", "corrections": [added]}
    saved = tmp_path / "saved.json"
    saved.write_text(json.dumps(review | {"notes": {"": "too dark"}}), "utf-8")
    assert main(["still.mp4", "--corrections", str(saved)]) == 1
    out = capsys.readouterr().out
    assert out.startswith("still.mp4: not counted, 1 after review\n")
    assert "one with the wall was missed (frame 7.0)" in out
    assert "too dark" in out


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("a.mp4", "this is no text in UTF-8; give the JSON file as it was saved"),
        ("none.json", "cannot be read: No such file or directory; check the name and its rights"),
    ],
)
def test_a_file_that_holds_no_corrections_is_named_before_the_clip_is_counted(
    command: StandIn, capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str, words: str
) -> None:
    clip = tmp_path / "a.mp4"
    clip.write_bytes(b"\x00\xff")
    assert main([str(clip), "--corrections", str(tmp_path / name)]) == 2
    assert capsys.readouterr() == ("", f"count-video: {tmp_path / name}: {words}\n")
    assert command.asked == []


def test_answers_stand_apart_by_an_empty_line(
    command: StandIn, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["a.mp4"])
    alone = capsys.readouterr().out
    main(["missing.mp4", "a.mp4", "missing.mp4", "a.mp4"])
    assert capsys.readouterr().out == f"{alone}\n{alone}"


def test_json_is_one_object_a_clip_and_nothing_else(
    command: StandIn, capsys: pytest.CaptureFixture[str]
) -> None:
    clips = ["a.mp4", "missing.mp4", "still.mp4", "partly.mp4"]
    main(["--json", *clips])
    out, err = capsys.readouterr()
    answers = [json.loads(line) for line in out.splitlines()]
    assert [answer["clip"] for answer in answers] == clips
    assert [answer["status"] for answer in answers] == ["counted"] + ["not_counted"] * 3
    assert answers[1]["reason"] == "no such file; check the name"
    assert len({tuple(answer) for answer in answers}) == 1, "every answer has the same keys"
    assert len(err.splitlines()) == 3


def test_a_wrong_request_is_one_line_and_counts_nothing(
    command: StandIn, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["a.mp4", "--capture-fps", "0"])
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("count-video: ")
    assert len(err.splitlines()) == 1
    assert command.asked == []


def test_what_was_answered_before_an_interruption_is_kept(
    command: StandIn, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["a.mp4", "long.mp4", "b.mp4"])
    out, err = capsys.readouterr()
    assert "a.mp4: 1 collision" in out
    assert err == "count-video: interrupted\n"
    assert [path.name for path, _ in command.asked] == ["a.mp4", "long.mp4"]


def test_the_options_become_the_settings_of_the_trial(command: StandIn) -> None:
    main(
        shlex.split(
            "a.mp4 --capture-fps 960 --start 3 --end 9 --region 1,2,30,40 --wall left "
            "--ball-diameter-mm 20 --masses 100.5 1"
        )
    )
    ((_, settings),) = command.asked
    assert settings == TrialSettings(
        capture_fps=960.0,
        ball_diameter_mm=20.0,
        wall="left",
        region=(1, 2, 30, 40),
        start=3,
        end=9,
        masses=(Fraction(201, 2), Fraction(1)),
    )


def test_options_left_out_leave_the_trial_its_own_defaults(command: StandIn) -> None:
    main(["a.mp4"])
    assert command.asked == [(Path("a.mp4"), TrialSettings())]


def everything_on(reader: int) -> str:
    """Read a terminal to its end: a busy machine hands over what was written piece by piece."""
    pieces = []
    with suppress(OSError):  # as Linux says that the other side is closed
        while piece := os.read(reader, 1 << 16):
            pieces.append(piece)
    return b"".join(pieces).decode()


def test_progress_and_the_reason_fit_a_terminal(
    command: StandIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    reader, writer = pty.openpty()
    with os.fdopen(writer, "w", encoding="utf-8") as terminal:
        monkeypatch.setattr("sys.stdout", terminal)
        monkeypatch.setattr("sys.stderr", terminal)
        assert main(["partly.mp4"]) == 1
    shown = everything_on(reader)
    os.close(reader)
    assert "0/1" in shown
    assert shown.count("it ends early") == 1
    assert shown.index("0/1") < shown.index("partly.mp4: not counted")


def test_a_clip_that_cannot_be_named_in_the_terminals_encoding_is_answered(
    command: StandIn, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "answer.txt"
    with file.open("w", encoding="ascii") as ascii_only:
        monkeypatch.setattr("sys.stdout", ascii_only)
        assert main(["Körper.mp4"]) == 0
    assert file.read_text("ascii").splitlines()[0] == "K\\xf6rper.mp4: 1 collision"


@pytest.mark.parametrize(("columns", "widest"), [("50", 50), ("7", 40), ("900", 100), ("no", 80)])
def test_sentences_keep_to_the_columns_of_the_terminal(
    command: StandIn,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    columns: str,
    widest: int,
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    command.answers["a.mp4"] = lambda path: replace(
        counted(path), collisions=(), warnings=(" ".join(["word"] * 60),)
    )
    assert main(["a.mp4"]) == 0
    longest = max(map(len, capsys.readouterr().out.splitlines()))
    assert widest - len(" words") < longest <= widest


def test_a_file_whose_name_begins_with_a_dash_is_explained(
    command: StandIn,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("-a.mp4", "-old.mp4"):  # which may be read as a folder to write to
        Path(name).touch()
        assert main([name]) == 2
        assert "put ./ before" in capsys.readouterr().err
    assert main(["./-a.mp4"]) == 0
    assert main(["--", "-a.mp4"]) == 0
    assert command.asked[-1][0] == Path("-a.mp4")


@pytest.mark.parametrize(("masses", "hint"), [("1 100", True), ("100 1", False), ("1 1", False)])
def test_a_theory_of_swapped_masses_says_which_comes_first(
    capsys: pytest.CaptureFixture[str], masses: str, hint: bool
) -> None:
    assert main(["--theory", *masses.split()]) == 0
    assert ("that of the cylinder comes first" in capsys.readouterr().err) == hint


@pytest.mark.parametrize("form", [[], ["--json"]], ids=["text", "json"])
def test_a_count_stands_though_nothing_that_shows_it_can_be_written(
    command: StandIn,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    form: list[str],
) -> None:
    def full(target: Path, data: bytes) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("count_video.outputs.write_whole", full)
    assert main([*form, "-o", str(tmp_path / "out"), "a.mp4"]) == 1
    out, err = capsys.readouterr()
    assert ('"count": 1' if form else "a.mp4: 1 collision") in out
    (line,) = err.splitlines()
    assert "a.json" in line
    assert "No space left" in line


def test_a_picture_that_cannot_be_written_has_the_exit_code_of_a_result_that_cannot(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def full(target: Path, data: bytes) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("count_video.outputs.write_whole", full)
    assert main(["--theory", "100", "1", "-o", str(tmp_path)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"count-video: cannot write {tmp_path / 'theory.png'}: No space left")
    assert line.endswith("free space on that disk and start again")


@pytest.mark.parametrize(
    "beside", [["--masses", "2", "1"], ["--start", "3"], ["--json"], ["--jobs", "2"], ["a.mp4"]]
)
def test_what_a_theory_needs_not_is_refused(
    capsys: pytest.CaptureFixture[str], beside: list[str]
) -> None:
    assert main(["--theory", "100", "1"]) == 0
    capsys.readouterr()
    assert main(["--theory", "100", "1", *beside]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert "--theory goes without" in err

"""``synth-video suite`` and ``synth-video score``."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future
from itertools import islice
from pathlib import Path

import pytest

from count_video.video.writer import write_clip
from synth_video import film
from synth_video.cli import main
from synth_video.suite import suites
from synth_video.suite.suites import SUITES, Take

Wanted = tuple[Take, Path]
SUITE = ["suite", "part", "--conditions", "nothing", "--strength", "full"]
ONE = [*SUITE, "--seeds", "1", "--workers", "1"]
NOTHING = "nothing-full-000"


def done_here(
    work: Callable[[Wanted], None], jobs: Sequence[Wanted], _: int
) -> Generator[tuple[Wanted, Future[None]], None, None]:
    """Take the place of processes: each job is done here, in its turn."""
    for job in jobs:
        work(job)
        future: Future[None] = Future()
        future.set_result(None)
        yield job, future


def test_a_suite_is_rendered_once_and_again_only_when_its_scene_changed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main([*ONE, str(tmp_path)]) == 0
    assert f"{NOTHING}.mp4" in capsys.readouterr().out.splitlines()
    files = [f"{NOTHING}.mp4", f"{NOTHING}.truth.json"]
    assert sorted(file.name for file in tmp_path.iterdir()) == files
    truth_file = tmp_path / files[1]
    truth = json.loads(truth_file.read_text("utf-8"))
    assert truth["expect"] == "not_counted"

    assert main([*ONE, str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert f"{NOTHING}.mp4" not in printed
    assert f"count-video --json {tmp_path}" in printed

    # Again, but in this process and of one picture: the whole was drawn above.
    monkeypatch.setattr(suites, "as_done", done_here)
    monkeypatch.setattr(
        film,
        "write_clip",
        lambda path, frames, options: write_clip(path, islice(frames, 1), options),
    )
    truth_file.write_text(json.dumps({**truth, "seed": truth["seed"] + 1}), "utf-8")
    assert main([*SUITE, "--seeds", "1", "--jobs", "1", str(tmp_path)]) == 0
    assert f"{NOTHING}.mp4" in capsys.readouterr().out.splitlines()
    assert json.loads(truth_file.read_text("utf-8")) == truth


def test_without_a_folder_the_conditions_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["suite", "all"]) == 0
    out = capsys.readouterr().out
    listed = [f"{condition.name} {condition.sentence}" for condition in SUITES["all"]]
    assert out.split() == " ".join(listed).split()
    assert max(map(len, out.splitlines())) <= 80


def test_an_interruption_says_that_the_clips_that_are_there_stay(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(_: Wanted) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(suites, "as_done", done_here)
    monkeypatch.setattr(suites, "_render", interrupted)
    assert main([*ONE, str(tmp_path)]) == 130
    said = "synth-video: interrupted; the same command goes on with what is missing\n"
    assert capsys.readouterr() == ("", said)


@pytest.mark.parametrize(
    "arguments",
    [
        ["suite"],
        ["suite", "none"],
        ["suite", "part", "--conditions", "noise"],
        ["suite", "part", "x", "--seeds", "0"],
        ["suite", "part", "x", "--workers", "0"],
        ["suite", "part", "x", "--jobs", "0"],
        ["suite", "part", "x", "--strength", "double"],
        ["score"],
        ["score", "nowhere"],
    ],
)
def test_a_wrong_request_ends_with_two(
    arguments: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("synth-video: ")
    assert printed.err.count("\n") == 1
    assert not printed.out
    assert not list(tmp_path.iterdir())


def clip(folder: Path, name: str, count: int, stated: int | None) -> str:
    """Write the truth of a clip; return the line with its count."""
    kinds = ["bodies", "wall"] * count
    events = [{"frame": 10.0 * k, "kind": kinds[k], "ball_px": 50.0} for k in range(count)]
    truth = {"expect": "counted", "count": count, "events": events}
    (folder / f"{name}.truth.json").write_text(json.dumps(truth), "utf-8")
    hits = [{**e, "frame": e["frame"] + 0.1, "position_px": 50.5} for e in events]
    found = {
        "clip": f"somewhere/{name}.mp4",
        "status": "not_counted" if stated is None else "counted",
        "reason": "too dark" if stated is None else None,
        "count": stated,
        "probability": {} if stated is None else {str(stated): 0.98},
        "collisions": hits[:stated],
    }
    return json.dumps(found) + "\n"


def suite_scored(folder: Path) -> None:
    lines = (
        clip(folder, "noise-full-000", 3, 3),
        clip(folder, "noise-full-001", 5, 4),
        clip(folder, "tilt-full-000", 4, None),
    )
    (folder / "results.jsonl").write_text("".join(lines), "utf-8")


def test_scores_are_gathered_by_condition_and_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    suite_scored(tmp_path)
    assert main(["score", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert printed == (tmp_path / "scores.md").read_text("utf-8")
    rows = [[part.strip() for part in line.split("|")[1:-1]] for line in printed.splitlines()[2:5]]
    assert rows[0] == [
        *("noise", "full", "2", "1", "0", "1", "1", "1", "0", "0"),
        *("0.100", "0.100", "0.500", "0.000"),
    ]
    assert rows[1] == ["tilt", "full", "1", "0", "1", *["0"] * 5, *[""] * 4]
    assert rows[2][:7] == ["all", "", "3", "1", "1", "1", "1"]
    kept = json.loads((tmp_path / "scores.json").read_text("utf-8"))
    assert [cell["condition"] for cell in kept["cells"]] == ["noise", "tilt"]
    assert [score["outcome"] for score in kept["clips"]] == ["exact", "wrong", "not_counted"]


def test_every_clip_that_fell_short_is_said_with_its_answer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    suite_scored(tmp_path)
    main(["score", str(tmp_path)])
    short = [line for line in capsys.readouterr().out.splitlines() if line.startswith("- ")]
    assert [line.split(":")[0] for line in short] == ["- noise-full-001", "- tilt-full-000"]
    assert "true count 5; counted 4 with probability 98%, 1 missed" in short[0]
    assert "too dark" in short[1]


def test_a_clip_without_an_answer_is_not_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    suite_scored(tmp_path)
    clip(tmp_path, "blur-full-000", 3, 3)
    assert main(["score", str(tmp_path)]) == 0
    assert "blur-full-000: true count 3; not counted: there is no answer" in capsys.readouterr().out


def test_without_results_the_command_that_makes_them_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip(tmp_path, "noise-full-000", 3, 3)
    assert main(["score", str(tmp_path)]) == 2
    assert f"count-video --json {tmp_path} > " in capsys.readouterr().err


def test_results_of_other_clips_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = clip(tmp_path, "tilt-full-000", 3, 3)
    (tmp_path / "tilt-full-000.truth.json").unlink()
    clip(tmp_path, "noise-full-000", 3, 3)
    (tmp_path / "other.jsonl").write_text(other, "utf-8")
    assert main(["score", str(tmp_path), str(tmp_path / "other.jsonl")]) == 2
    assert "no answer for any clip" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["no JSON", "[1, 2]"])
def test_broken_results_are_said_in_one_line(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip(tmp_path, "noise-full-000", 3, 3)
    (tmp_path / "results.jsonl").write_text(text, "utf-8")
    assert main(["score", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_reader_that_leaves_ends_the_command_without_a_word() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "synth_video", "suite", "all"]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (128 + signal.SIGPIPE, "")

"""What only a process of its own shows: what it imports, and how it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from importlib.abc import MetaPathFinder
from pathlib import Path

import pytest

import count_video
from count_video.__main__ import run as begin

HEAVY = {"av", "cv2", "numpy", "scipy", "mpmath", "rich", "matplotlib"}

# The command with the work on a clip replaced: "wait" in a name waits to be interrupted.
STAND_IN = """
import time
from dataclasses import replace
from types import SimpleNamespace
from count_video import pipeline
from count_video.records import TrialResult
from count_video.cli import run

def work_through(path, settings, progress):
    if "wait" in path.name:
        print("begun", flush=True)
        time.sleep(600)
    result = TrialResult(str(path), "counted", None, count=0)
    return SimpleNamespace(result=result, track=None, swing=None)

pipeline.work_through = work_through
run()
"""


def started(*arguments: str, stdout: int = subprocess.PIPE) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", STAND_IN, *arguments],
        stdout=stdout,
        stderr=subprocess.PIPE,
        stdin=subprocess.DEVNULL,
        text=True,
    )


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["a.mp4", "--wall", "up"], []])
def test_help_version_and_a_wrong_request_import_nothing_heavy(arguments: list[str]) -> None:
    program = (
        "import sys; from count_video.cli import main; main(sys.argv[1:]);"
        "print('imported', *{name.partition('.')[0] for name in sys.modules})"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], capture_output=True, text=True, check=True
    )
    imported = set(done.stdout.splitlines()[-1].split())
    assert "count_video" in imported
    assert imported & HEAVY == set()


def test_the_module_is_the_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "count_video", "--version"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.startswith("count-video ")


def test_an_interruption_while_the_command_is_loaded_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Loading(MetaPathFinder):
        def find_spec(self, name: str, *_: object) -> None:
            if name == "count_video.cli":
                raise KeyboardInterrupt

    monkeypatch.setattr(sys, "meta_path", [Loading(), *sys.meta_path])
    monkeypatch.delitem(sys.modules, "count_video.cli", raising=False)
    monkeypatch.delattr(count_video, "cli", raising=False)
    with pytest.raises(SystemExit) as left:
        begin()
    assert left.value.code == 130
    assert capsys.readouterr() == ("", "count-video: interrupted\n")


def test_an_interruption_from_outside_ends_in_one_line() -> None:
    with started("first.mp4", "wait.mp4") as process:
        assert process.stdout is not None
        assert "begun\n" in iter(process.stdout.readline, "")
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate()
    assert process.returncode == 130
    assert complaint == "count-video: interrupted\n"


@pytest.mark.parametrize("form", ["--json", ""], ids=["json", "text"])
def test_a_reader_that_leaves_ends_the_command_without_a_word(form: str) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with started(*filter(None, [form]), "a.mp4", "b.mp4", stdout=writer) as process:
        os.close(writer)
        _, complaint = process.communicate()
    assert complaint == ""
    assert process.returncode == 128 + signal.SIGPIPE


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_an_answer_that_cannot_be_written_is_reported() -> None:
    with open("/dev/full", "w") as full, started("a.mp4", stdout=full.fileno()) as process:
        _, complaint = process.communicate()
    assert process.returncode == 1
    assert complaint == "count-video: cannot write what was asked for: No space left on device\n"


def test_the_shell_is_answered_how_an_option_may_go_on(tmp_path: Path) -> None:
    pytest.importorskip("argcomplete", reason="comes with the extra 'completion'")
    answer = tmp_path / "answer"
    line = "count-video a.mp4 --see"
    asked = {"_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line))}
    asked |= {"_ARGCOMPLETE_STDOUT_FILENAME": str(answer), "_ARGCOMPLETE_SHELL": "bash"}
    subprocess.run([sys.executable, "-m", "count_video"], env={**os.environ, **asked}, check=True)
    assert answer.read_text("utf-8").split() == ["--seed", "--seen-only"]

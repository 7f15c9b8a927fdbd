"""A system that lets no more processes start: one clear line, and nothing that waits for ever."""

from __future__ import annotations

import shutil
import threading
from pathlib import Path

import pytest
from command import faults_of
from test_any_request import answer_to

from count_video import parallel
from count_video.errors import MachineError
from count_video.parallel import check_threads

COUNTS_3 = Path(__file__).parents[2] / "fixtures" / "ratio1-count3.mp4"
REAL_START = threading.Thread.start


def refuse_from(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no thread start from a number on, counted from now."""
    started = 0

    def start(thread: threading.Thread) -> None:
        nonlocal started
        started += 1
        if started > number:
            raise RuntimeError("can't start new thread")
        REAL_START(thread)

    monkeypatch.setattr(threading.Thread, "start", start)


@pytest.fixture
def two_clips(tmp_path: Path) -> Path:
    for name in ("one.mp4", "two.mp4"):
        shutil.copy(COUNTS_3, tmp_path / name)
    return tmp_path


def test_threads_that_may_start_leave_none_behind() -> None:
    before = threading.active_count()
    check_threads()
    assert threading.active_count() == before


@pytest.mark.parametrize("number", [0, 1, parallel.THREADS_A_PROCESS - 1])
def test_threads_that_may_not_start_are_an_error_of_the_machine(
    number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = threading.active_count()
    refuse_from(number, monkeypatch)
    with pytest.raises(MachineError, match="no more processes"):
        check_threads()
    assert threading.active_count() == before


@pytest.mark.parametrize("number", [0, 1])
def test_a_campaign_without_threads_is_one_line(
    two_clips: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    refuse_from(number, monkeypatch)
    answer = answer_to("--json", "--jobs=1", str(two_clips))
    assert (answer.code, faults_of(answer)) == (2, [])
    assert "no more processes" in answer.err

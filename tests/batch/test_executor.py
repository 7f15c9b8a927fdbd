from __future__ import annotations

import errno
from collections.abc import Generator, Sequence
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video import pipeline
from count_video.answers import Followed
from count_video.batch.executor import Answer, answer_of, count_job, tool_version
from count_video.batch.manifest import Job
from count_video.batch.summary import run_campaign
from count_video.errors import UsageError
from count_video.pipeline import TrialSettings
from count_video.records import TrialResult
from count_video.result import Result
from count_video.settings import EvidenceSettings

Done = Generator[tuple[Job, Future[Answer]], None, None]


def job(name: str) -> Job:
    return Job(name, f"{name}.mp4", TrialSettings())


def future_of(job: Job) -> Future[Answer]:
    """What comes of a job by its name."""
    future: Future[Answer] = Future()
    if job.name.startswith("dies"):
        future.set_exception(BrokenProcessPool())
    elif job.name == "fault":
        future.set_exception(ZeroDivisionError("a\nfault"))
    elif job.name == "lost":
        future.cancel()
    else:
        tool = "0.0.0" if job.name == "outdated" else tool_version()
        result = Result(Followed(TrialResult(job.clip, "not_counted", job.name)))
        future.set_result(Answer(result, "content", tool))
    return future


def done(jobs: Sequence[Job]) -> Done:
    """Do each job as it is asked for."""
    for one in jobs:
        yield one, future_of(one)


def done_by(*names: str) -> dict[str, str | None]:
    """What became of each job: its answer, or None where it failed."""
    found: dict[str, str | None] = {}
    for asked, future in done([job(name) for name in names]):
        assert asked.name not in found
        answer = answer_of(asked, future)
        found[asked.name] = answer.result.answer.reason if answer.final else None
    return found


def reason_of(name: str) -> str:
    """Why a job failed."""
    ((asked, future),) = done([job(name)])
    answer = answer_of(asked, future)
    assert not answer.final
    return answer.result.answer.reason or ""


def test_every_job_is_answered_once() -> None:
    assert done_by("a", "b", "c", "d") == {name: name for name in "abcd"}


def test_no_job_is_no_work() -> None:
    assert done_by() == {}


@given(st.sets(st.integers(0, 9)))
def test_whatever_dies_every_job_is_answered_and_only_killers_fail(killers: set[int]) -> None:
    names = [f"dies{k}" if k in killers else str(k) for k in range(10)]
    found = done_by(*names)
    assert found == {name: None if name.startswith("dies") else name for name in names}


def test_a_fault_in_the_work_is_the_answer_of_its_job_alone() -> None:
    assert done_by("a", "fault", "c") == {"a": "a", "fault": None, "c": "c"}
    assert "ZeroDivisionError: a fault" in reason_of("fault")


def test_a_job_that_the_cluster_lets_go_fails() -> None:
    assert "let the clip go" in reason_of("lost")


def test_an_answer_of_another_version_of_the_tool_is_refused() -> None:
    assert "the worker has count-video 0.0.0" in reason_of("outdated")


def test_who_leaves_a_campaign_lets_go_of_the_workers() -> None:
    ended: list[bool] = []

    def working(jobs: Sequence[Job]) -> Done:
        try:
            yield from done(jobs)
        finally:
            ended.append(True)

    some = run_campaign([job("a"), job("b")], working, None)
    next(some)
    some.close()
    assert ended == [True]


def test_a_campaign_that_is_done_lets_its_workers_end() -> None:
    ended: list[bool] = []

    def working(jobs: Sequence[Job]) -> Done:
        yield from done(jobs)
        ended.append(True)

    said = list(run_campaign([job("a"), job("b")], working, None))
    assert [one.result.reason for one in said] == ["a", "b"]
    assert ended == [True]


def test_a_failure_is_no_final_answer() -> None:
    assert "the worker died" in reason_of("dies")


@pytest.mark.parametrize("error", [UsageError("cannot write"), OSError(errno.ENOSPC, "full")])
def test_a_count_stands_though_its_pages_cannot_be_drawn(
    error: Exception, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def undrawn(*_: object) -> tuple[str, ...]:
        raise error

    (tmp_path / "a.mp4").touch()
    wanted = Job("a", str(tmp_path / "a.mp4"), TrialSettings(), pages=EvidenceSettings(tmp_path))
    counted = TrialResult("a.mp4", "counted", "", count=31)
    monkeypatch.setattr(pipeline, "work_through", lambda *_: Followed(counted))
    monkeypatch.setattr("count_video.evidence.draw_evidence", undrawn)

    answer = count_job(wanted)
    assert answer.result.count == 31
    assert answer.undrawn in ("cannot write", "full")
    assert not answer.final, "the next run draws them"

    (row,) = run_campaign([wanted], lambda jobs: done_with(jobs, answer), None)
    assert (row.result.count, row.not_kept) == (31, answer.undrawn)


def done_with(jobs: Sequence[Job], answer: Answer) -> Done:
    """Answer each job alike."""
    for one in jobs:
        future: Future[Answer] = Future()
        future.set_result(answer)
        yield one, future

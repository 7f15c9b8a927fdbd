from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.batch.executor import Answer, answers, failure, tool_version
from count_video.batch.manifest import Job
from count_video.batch.summary import run_campaign
from count_video.pipeline import TrialSettings
from count_video.records import unread_result

Work = Callable[[Job], Answer]


def job(name: str) -> Job:
    return Job(name, f"{name}.mp4", TrialSettings())


@dataclass
class PaperWorkers:
    """Workers that do each job as it is handed over, and die on some."""

    killers: frozenset[str] = frozenset()
    """Jobs whose worker dies each time."""
    begun: Counter[str] = field(default_factory=Counter)
    closed: list[bool] = field(default_factory=list)

    def submit(self, work: Work, job: Job) -> Future[Answer]:
        future: Future[Answer] = Future()
        self.begun[job.name] += 1
        if job.name in self.killers:
            future.set_exception(BrokenProcessPool())
        else:
            result = unread_result(job.clip, job.name)
            future.set_result(Answer(result, "content", True, tool_version()))
        return future

    def lost(self) -> bool:
        return False

    def close(self, *, at_once: bool) -> None:
        self.closed.append(at_once)


def done_by(workers: PaperWorkers, *names: str) -> dict[str, str | None]:
    """What became of each job: its answer, or None where it failed."""
    found: dict[str, str | None] = {}
    for asked, answer in answers(map(job, names), workers):
        assert asked.name not in found
        found[asked.name] = answer.result.reason if answer.final else None
    return found


def test_every_job_is_answered_once() -> None:
    workers = PaperWorkers()
    assert done_by(workers, "a", "b", "c", "d") == {name: name for name in "abcd"}
    assert workers.closed == [False]


def test_no_job_is_no_work() -> None:
    assert done_by(PaperWorkers()) == {}


@given(st.sets(st.integers(0, 9)))
def test_whatever_dies_every_job_is_answered_and_only_killers_fail(killers: set[int]) -> None:
    names = [str(k) for k in range(10)]
    found = done_by(PaperWorkers(frozenset(map(str, killers))), *names)
    assert found == {name: None if int(name) in killers else name for name in names}


def test_a_fault_in_the_work_is_the_answer_of_its_job_alone() -> None:
    class Faulty(PaperWorkers):
        def submit(self, work: Work, job: Job) -> Future[Answer]:
            future = super().submit(work, job)
            if job.name == "b":
                future = Future()
                future.set_exception(ZeroDivisionError("a\nfault"))
            return future

    said = dict(answers([job("a"), job("b"), job("c")], Faulty()))
    reason = said[job("b")].result.reason or ""
    assert "ZeroDivisionError: a fault" in reason
    assert [said[job(name)].final for name in "abc"] == [True, False, True]


def test_a_job_that_the_cluster_lets_go_fails() -> None:
    class Careless(PaperWorkers):
        def submit(self, work: Work, job: Job) -> Future[Answer]:
            future: Future[Answer] = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future

    ((_, answer),) = answers([job("a")], Careless())
    assert "let the clip go" in (answer.result.reason or "")


def test_jobs_of_workers_that_are_lost_fail_though_it_never_says_so() -> None:
    class Lost(PaperWorkers):
        def submit(self, work: Work, job: Job) -> Future[Answer]:
            return super().submit(work, job) if job.name in ("a", "b") else Future()

        def lost(self) -> bool:
            return self.begun["b"] > 0

    found = done_by(Lost(), "a", "b", "c", "d", "e")
    assert found == {"a": "a", "b": "b", "c": None, "d": None, "e": None}


def test_an_answer_of_another_version_of_the_tool_is_refused() -> None:
    class Outdated(PaperWorkers):
        def submit(self, work: Work, job: Job) -> Future[Answer]:
            future: Future[Answer] = Future()
            future.set_result(Answer(unread_result("", ""), "content", True, "0.0.0"))
            return future

    ((_, answer),) = answers([job("a")], Outdated())
    assert not answer.final
    assert "the worker has count-video 0.0.0" in (answer.result.reason or "")


def test_an_interruption_ends_the_workers_at_once() -> None:
    class Interrupted(PaperWorkers):
        def submit(self, work: Work, job: Job) -> Future[Answer]:
            raise KeyboardInterrupt

    workers = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        list(answers([job("a")], workers))
    assert workers.closed == [True]


def test_a_campaign_that_is_done_lets_its_workers_end() -> None:
    class Plain(PaperWorkers):
        def submit(self, work: Work, job: Job) -> Future[Answer]:
            future: Future[Answer] = Future()
            future.set_result(failure(job, "nothing to see"))
            return future

    workers = Plain()
    said = list(run_campaign([job("a"), job("b")], lambda: workers, None))
    assert [one.result.reason for one in said] == ["nothing to see"] * 2
    assert workers.closed == [False]


def test_a_failure_is_no_final_answer() -> None:
    assert not failure(job("a"), "the worker died").final

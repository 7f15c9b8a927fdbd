from __future__ import annotations

import json
from collections import Counter
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.campaign.dispatch import answers
from count_video.campaign.fingerprint import tool_version
from count_video.campaign.plan import Job
from count_video.campaign.run import run_campaign
from count_video.campaign.work import Answer, failure
from count_video.trial import TrialSettings


def job(name: str) -> Job:
    return Job(name, f"{name}.mp4", TrialSettings())


@dataclass
class PaperCrew:
    """A crew that does each job as it is handed over, and whose workers die as told.

    As with a pool of processes nothing can be handed over after a death until it is renewed.
    """

    killers: frozenset[str] = frozenset()
    """Jobs whose worker dies each time."""
    window: int = 3
    broken: bool = False
    begun: Counter[str] = field(default_factory=Counter)
    closed: list[bool] = field(default_factory=list)

    def submit(self, job: Job) -> Future[Answer]:
        if self.broken:
            raise BrokenProcessPool
        future: Future[Answer] = Future()
        self.begun[job.name] += 1
        if job.name in self.killers:
            self.broken = True
            future.set_exception(BrokenProcessPool())
        else:
            future.set_result(Answer(f'"{job.name}"', "content", True, tool_version()))
        return future

    def renew(self) -> None:
        self.broken = False

    def lost(self) -> bool:
        return False

    def close(self, *, at_once: bool) -> None:
        self.closed.append(at_once)


def done_by(crew: PaperCrew, *names: str) -> dict[str, str | None]:
    """What became of each job: its answer, or None where it failed."""
    found: dict[str, str | None] = {}
    for asked, answer in answers(map(job, names), crew):
        assert asked.name not in found
        found[asked.name] = json.loads(answer.text) if answer.final else None
    return found


def test_every_job_is_answered_once() -> None:
    crew = PaperCrew()
    assert done_by(crew, "a", "b", "c", "d") == {name: name for name in "abcd"}
    assert crew.closed == [False]


def test_no_job_is_no_work() -> None:
    assert done_by(PaperCrew()) == {}


@given(st.sets(st.integers(0, 9)), st.integers(1, 4))
def test_whatever_dies_every_job_is_answered_and_only_killers_fail(
    killers: set[int], window: int
) -> None:
    names = [str(k) for k in range(10)]
    crew = PaperCrew(frozenset(map(str, killers)), window)
    found = done_by(crew, *names)
    assert found == {name: None if int(name) in killers else name for name in names}
    assert all(number <= 2 for number in crew.begun.values()), "no job is begun a third time"


def test_a_fault_in_the_work_is_the_answer_of_its_job_alone() -> None:
    class Faulty(PaperCrew):
        def submit(self, job: Job) -> Future[Answer]:
            future = super().submit(job)
            if job.name == "b":
                future = Future()
                future.set_exception(ZeroDivisionError("a\nfault"))
            return future

    told = dict(answers([job("a"), job("b"), job("c")], Faulty()))
    reason = json.loads(told[job("b")].text)["reason"]
    assert "ZeroDivisionError: a fault" in reason
    assert [told[job(name)].final for name in "abc"] == [True, False, True]


def test_a_job_that_the_cluster_lets_go_fails() -> None:
    class Careless(PaperCrew):
        def submit(self, job: Job) -> Future[Answer]:
            future: Future[Answer] = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future

    ((_, answer),) = answers([job("a")], Careless())
    assert "let the clip go" in json.loads(answer.text)["reason"]


def test_jobs_of_a_crew_that_is_lost_fail_though_it_never_says_so() -> None:
    class Lost(PaperCrew):
        def submit(self, job: Job) -> Future[Answer]:
            return super().submit(job) if job.name in ("a", "b") else Future()

        def lost(self) -> bool:
            return self.begun["b"] > 0

    found = done_by(Lost(), "a", "b", "c", "d", "e")
    assert found == {"a": "a", "b": "b", "c": None, "d": None, "e": None}


def test_an_answer_of_another_version_of_the_tool_is_refused() -> None:
    class Outdated(PaperCrew):
        def submit(self, job: Job) -> Future[Answer]:
            future: Future[Answer] = Future()
            future.set_result(Answer("{}", "content", True, "0.0.0"))
            return future

    ((_, answer),) = answers([job("a")], Outdated())
    assert not answer.final
    assert "the worker has count-video 0.0.0" in json.loads(answer.text)["reason"]


def test_an_interruption_sends_the_crew_home_at_once() -> None:
    class Interrupted(PaperCrew):
        def submit(self, job: Job) -> Future[Answer]:
            raise KeyboardInterrupt

    crew = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        list(answers([job("a")], crew))
    assert crew.closed == [True]


def test_a_campaign_that_is_done_lets_its_crew_go_in_peace() -> None:
    class Plain(PaperCrew):
        def submit(self, job: Job) -> Future[Answer]:
            future: Future[Answer] = Future()
            future.set_result(failure(job, "nothing to see"))
            return future

    crew = Plain()
    told = list(run_campaign([job("a"), job("b")], lambda: crew, None))
    assert [one.row.reason for one in told] == ["nothing to see"] * 2
    assert crew.closed == [False]


def test_a_failure_is_no_final_answer() -> None:
    assert not failure(job("a"), "the worker died").final

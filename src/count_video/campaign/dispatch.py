"""Hand jobs to a crew and take the answers as they come; nothing that fails stops the others."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait

from count_video.campaign.crew import Crew
from count_video.campaign.fingerprint import tool_version
from count_video.campaign.plan import Job
from count_video.campaign.work import Answer, failure

Answered = tuple[Job, Answer]
LOOK_EVERY_S = 1.0
"""While no answer comes, the crew is asked so often whether it is still there."""


def answers(jobs: Iterable[Job], crew: Crew) -> Iterator[Answered]:
    """Yield every job with its answer, in the order in which they come.

    When a worker dies it is not known whose clip did it. So all jobs that were under way are done
    again at the end, one at a time: the one that kills its worker again is to blame and fails,
    the others have lost nothing but time.
    """
    at_once = True
    try:
        suspects = yield from _round(jobs, crew, crew.window)
        for suspect in suspects:
            guilty = yield from _round([suspect], crew, 1)
            for job in guilty:
                yield job, failure(job, "the worker died on this clip, twice; look at the clip")
        at_once = False
    finally:
        crew.close(at_once=at_once)


def _round(jobs: Iterable[Job], crew: Crew, window: int) -> Generator[Answered, None, list[Job]]:
    """Do the jobs, ``window`` at a time; return those that were under way as a worker died."""
    waiting = deque(jobs)
    running: dict[Future[Answer], Job] = {}
    suspects: list[Job] = []
    while waiting or running:
        lost = crew.lost()
        broken = not lost and not _hand_over(waiting, running, crew, window)
        done, _ = wait(running, LOOK_EVERY_S, FIRST_COMPLETED)
        if lost and not done:
            yield from ((job, _let_go(job)) for job in (*running.values(), *waiting))
            return suspects
        for future in done:
            job = running.pop(future)
            if _died(future):
                suspects.append(job)
                broken = True
            else:
                yield job, _answer(job, future)
        if broken:
            # The others under way end the same way at once, or are already done.
            for future in wait(running).done:
                job = running.pop(future)
                if _died(future):
                    suspects.append(job)
                else:
                    yield job, _answer(job, future)
            crew.renew()
    return suspects


def _hand_over(
    waiting: deque[Job], running: dict[Future[Answer], Job], crew: Crew, window: int
) -> bool:
    """Fill the window; false if a worker died that had nothing to do."""
    while waiting and len(running) < window:
        try:
            running[crew.submit(waiting[0])] = waiting[0]
        except BrokenExecutor:
            return False
        waiting.popleft()
    return True


def _died(future: Future[Answer]) -> bool:
    return not future.cancelled() and isinstance(future.exception(), BrokenExecutor)


def _answer(job: Job, future: Future[Answer]) -> Answer:
    if future.cancelled():
        return _let_go(job)
    error = future.exception()
    if error is not None:
        # Not the clip's error but the program's (or the cluster's): the others are not to suffer.
        told = " ".join(f"{type(error).__name__}: {error}".split())
        return failure(job, f"the work on this clip failed ({told}); please report it")
    answer = future.result()
    if answer.tool != tool_version():
        return failure(
            job, f"the worker has count-video {answer.tool}, not {tool_version()}; install the same"
        )
    return answer


def _let_go(job: Job) -> Answer:
    return failure(job, "the cluster let the clip go; look at its scheduler and start again")

"""Work in processes: results as they come, and what dies costs nothing but itself."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Generator
from concurrent.futures import BrokenExecutor
from contextlib import closing

import pytest

from count_video.parallel import as_done

DYING = -1


def slept(seconds: float) -> float:
    if seconds == DYING:
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(max(seconds, 0))
    return seconds


def died(seconds: float) -> float:
    return -100.0 + seconds


def failing(number: int) -> int:
    raise ZeroDivisionError(f"a fault with {number}")


def done_in_parallel(
    work: Callable[[float], float], jobs: list[float], workers: int
) -> Generator[float, None, None]:
    with closing(as_done(work, jobs, workers)) as done:
        for job, future in done:
            dead = isinstance(future.exception(), BrokenExecutor)
            yield died(job) if dead else future.result()


def slept_in_parallel(jobs: list[float], workers: int = 2) -> Generator[float, None, None]:
    return done_in_parallel(slept, jobs, workers)


def test_what_is_done_first_comes_first() -> None:
    assert next(iter(slept_in_parallel([4.0, 0.0]))) == 0.0


@pytest.mark.parametrize("workers", [1, 3])
def test_each_job_has_one_result(workers: int) -> None:
    jobs = [0.0, 0.01, 0.02, 0.03, 0.04]
    assert sorted(slept_in_parallel(jobs, workers)) == jobs


def test_no_jobs_have_no_results() -> None:
    assert list(slept_in_parallel([])) == []


def test_a_process_that_dies_costs_its_own_job_alone() -> None:
    jobs = [0.5, DYING, 0.1, 0.2, 0.3]
    assert sorted(slept_in_parallel(jobs)) == sorted([died(DYING), 0.1, 0.2, 0.3, 0.5])


def test_a_fault_of_the_program_is_raised() -> None:
    with pytest.raises(ZeroDivisionError, match="a fault with 7"):
        list(done_in_parallel(failing, [7], 1))


def test_a_loop_that_is_left_begins_no_more_jobs() -> None:
    results = slept_in_parallel([0.0] * 3 + [600.0] * 5, workers=1)
    assert next(results) == 0.0
    results.close()  # waits for what has begun

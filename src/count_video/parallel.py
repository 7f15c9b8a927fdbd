"""One function over many jobs, in processes of this machine; results as they come.

A process that dies (for want of memory, say) costs its own job alone: which of the jobs under way
it was is not known, so each of them is done again by itself, and what dies again is to blame.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import TypeVar

_Job = TypeVar("_Job")
_Done = TypeVar("_Done")


def in_parallel(
    work: Callable[[_Job], _Done],
    jobs: Iterable[_Job],
    workers: int | None,
    died: Callable[[_Job], _Done],
) -> Iterator[_Done]:
    """Yield the result of every job, in the order in which they come.

    Parameters
    ----------
    work
        Done with each job; a function of a module, as processes need it.
    workers
        How many jobs to do at the same time; None: one for every core that is ours.
    died
        Makes the result of a job on which its process died.
    """
    several = workers or cores()
    suspects = yield from _round(work, jobs, several)
    for job in suspects:
        guilty = yield from _round(work, [job], 1)
        yield from map(died, guilty)


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _round(
    work: Callable[[_Job], _Done], jobs: Iterable[_Job], workers: int
) -> Generator[_Done, None, list[_Job]]:
    """Do the jobs, ``workers`` at a time; return those under way as a process died."""
    waiting, running = deque(jobs), dict[Future[_Done], _Job]()
    suspects: list[_Job] = []
    while waiting:
        # Started fresh, not forked, which the threads of the video library do not survive.
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(min(workers, len(waiting)), context, _begin)
        try:
            while waiting or running:
                while waiting and len(running) < workers:
                    running[pool.submit(work, waiting[0])] = waiting[0]
                    waiting.popleft()
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    done = future.result()
                    del running[future]
                    yield done
        except BrokenProcessPool:
            suspects += running.values()
            running.clear()
        finally:
            pool.shutdown(cancel_futures=True)
    return suspects


def _begin() -> None:
    """Set up a process: Ctrl-C ends it without a word, and its linear algebra uses one thread.

    The libraries read their settings as they are imported, which has not happened yet.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    for name in ("COUNT_VIDEO_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(name, "1")

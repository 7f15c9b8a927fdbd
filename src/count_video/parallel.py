"""One function over many jobs, in processes of this machine; results as they come.

Each thread of a pool has a process of its own: one that dies (for want of memory, say) takes no
other job with it. Its job is done again in a new one, and what dies twice is to blame itself.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    BrokenExecutor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    as_completed,
)
from multiprocessing.connection import wait
from typing import TypeVar

_Job = TypeVar("_Job")
_Done = TypeVar("_Done")
ATTEMPTS = 2
"""A process that died may have been killed by chance; after two the job is to blame."""
KILL_TIMEOUT_S = 2
_ONE_THREAD = (
    *("COUNT_VIDEO_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"),
)
"""Environment variables that are 1 for the processes, unless they are set already."""


def in_parallel(
    work: Callable[[_Job], _Done],
    jobs: Iterable[_Job],
    workers: int | None,
    died: Callable[[_Job], _Done],
) -> Iterator[_Done]:
    """Yield the result of every job, in the order in which they come.

    Whoever leaves the loop early ends the processes.

    Parameters
    ----------
    work
        Done with each job; a function of a module, as processes need it.
    workers
        How many jobs to do at the same time; None: one for every core that is ours.
    died
        Makes the result of a job on which its process died.
    """
    processes = Processes(workers)
    at_once = True
    try:
        running = {processes.submit(work, job): job for job in jobs}
        for future in as_completed(running):
            broken = isinstance(future.exception(), BrokenExecutor)
            yield died(running[future]) if broken else future.result()
        at_once = False
    finally:
        processes.close(at_once=at_once)


class Processes:
    """Processes on this machine, started fresh (not forked, which threads do not survive)."""

    def __init__(self, workers: int | None = None) -> None:
        """Have ``workers`` at the most (None: one for every core); each starts when needed."""
        self._others = set(multiprocessing.active_children())
        self._own = threading.local()
        self._pools: list[ProcessPoolExecutor] = []
        self._ended = False
        # The processes inherit these, so they hold before the first import.
        self._environment = {name: os.environ.get(name) for name in _ONE_THREAD}
        os.environ.update({name: self._environment[name] or "1" for name in _ONE_THREAD})
        self._threads = ThreadPoolExecutor(workers or cores(), initializer=_ignore_ctrl_c)

    def submit(self, work: Callable[[_Job], _Done], job: _Job) -> Future[_Done]:
        """Hand over a job; its future has a ``BrokenExecutor`` if its process dies twice."""
        return self._threads.submit(self._do, work, job)

    def _do(self, work: Callable[[_Job], _Done], job: _Job) -> _Done:
        """Do a job in this thread's process; one that dies is replaced once."""
        for attempt in range(1, ATTEMPTS + 1):
            if not hasattr(self._own, "process"):
                context = multiprocessing.get_context("spawn")
                self._own.process = ProcessPoolExecutor(1, context, _follow_the_parent)
                self._pools.append(self._own.process)
            try:
                done: _Done = self._own.process.submit(work, job).result()
            except BrokenExecutor:
                del self._own.process
                if self._ended or attempt == ATTEMPTS:
                    raise
            else:
                return done
        raise AssertionError("the last attempt returns or raises")

    def close(self, *, at_once: bool) -> None:
        """End the processes; ``at_once``: whatever they are doing."""
        if at_once:
            self.kill()
        self._threads.shutdown(cancel_futures=at_once)
        # Waits until the pools have taken notice: an interpreter that ends before may complain.
        for pool in self._pools:
            pool.shutdown()
        for name, value in self._environment.items():
            if value is None:
                os.environ.pop(name, None)

    def kill(self) -> None:
        """End the processes at once and wait until they are gone."""
        self._ended = True
        processes = set(multiprocessing.active_children()) - self._others
        for process in processes:
            process.kill()
        for process in processes:
            process.join(KILL_TIMEOUT_S)


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _ignore_ctrl_c() -> None:
    """Let processes that this thread starts be deaf to Ctrl-C, which reaches all of a terminal's.

    Who started them decides what it means.
    """
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _follow_the_parent() -> None:
    """End this process when the one that started it is gone, even killed.

    A pool's processes wait for work on a pipe that they hold open themselves, so they would wait
    forever.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_leave_after, args=(parent.sentinel,), daemon=True).start()


def _leave_after(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)

"""One function over many jobs, in processes of this machine or elsewhere; results as they come.

Each thread of a pool has a process of its own: one that dies (for want of memory, say) takes no
other job with it. Its job is done again in a new one, and what dies twice is to blame itself.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent import futures
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait
from typing import Protocol, TypeVar

from count_video.errors import MachineError

_Job = TypeVar("_Job")
_Done = TypeVar("_Done")
ATTEMPTS = 2
"""A process that died may have been killed by chance; after two the job is to blame."""
KILL_TIMEOUT_S = 2
ASK_EVERY_S = 1.0
"""While nothing comes, the workers are asked so often whether they are still there."""
THREADS_A_PROCESS = 8
"""Who starts a process has two threads for it, and the process has some of its own."""
_ONE_THREAD = (
    *("COUNT_VIDEO_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"),
)
"""Environment variables that are 1 for the processes, unless they are set already."""


class Workers(Protocol):
    """Who does jobs: processes of this machine, or other machines."""

    def submit(self, work: Callable[[_Job], _Done], job: _Job) -> Future[_Done]:
        """Hand over a job; its future has a ``BrokenExecutor`` if its process dies twice."""

    def lost(self) -> bool:
        """Return whether nobody is left to do or answer anything."""

    def close(self, *, at_once: bool) -> None:
        """End the workers; ``at_once``: whatever they are doing."""


def as_done(
    work: Callable[[_Job], _Done], jobs: Iterable[_Job], workers: Workers
) -> Generator[tuple[_Job, Future[_Done]], None, None]:
    """Yield every job with its future, which is done, in the order in which they come.

    A future is cancelled if its workers are lost. They are closed at the end; at once, if the loop
    is left early. ``work`` is a function of a module, as processes need it.
    """
    running: dict[Future[_Done], _Job] = {}
    at_once = True
    try:
        for job in jobs:
            running[workers.submit(work, job)] = job
        while running:
            done, _ = futures.wait(running, ASK_EVERY_S, futures.FIRST_COMPLETED)
            if not done and workers.lost():
                gone: Future[_Done] = Future()
                gone.cancel()
                yield from ((job, gone) for job in running.values())
                return
            yield from ((running.pop(future), future) for future in done)
        at_once = False
    finally:
        workers.close(at_once=at_once)


class Processes:
    """Processes on this machine, started fresh (not forked, which threads do not survive)."""

    def __init__(self, workers: int | None = None) -> None:
        """Have ``workers`` at the most (None: one for every core); each starts when needed."""
        self._others = set(multiprocessing.active_children())
        self._own = threading.local()
        self._pools: list[ProcessPoolExecutor] = []
        self._starting = threading.Lock()
        self._ended = False
        # The processes inherit these, so they hold before the first import.
        self._added = [name for name in _ONE_THREAD if not os.environ.get(name)]
        os.environ.update(dict.fromkeys(self._added, "1"))
        self._threads = ThreadPoolExecutor(workers or _cores(), initializer=_ignore_ctrl_c)

    def submit(self, work: Callable[[_Job], _Done], job: _Job) -> Future[_Done]:
        """Hand over a job to a thread with a process of its own; MachineError if none may start."""
        with _limits_explained():
            return self._threads.submit(self._do, work, job)

    def _do(self, work: Callable[[_Job], _Done], job: _Job) -> _Done:
        """Do a job in this thread's process; one that dies is replaced once."""
        for attempt in range(1, ATTEMPTS + 1):
            try:
                # A process starts with its first job, under the lock: none escapes a kill.
                with self._starting:
                    if self._ended:
                        raise BrokenExecutor("the processes were ended")
                    future = self._pool().submit(work, job)
                return future.result()
            except BrokenExecutor:
                vars(self._own).pop("process", None)
                if self._ended or attempt == ATTEMPTS:
                    raise
        raise AssertionError("the last attempt returns or raises")

    def _pool(self) -> ProcessPoolExecutor:
        """Return the pool of this thread's one process."""
        if not hasattr(self._own, "process"):
            check_threads()
            context = multiprocessing.get_context("spawn")
            self._own.process = ProcessPoolExecutor(1, context, _follow_the_parent)
            self._pools.append(self._own.process)
        pool: ProcessPoolExecutor = self._own.process
        return pool

    def lost(self) -> bool:
        """Return False: dead processes are replaced."""
        return False

    def close(self, *, at_once: bool) -> None:
        """End the processes; ``at_once``: whatever they are doing."""
        if at_once:
            self.kill()
        self._threads.shutdown(cancel_futures=at_once)
        # Waits until the pools have taken notice: an interpreter that ends before may complain.
        for pool in self._pools:
            pool.shutdown()
        for name in self._added:
            os.environ.pop(name, None)

    def kill(self) -> None:
        """End the processes at once and wait until they are gone."""
        with self._starting:
            self._ended = True
        processes = set(multiprocessing.active_children()) - self._others
        for process in processes:
            process.kill()
        for process in processes:
            process.join(KILL_TIMEOUT_S)


@contextmanager
def _limits_explained() -> Iterator[None]:
    """Turn the error of a thread that the system does not let start into one of ours."""
    try:
        yield
    except RuntimeError as error:
        raise MachineError(
            "the system lets this program start no more processes (ulimit -u); close other "
            "programs, or count fewer clips at a time (--jobs)"
        ) from error


def check_threads() -> None:
    """Raise MachineError unless a process can start with the threads that it needs.

    A pool whose threads do not start waits for ever, or fails in ways of its own.
    """
    enough = threading.Event()
    started: list[threading.Thread] = []
    try:
        with _limits_explained():
            for _ in range(THREADS_A_PROCESS):
                thread = threading.Thread(target=enough.wait)
                thread.start()
                started.append(thread)
    finally:
        enough.set()
        for thread in started:
            thread.join()


def _cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _ignore_ctrl_c() -> None:
    """Let processes that this thread starts ignore Ctrl-C; who started them decides what it means.

    It reaches all processes of a terminal.
    """
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _follow_the_parent() -> None:
    """End this process when the one that started it is gone, even killed.

    A pool's processes wait for work on a pipe that they hold open themselves: forever, otherwise.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def leave_after_it() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=leave_after_it, daemon=True).start()

"""One function over many jobs, in processes of this machine; results as they come.

Each process is a pool of its own: one that dies (for want of memory, say) takes no other job with
it. Its job is done again in a new one, and what dies twice is to blame itself.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Collection, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from typing import Any, TypeVar

from count_video.errors import MachineError
from count_video.process import spare_the_processor, usable_cores

_Job = TypeVar("_Job")
_Done = TypeVar("_Done")
ATTEMPTS = 2
"""A process that died may have been killed by chance; after two the job is to blame."""
KILL_TIMEOUT_S = 2
THREADS_A_PROCESS = 8
"""Who starts a process has two threads for it, and the process has some of its own."""
_ONE_THREAD = ("COUNT_VIDEO_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that are 1 for the processes, unless they are set already."""


def as_done(
    work: Callable[[_Job], _Done], jobs: Iterable[_Job], processes: int | None = None
) -> Generator[tuple[_Job, Future[_Done]], None, None]:
    """Yield every job with its future, which is done, in the order in which they come.

    ``work`` is a function of a module, as processes need it; at most ``processes`` (None: one for
    every core) do it. A future has a ``BrokenExecutor`` if the process died twice. If the loop is
    left early, the processes are ended at once. MachineError if none may start.
    """
    others = multiprocessing.active_children()
    waiting = deque((job, 1) for job in jobs)
    running: dict[Future[_Done], tuple[ProcessPoolExecutor, _Job, int]] = {}
    pools: list[ProcessPoolExecutor] = []
    # None is one to start.
    free: list[ProcessPoolExecutor | None] = [None] * (processes or usable_cores())
    try:
        while waiting or running:
            while waiting and free:
                pool = free.pop()
                if pool is None:
                    check_threads()
                    spawn = multiprocessing.get_context("spawn")  # threads do not survive a fork
                    pool = ProcessPoolExecutor(1, spawn, _start_well)
                    pools.append(pool)
                job, attempt = waiting.popleft()
                with _inherited():
                    running[pool.submit(work, job)] = (pool, job, attempt)
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                pool, job, attempt = running.pop(future)
                died = isinstance(future.exception(), BrokenExecutor)
                free.append(None if died else pool)
                if died and attempt < ATTEMPTS:
                    waiting.appendleft((job, attempt + 1))
                else:
                    yield job, future
    finally:
        if running:
            end_processes(others)
        # Waits until the pools have taken notice: an interpreter that ends before may complain.
        for pool in pools:
            pool.shutdown(cancel_futures=True)


def end_processes(others: Collection[BaseProcess] = ()) -> None:
    """End the processes that this one started, but for ``others``, and wait until they are gone."""
    processes = [one for one in multiprocessing.active_children() if one not in others]
    for process in processes:
        process.kill()
    for process in processes:
        process.join(KILL_TIMEOUT_S)


def check_threads() -> None:
    """Raise MachineError unless a process can start with the threads that it needs.

    A pool whose threads do not start waits for ever, or fails in ways of its own.
    """
    enough = threading.Event()
    started: list[threading.Thread] = []
    try:
        for _ in range(THREADS_A_PROCESS):
            thread = threading.Thread(target=enough.wait)
            thread.start()
            started.append(thread)
    except RuntimeError as error:
        raise MachineError(
            "the system lets this program start no more processes (ulimit -u); close other "
            "programs, or count fewer clips at a time (--jobs)"
        ) from error
    finally:
        enough.set()
        for thread in started:
            thread.join()


@contextmanager
def _inherited() -> Iterator[None]:
    """Have processes that start now compute in one thread each, and ignore Ctrl-C.

    It reaches all processes of a terminal; who started them decides what it means.
    """
    added = [name for name in _ONE_THREAD if not os.environ.get(name)]
    os.environ.update(dict.fromkeys(added, "1"))
    masks = hasattr(signal, "pthread_sigmask")
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if masks else set()
    try:
        yield
    finally:
        for name in added:
            del os.environ[name]
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_well() -> None:
    """Spare the processor, and end this process when the one that started it is gone, even killed.

    A pool's processes wait for work on a pipe that they hold open themselves: forever, otherwise.
    """
    spare_the_processor()
    parent: Any = multiprocessing.parent_process()

    def leave_after_it() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=leave_after_it, daemon=True).start()

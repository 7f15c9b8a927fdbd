"""Who does the work: processes of this machine, or a Dask cluster, behind one interface.

A crew takes jobs and gives futures. What differs is how it starts, how it stops at once, and how
many jobs it should hold at a time.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait
from typing import Any, Protocol

from count_video.campaign.plan import Job
from count_video.campaign.work import Answer, count_job
from count_video.errors import UsageError

_ONE_THREAD = {
    "COUNT_VIDEO_THREADS": "1",  # decoders
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
CONNECT_TIMEOUT_S = 10
KILL_TIMEOUT_S = 2


class Crew(Protocol):
    """Workers that count clips."""

    @property
    def window(self) -> int:
        """How many jobs to hand over before the first is done."""

    def submit(self, job: Job) -> Future[Answer]:
        """Hand over a job.

        Raises
        ------
        BrokenExecutor
            If a worker died; ``renew`` helps.
        """

    def renew(self) -> None:
        """Begin anew after a worker died; jobs that were under way are lost."""

    def lost(self) -> bool:
        """Whether nobody is left to do or answer anything."""

    def close(self, *, at_once: bool) -> None:
        """Send the workers home; ``at_once``: whatever they are doing."""


class LocalCrew:
    """Processes on this machine, started fresh (not forked, which threads do not survive)."""

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._strangers = set(multiprocessing.active_children())
        self._pool: ProcessPoolExecutor | None = None

    @property
    def window(self) -> int:
        """As many as work at a time: so those under way when one dies are known."""
        return self._workers

    def submit(self, job: Job) -> Future[Answer]:
        """Hand over a job; the first ones start the processes."""
        if self._pool is None:
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(self._workers, context, _follow_the_parent)
        with _as_workers_start():
            return self._pool.submit(count_job, job)

    def renew(self) -> None:
        """Replace the processes."""
        if self._pool is not None:
            self._pool.shutdown()
            self._pool = None

    def lost(self) -> bool:
        """Tell that it never is: dead processes are replaced."""
        return False

    def close(self, *, at_once: bool) -> None:
        """End the processes."""
        if self._pool is not None:
            if at_once:
                self.kill()
            # Waits until the pool has taken notice: an interpreter that ends before may complain.
            self._pool.shutdown(cancel_futures=at_once)

    def kill(self) -> None:
        """End the processes at once and wait until they are gone."""
        workers = set(multiprocessing.active_children()) - self._strangers
        for process in workers:
            process.kill()
        for process in workers:
            process.join(KILL_TIMEOUT_S)


class ClusterCrew:
    """The workers of a Dask cluster; its scheduler hands a dead worker's jobs to others."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._executor: Executor = client.get_executor(pure=False)

    @property
    def window(self) -> int:
        """Enough to keep any cluster busy; its scheduler does the queueing."""
        return 4096

    def submit(self, job: Job) -> Future[Answer]:
        """Hand over a job."""
        return self._executor.submit(count_job, job)

    def renew(self) -> None:
        """Do nothing: the scheduler sees to its workers."""

    def lost(self) -> bool:
        """Tell whether the scheduler is gone; some of its futures then never end."""
        return str(self._client.status) in ("closing", "closed")

    def close(self, *, at_once: bool) -> None:
        """Let go of the cluster, which lives on."""
        if not self.lost():
            self._executor.shutdown(wait=not at_once)
        self._client.close()


def local_crew(workers: int | None = None) -> LocalCrew:
    """Make a crew of this machine (None: a process for every core that is ours)."""
    return LocalCrew(workers or cores())


def cluster_crew(address: str) -> ClusterCrew:
    """Join a Dask cluster at the address of its scheduler, such as ``tcp://host:8786``.

    Raises
    ------
    UsageError
        Dask is not installed, or no scheduler answers there.
    """
    try:
        import dask  # noqa: PLC0415 - an extra that few need

        # Dask reads this as it is imported. A lost worker is no news, its clips are done again; a
        # lost scheduler is told in the rows of the clips that it had.
        loggers = ("distributed", "distributed.client", "tornado.application", "asyncio")
        quiet = dict.fromkeys(loggers, "critical")
        with dask.config.set({"logging": quiet}):
            import distributed  # noqa: PLC0415
    except ImportError as error:
        raise UsageError(
            "--scheduler needs Dask; install it with: pip install 'count-video[distributed]'"
        ) from error
    # A client that never joined would wait for the cluster once more as it is thrown away; one that
    # did is closed by its crew.
    join: Any = type("_Client", (distributed.Client,), {"__del__": lambda _: None})
    try:
        return ClusterCrew(join(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False))
    except (OSError, ValueError, TypeError, RuntimeError, ImportError) as error:
        # Each kind of address fails with an error of its own: one without certificates with a
        # TypeError, one that needs a missing library with an ImportError.
        raise UsageError(f"no Dask scheduler answers at {address}; start it first") from error


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _as_workers_start() -> Iterator[None]:
    """Let processes that start now be deaf to Ctrl-C and work in one thread.

    Ctrl-C reaches all processes of a terminal; who started the workers decides what it means. The
    mask of signals and the environment are inherited, so they hold before the first import.
    """
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update({name: value for name, value in _ONE_THREAD.items() if not before[name]})
    held = hasattr(signal, "pthread_sigmask")
    if held:
        old = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
        if held:
            signal.pthread_sigmask(signal.SIG_SETMASK, old)


def _follow_the_parent() -> None:
    """End this worker when the process that started it is gone, even killed.

    A pool's workers wait for work on a pipe that they hold open themselves, so they would wait
    forever.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_leave_after, args=(parent.sentinel,), daemon=True).start()


def _leave_after(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)

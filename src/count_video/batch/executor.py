"""The work on the clips of a campaign: in processes of this machine, or on a Dask cluster.

Both take jobs and give futures.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from concurrent.futures import BrokenExecutor, Future
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

import cv2

import count_video
from count_video import pipeline
from count_video.batch.manifest import Job
from count_video.errors import (
    CountVideoError,
    FootageError,
    MachineError,
    TrackingError,
    UsageError,
    reason_of,
)
from count_video.followed import Followed, followed, packed, unpacked
from count_video.inputs import content_digest
from count_video.outputs import clear_unfinished
from count_video.parallel import Processes, Workers, as_done
from count_video.process import before_the_end, shortage_explained
from count_video.records import TrialResult, unread_result
from count_video.reports.json_object import SCHEMA_VERSION

_Job = TypeVar("_Job")
_Done = TypeVar("_Done")
CONNECT_TIMEOUT_S = 10


@dataclass(frozen=True)
class Answer:
    """What came of a job."""

    result: TrialResult
    content: str | None
    """Digest of the clip; None where it could not be read."""
    final: bool
    """True if the same clip, options and tool would give the same answer again."""
    tool: str
    """Version of the tool that did the work."""
    evidence: tuple[str, ...] = ()
    """Names of the files that show the result."""
    followed: str | None = None
    """What the evidence can be drawn from, as text; None where there is nothing to draw."""


@cache
def tool_version() -> str:
    """Version of the tool, with a digest of its source: between releases the code changes too."""
    package = Path(count_video.__file__).parent
    digest = sha256()
    for file in sorted(package.rglob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode())
        digest.update(file.read_bytes())
    return f"{count_video.__version__}+schema{SCHEMA_VERSION}+{digest.hexdigest()[:16]}"


def count_job(job: Job) -> Answer:
    """Count one clip; what is wrong with it becomes its answer, faults of the program are raised.

    Workers share the cores between them, so each does its own work in one thread.
    """
    cv2.setNumThreads(1)
    if job.problem is not None:
        return failure(job, job.problem)
    answer = failure(job, "")
    try:
        answer = replace(answer, content=content_digest(job.file))
        with shortage_explained():
            found = _followed(job)
            result = replace(found.result, clip=job.clip)
            answer = replace(answer, result=result, final=True, followed=packed(found))
            return replace(answer, evidence=_drawn(job, found))
    except (CountVideoError, OSError) as error:
        result = unread_result(job.clip, reason_of(error, job.file))
        # What hinders the work, a full disk for example, may be gone the next time.
        return replace(answer, result=result, final=isinstance(error, FootageError | TrackingError))


def _followed(job: Job) -> Followed:
    """Return what an earlier run counted and followed, or do so now."""
    if job.followed is not None:
        with suppress(ValueError):
            found = unpacked(Followed, job.followed)
            return replace(found, result=replace(found.result, clip=str(job.file)))
    return followed(pipeline.work_through(job.file, job.settings))


def _drawn(job: Job, found: Followed) -> tuple[str, ...]:
    """Draw the pages that the job wants; return the names of their files."""
    if job.pages is None:
        return ()
    from count_video.evidence import draw_evidence  # noqa: PLC0415 - matplotlib takes time

    folder = Path(job.start, job.pages.folder)
    return draw_evidence(found, replace(job.pages, folder=folder, name=job.name))


def failure(job: Job, reason: str) -> Answer:
    """Make the answer of a job that failed for a reason other than its clip."""
    return Answer(unread_result(job.clip, reason), None, False, tool_version())


def answers(jobs: Iterable[Job], workers: Workers) -> Generator[tuple[Job, Answer], None, None]:
    """Yield every job with its answer, as they come; what fails is the answer of its job alone."""
    with closing(as_done(count_job, jobs, workers)) as done:
        for job, future in done:
            yield job, _answer(job, future)


def _answer(job: Job, future: Future[Answer]) -> Answer:
    if future.cancelled():
        return failure(job, "the cluster let the clip go; check its scheduler and start again")
    error = future.exception()
    if error is None:
        answer, ours = future.result(), tool_version()
        if answer.tool == ours:
            return answer
        reason = f"the worker has count-video {answer.tool}, not {ours}; install the same"
    elif isinstance(error, BrokenExecutor):
        reason = "the worker died on this clip, twice; play the clip, or convert it"
    elif isinstance(error, MachineError):
        reason = str(error)
    else:  # not the clip's error but the program's (or the cluster's): the others do not suffer
        words = " ".join(f"{type(error).__name__}: {error}".split())
        reason = f"the work on this clip failed ({words}); please report it"
    return failure(job, reason)


def start_workers(number: int | None, scheduler: str | None, folder: Path | None) -> Workers:
    """Join a cluster, or have processes here, which end and leave nothing when a signal comes."""
    if scheduler is not None:
        return ClusterWorkers(scheduler)
    workers = Processes(number)
    if folder is not None:
        before_the_end(partial(clear_unfinished, folder))
    before_the_end(workers.kill)  # the latest comes first
    return workers


class ClusterWorkers:
    """The workers of a Dask cluster; its scheduler hands a dead worker's jobs to others."""

    def __init__(self, address: str) -> None:
        """Join a cluster at the address of its scheduler, such as ``tcp://host:8786``.

        UsageError if Dask is not installed, or no scheduler answers there.
        """
        client = _dask_client()
        try:
            self._client = client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
        except (OSError, ValueError, TypeError, RuntimeError, ImportError) as error:
            # Each kind of address fails with an error of its own: one without certificates with a
            # TypeError, one that needs a missing library with an ImportError.
            raise UsageError(f"no Dask scheduler answers at {address}; start it first") from error
        self._executor = self._client.get_executor(pure=False)

    def submit(self, work: Callable[[_Job], _Done], job: _Job) -> Future[_Done]:
        """Hand over a job."""
        future: Future[_Done] = self._executor.submit(work, job)
        return future

    def lost(self) -> bool:
        """Return whether the scheduler is gone; some of its futures then never end."""
        return str(self._client.status) in ("closing", "closed")

    def close(self, *, at_once: bool) -> None:
        """Let go of the cluster, which lives on."""
        if not self.lost():
            self._executor.shutdown(wait=not at_once)
        self._client.close()


def _dask_client() -> Any:
    """Return Dask's client, made to say nothing of its own accord."""
    try:
        import dask  # noqa: PLC0415 - an extra that few need

        # Dask reads this as it is imported. A lost worker is no news, its clips are done again; a
        # lost scheduler stands in the rows of the clips that it had.
        loggers = ("distributed", "distributed.client", "tornado.application", "asyncio")
        with dask.config.set({"logging": dict.fromkeys(loggers, "critical")}):
            import distributed  # noqa: PLC0415
    except ImportError as error:
        raise UsageError(
            "--scheduler needs Dask; install it with: pip install 'count-video[distributed]'"
        ) from error
    # A client that never joined would wait for the cluster once more as it is thrown away; one that
    # did is closed by its owner.
    return type("_Client", (distributed.Client,), {"__del__": lambda _: None})

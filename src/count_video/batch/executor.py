"""The work on the clips of a campaign: in processes of this machine, or on a Dask cluster.

Both take jobs and give futures.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import cv2

import count_video
from count_video import pipeline
from count_video.answers import Followed
from count_video.batch.manifest import Job
from count_video.errors import CountVideoError, FootageError, TrackingError, UsageError, reason_of
from count_video.inputs import content_digest, signature
from count_video.parallel import as_done
from count_video.process import shortage_explained
from count_video.records import TrialResult
from count_video.reports.exports import SCHEMA_VERSION
from count_video.result import Result, refused

CONNECT_TIMEOUT_S = 10
ASK_EVERY_S = 1.0
"""While nothing comes from a cluster, it is asked so often whether it is still there."""


@dataclass(frozen=True)
class Answer:
    """What came of a job."""

    result: Result
    content: str | None
    """Digest of the clip; None where it could not be read."""
    tool: str
    """Version of the tool that did the work."""
    evidence: tuple[str, ...] = ()
    """Names of the files that show the result."""
    undrawn: str | None = None
    """Why these could not be written, if so."""

    @property
    def final(self) -> bool:
        """True if the same clip, options and tool would give the same answer again.

        What hinders the work, a full disk for example, may be gone the next time.
        """
        final = FootageError | TrackingError | None
        whole = self.content is not None and self.undrawn is None
        return whole and isinstance(self.result.error, final)


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
    content, before = None, signature(job.file)
    try:
        if job.problem is not None:
            raise UsageError(job.problem)
        with suppress(OSError, UsageError):  # which counting explains better
            content = content_digest(job.file)
        with shortage_explained():
            found = job.found or pipeline.work_through(job.file, job.settings)
            try:
                evidence, undrawn = _drawn(job, found), None
            except (CountVideoError, OSError) as error:
                evidence, undrawn = (), reason_of(error, job.file)
        found = replace(found, result=replace(found.result, clip=job.clip))
        return Answer(Result(found, signature=before), content, tool_version(), evidence, undrawn)
    except (CountVideoError, OSError) as error:
        unread = TrialResult(job.clip, "not_counted", reason_of(error, job.file))
        return Answer(Result(Followed(unread), error, before), content, tool_version())


def _drawn(job: Job, found: Followed) -> tuple[str, ...]:
    """Draw the pages that the job wants; return the names of their files."""
    if job.pages is None:
        return ()
    from count_video.evidence import draw_evidence  # noqa: PLC0415 - matplotlib takes time

    folder = Path(job.start, job.pages.folder)
    found = replace(found, result=replace(found.result, clip=str(job.file)))
    return draw_evidence(found, replace(job.pages, folder=folder, name=job.name))


Done = Generator[tuple[Job, Future[Answer]], None, None]
"""Jobs with their futures, which are done."""


def jobs_done(jobs: Sequence[Job], processes: int | None, scheduler: str | None) -> Done:
    """Have clips counted, here or on the cluster of a scheduler, and yield each as it comes.

    UsageError if there is no such cluster.
    """
    if scheduler is None:
        return as_done(count_job, jobs, processes)
    return _on_cluster(jobs, _joined(scheduler))


def answer_of(job: Job, future: Future[Answer]) -> Answer:
    """Return what came of a job, or why that is not known for a reason other than its clip."""
    error = None if future.cancelled() else future.exception()
    if future.cancelled():
        reason = "the cluster let the clip go; check its scheduler and start again"
    elif error is None:
        answer, ours = future.result(), tool_version()
        if answer.tool == ours:
            return answer
        reason = f"the worker has count-video {answer.tool}, not {ours}; install the same"
    elif isinstance(error, BrokenExecutor):
        reason = "the worker died on this clip, twice; play the clip, or convert it"
    else:  # not the clip's error but the program's (or the cluster's): the others do not suffer
        words = " ".join(f"{type(error).__name__}: {error}".split())
        reason = f"the work on this clip failed ({words}); please report it"
    return Answer(refused(job.clip, CountVideoError(reason)), None, tool_version())


def _on_cluster(jobs: Iterable[Job], client: Any) -> Done:
    """Let a cluster count, whose scheduler hands a dead worker's jobs to others; it lives on."""
    done = False
    executor = client.get_executor(pure=False)
    try:
        running = {executor.submit(count_job, job): job for job in jobs}
        while running:
            arrived = wait(running, ASK_EVERY_S, FIRST_COMPLETED).done
            if not arrived and _is_lost(client):  # some of its futures then never end
                for future in running:
                    future.cancel()
                arrived = set(running)
            for future in arrived:
                yield running.pop(future), future
        done = True
    finally:
        if not _is_lost(client):
            executor.shutdown(wait=done)
        client.close()


def _is_lost(client: Any) -> bool:
    """Return whether the scheduler is gone."""
    return str(client.status) in ("closing", "closed")


def _joined(address: str) -> Any:
    """Join a cluster by Dask's client, made to say nothing of its own accord.

    UsageError if Dask is not installed, or no scheduler answers at the address.
    """
    try:
        import dask  # noqa: PLC0415 - an extra that few need

        # Dask reads this as it is imported. A lost worker is no news, its clips are done again; a
        # lost scheduler stands in the rows of the clips that it had.
        loggers = ("distributed", "distributed.client", "tornado.application", "asyncio")
        with dask.config.set({"logging": dict.fromkeys(loggers, "critical")}):
            import distributed  # noqa: PLC0415
    except ImportError as error:
        raise UsageError(
            "--scheduler needs Dask; install it with pip install '.[distributed]' in the folder of "
            "this project"
        ) from error
    # A client that never joined would wait for the cluster once more as it is thrown away; one that
    # did is closed by its owner.
    client = type("_Client", (distributed.Client,), {"__del__": lambda _: None})
    try:
        return client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError, ImportError) as error:
        # Each kind of address fails with an error of its own: one without certificates with a
        # TypeError, one that needs a missing library with an ImportError.
        raise UsageError(f"no Dask scheduler answers at {address}; start it first") from error

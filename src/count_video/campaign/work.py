"""The work on one trial, as it is done in a worker process on this machine or another."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import cv2

from count_video import trial
from count_video.campaign.fingerprint import tool_version
from count_video.campaign.one_by_one import refused
from count_video.campaign.plan import Job
from count_video.campaign.rows import read_result
from count_video.errors import CountVideoError, FootageError, TrackingError
from count_video.inputs import content_digest
from count_video.records import TrialResult
from count_video.reports.json_object import json_line
from count_video.verdict import unread_result


@dataclass(frozen=True)
class Answer:
    """What came of a job."""

    text: str
    """The result as one line of JSON, without the line's end."""
    content: str | None
    """Digest of the clip; None where it could not be read."""
    final: bool
    """True if the same clip, options and tool would give the same answer again."""
    tool: str
    """Version of the tool that did the work."""
    evidence: tuple[str, ...] = ()
    """Names of the files that show the result."""


def count_job(job: Job) -> Answer:
    """Count one clip; what is wrong with it becomes its answer, faults of the program are raised.

    Workers share the cores between them, so each does its own work in one thread.
    """
    cv2.setNumThreads(1)
    if job.problem is not None:
        return failure(job, job.problem)
    content = None
    evidence: tuple[str, ...] = ()
    try:
        content = content_digest(job.file)
        result, evidence = _counted(job)
        final = True
    except (CountVideoError, OSError) as error:
        result = refused(job.file, error).result
        # What hinders the work, a full disk for example, may be gone the next time.
        final = isinstance(error, FootageError | TrackingError)
    text = json_line(replace(result, clip=job.clip))
    read_result(text)  # else a fault of the program, which is not to be kept
    return Answer(text, content, final, tool_version(), evidence)


def _counted(job: Job) -> tuple[TrialResult, tuple[str, ...]]:
    if job.pages is None:
        return trial.count_clip(job.file, job.settings), ()
    # Drawing takes long to import, and most campaigns draw nothing.
    from count_video.evidence import EvidenceSettings, make_evidence  # noqa: PLC0415

    folder = Path(job.start, job.pages.folder)
    pages = job.pages
    wanted = EvidenceSettings(
        folder, pages.picture_format, name=job.name, csv_dialect=pages.csv_dialect
    )
    made = make_evidence(job.file, job.settings, wanted)
    return made.result, made.files


def failure(job: Job, reason: str) -> Answer:
    """Make the answer of a job that failed for a reason other than its clip."""
    return Answer(json_line(unread_result(job.clip, reason)), None, False, tool_version())

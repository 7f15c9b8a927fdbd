"""A whole campaign: what is known already, what is still to do, and the files that tell of both."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass

from count_video.campaign.crew import Crew
from count_video.campaign.dispatch import answers
from count_video.campaign.fingerprint import Signature, signature
from count_video.campaign.plan import Job
from count_video.campaign.rows import row_of
from count_video.campaign.store import ResultStore
from count_video.campaign.work import Answer
from count_video.errors import UsageError
from count_video.progress import NO_PROGRESS, Progress
from count_video.reports.campaign_json import campaign_json
from count_video.reports.campaign_rows import CampaignSummary, TrialRow
from count_video.reports.campaign_table import trials_csv

TABLE, SUMMARY = "trials.csv", "campaign.json"
TABLE_EVERY_S = 1.0
"""The table on the disk grows so often,"""
TABLE_SHARE = 0.05
"""and less often where writing it would take more than this share of the time."""


@dataclass(frozen=True)
class Told:
    """What a campaign tells of one trial."""

    row: TrialRow
    text: str
    """The result as one line of JSON."""


def run_campaign(
    jobs: Sequence[Job],
    start_crew: Callable[[], Crew],
    store: ResultStore | None,
    progress: Progress = NO_PROGRESS,
) -> Iterator[Told]:
    """Count all jobs and yield them in their own order, each when it and those before are there.

    Parameters
    ----------
    start_crew
        Makes the crew; not called where all is known already.
    store
        Where results are kept and looked for; None keeps nothing.
    """
    told = {} if store is None else _known(jobs, store)
    with closing(_arriving(jobs, told, start_crew, store, progress)) as arriving:
        for job in jobs:
            while job.name not in told:
                next(arriving)
            yield told[job.name]
        next(arriving, None)  # to its end: the crew has nothing more to do and goes home in peace


def write_tables(rows: Sequence[TrialRow], summary: CampaignSummary, store: ResultStore) -> None:
    """Write ``trials.csv`` and ``campaign.json``; raises as ``store.write`` does."""
    store.write(TABLE, trials_csv(rows))
    store.write(SUMMARY, campaign_json(rows, summary))


def _known(jobs: Sequence[Job], store: ResultStore) -> dict[str, Told]:
    known: dict[str, Told] = {}
    for job in jobs:
        text = store.known(job)
        if text is not None:
            known[job.name] = Told(row_of(job, text, None, store.evidence(job)), text)
    return known


def _arriving(
    jobs: Sequence[Job],
    told: dict[str, Told],
    start_crew: Callable[[], Crew],
    store: ResultStore | None,
    progress: Progress,
) -> Generator[None, None, None]:
    """Do what is not told yet; every step puts one more trial into ``told``."""
    rest = [job for job in jobs if job.name not in told]
    if not rest:
        return
    progress.start(len(rest), f"{len(told)} known already," if told else "")
    table = None if store is None else _GrowingTable(jobs, told, store)
    signatures = {job.name: _signature(job) for job in rest}
    try:
        for job, answer in answers(rest, start_crew()):
            not_kept, files = None, frozenset[str]()
            if store is not None:
                not_kept = _kept(job, answer, signatures[job.name], store)
                if answer.final and not_kept is None:  # else the record is an earlier result's
                    files = store.evidence(job)
            told[job.name] = Told(row_of(job, answer.text, not_kept, files), answer.text)
            progress.advance(1)
            if table is not None:
                table.grow()
            yield
    finally:
        progress.finish()


def _signature(job: Job) -> Signature:
    try:
        return signature(job.file)
    except OSError:
        return []  # like no file's: the worker will say what is wrong


def _kept(job: Job, answer: Answer, seen: Signature, store: ResultStore) -> str | None:
    """Keep an answer; return why that failed, None if it did not."""
    try:
        store.keep(job, answer, seen)
    except OSError as error:
        return f"the result could not be written ({error.strerror}); make room and start again"
    except UsageError as error:
        return f"the result could not be written ({error})"
    return None


class _GrowingTable:
    """The table on the disk, which grows while a campaign runs."""

    def __init__(self, jobs: Sequence[Job], told: Mapping[str, Told], store: ResultStore) -> None:
        self._jobs, self._told, self._store = jobs, told, store
        self._due_s = time.monotonic() + TABLE_EVERY_S

    def grow(self) -> None:
        """Write the table, unless it has just been written."""
        began_s = time.monotonic()
        if began_s < self._due_s:
            return
        rows = [self._told[job.name].row for job in self._jobs if job.name in self._told]
        with suppress(OSError, UsageError):  # told at the end, if it still fails then
            self._store.write(TABLE, trials_csv(rows))
        ended_s = time.monotonic()
        self._due_s = ended_s + max(TABLE_EVERY_S, (ended_s - began_s) / TABLE_SHARE)

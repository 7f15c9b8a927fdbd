"""The campaign part of the command: options in, the growing table and the summary out."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Collection, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from count_video.batch.executor import ClusterWorkers
from count_video.batch.manifest import is_manifest, jobs_of
from count_video.batch.results import ResultStore, open_store
from count_video.batch.summary import run_campaign, summarise
from count_video.errors import UsageError
from count_video.outputs import clear_unfinished
from count_video.parallel import Processes, Workers
from count_video.process import before_the_end
from count_video.progress import Progress
from count_video.reports.campaign import (
    TRIAL_HEADING,
    CampaignSummary,
    TrialRow,
    campaign_json,
    campaign_text,
    trial_line,
)
from count_video.reports.json_object import json_line
from count_video.reports.tables import trials_csv
from count_video.reports.words import WIDTH, plural
from count_video.settings import EvidenceSettings, TrialSettings

TABLE, SUMMARY = "trials.csv", "campaign.json"


def answer_campaign(
    options: argparse.Namespace,
    settings: TrialSettings,
    progress: Progress,
    show: Callable[[str], object],
    complain: Callable[[str], object],
    columns: int = WIDTH,
) -> tuple[bool, list[Path]]:
    """Run a campaign; return whether every trial is counted and kept, and the campaign's own files.

    Parameters
    ----------
    progress
        Informed of the trials that are done.
    show
        Writes what is meant for stdout, however many lines.
    complain
        Writes one line on stderr.
    columns
        At which sentences are wrapped.

    Raises
    ------
    UsageError
        The request is wrong, or another run is at work in the folder.
    OSError
        The tables cannot be written; the trials are done and printed by then.
    """
    pages = None
    if options.pages:
        pages = EvidenceSettings(options.output, options.picture_format, options.csv_dialect)
    jobs = jobs_of(options.clips, settings, pages)
    rows: list[TrialRow] = []
    own: tuple[str, ...] = ()
    with ExitStack() as stack:
        store = None
        if options.output is not None:
            own = ("campaign.html", TABLE, SUMMARY, f"campaign.{options.picture_format}")
            _refuse_to_overwrite_manifests(options, own)
            opened = open_store(options.output, own, options.csv_dialect, fresh=options.fresh)
            store = stack.enter_context(opened)
            if names := [job.name for job in jobs if store.shows_another_clip(job)]:
                results = f"{plural(len(names), 'result')} of other clips of the same names"
                complain(f"{store.folder}: replaces {results} ({names[0]} first)")
        if not options.json:
            show(TRIAL_HEADING)
        for row in run_campaign(jobs, _workers(options), store, progress):
            rows.append(row)
            show(json_line(row.result) if options.json else trial_line(row))
        summary = summarise(rows)
        if not options.json:
            show(f"\n{campaign_text(rows, summary, columns)}")
        if store is not None:
            _write(rows, summary, store, options.picture_format)
    done = all(row.count is not None and row.not_kept is None for row in rows)
    return done, [options.output / name for name in own]


def _refuse_to_overwrite_manifests(options: argparse.Namespace, own: Collection[str]) -> None:
    """Refuse to write over a manifest that is to be read again, even one that we wrote."""
    written = [os.path.realpath(options.output / name) for name in own]
    for path in options.clips:
        if is_manifest(path) and os.path.realpath(path) in written:
            raise UsageError(
                f"{path}: the results would overwrite this manifest; rename it, or give another "
                "folder with -o"
            )


def _write(
    rows: Sequence[TrialRow], summary: CampaignSummary, store: ResultStore, picture_format: str
) -> None:
    store.write(TABLE, trials_csv(rows))
    store.write(SUMMARY, campaign_json(rows, summary))
    from count_video.reports.figure import campaign_files  # noqa: PLC0415 - drawing takes time

    for name, content in campaign_files(rows, summary, picture_format).items():
        store.outputs.write(name, content)


def _workers(options: argparse.Namespace) -> Callable[[], Workers]:
    if options.scheduler is not None:
        return lambda: ClusterWorkers(options.scheduler)

    def start() -> Workers:
        workers = Processes(options.jobs)
        if options.output is not None:
            before_the_end(partial(clear_unfinished, options.output))
        before_the_end(workers.kill)  # the latest comes first
        return workers

    return start

"""The campaign part of the command: options in, the growing table and the summary out."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Collection, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext, suppress
from functools import partial
from pathlib import Path

from count_video.batch.executor import ClusterWorkers
from count_video.batch.manifest import Job, is_manifest, jobs_of
from count_video.batch.results import ResultStore, open_store
from count_video.batch.summary import (
    SUMMARY,
    TABLE,
    run_campaign,
    summarise,
    write_tables,
)
from count_video.errors import UsageError
from count_video.outputs import clear_unfinished
from count_video.parallel import Processes, Workers
from count_video.process import before_the_end
from count_video.progress import NO_PROGRESS, Progress, TerminalBar
from count_video.reports.campaign import TRIAL_HEADING, TrialRow, campaign_text, trial_line
from count_video.reports.words import WIDTH, printable
from count_video.settings import EvidenceSettings, TrialSettings

EXIT_COUNTED, EXIT_NOT_COUNTED = 0, 1


def answer_campaign(
    options: argparse.Namespace, settings: TrialSettings, columns: int = WIDTH
) -> tuple[int, list[Path]]:
    """Run a campaign; return the exit code and the campaign's own files, as far as it writes any.

    The code is 1 if a trial is not counted or not kept. Sentences are wrapped at so many
    ``columns``.

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
            store = stack.enter_context(open_store(options.output, own, fresh=options.fresh))
            store.outputs.csv_dialect = options.csv_dialect
            _say_what_is_replaced(jobs, store)
        progress, aside = _progress()
        if not options.json:
            print(TRIAL_HEADING, flush=True)
        for row in run_campaign(jobs, _workers(options), store, progress):
            rows.append(row)
            with aside():
                print(row.text if options.json else trial_line(row), flush=True)
        _conclude(rows, store, options, columns)
    done = all(row.count is not None and row.not_kept is None for row in rows)
    code = EXIT_COUNTED if done else EXIT_NOT_COUNTED
    return code, [options.output / name for name in own]


def _refuse_to_overwrite_manifests(options: argparse.Namespace, own: Collection[str]) -> None:
    """Refuse to write over a manifest that is to be read again, even one that we wrote."""
    for path in options.clips:
        written = [os.path.realpath(options.output / name) for name in own]
        if is_manifest(path) and os.path.realpath(path) in written:
            raise UsageError(
                f"{path}: the results would overwrite this manifest; rename it, or give another "
                "folder with -o"
            )


def _say_what_is_replaced(jobs: Sequence[Job], store: ResultStore) -> None:
    """Say on stderr whose results of an earlier campaign will be replaced."""
    names = [job.name for job in jobs if store.shows_another_clip(job)]
    if names and sys.stderr is not None:
        results = "1 result" if len(names) == 1 else f"{len(names)} results"
        line = f"replaces {results} of other clips of the same names ({printable(names[0])} first)"
        with suppress(OSError):
            print(f"count-video: {store.folder}: {line}", file=sys.stderr, flush=True)


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


def _conclude(
    rows: list[TrialRow], store: ResultStore | None, options: argparse.Namespace, columns: int
) -> None:
    summary = summarise(rows)
    if not options.json:
        print("", campaign_text(rows, summary, columns), sep="\n", flush=True)
    if store is not None:
        write_tables(rows, summary, store)
        from count_video.reports.figure import campaign_files

        for name, content in campaign_files(rows, summary, options.picture_format).items():
            store.outputs.write(name, content)


def _progress() -> tuple[Progress, Callable[[], AbstractContextManager[None]]]:
    """Return what shows the progress, and how to write beside it."""
    if sys.stderr is None or not sys.stderr.isatty():
        return NO_PROGRESS, nullcontext
    bar = TerminalBar(sys.stderr, "clips", per_minute=True)
    before_the_end(bar.finish)
    together = sys.stdout is not None and os.isatty(sys.stdout.fileno())
    return bar, bar.aside if together else nullcontext

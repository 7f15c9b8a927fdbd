"""The command ``count-video``: options in, one answer a clip out, by the functions of `api`.

Answers go to stdout and nothing else does; a clip without a count is one line on stderr.
What takes time to import is imported once the options are known to be sound, so that ``--help``
and a mistyped option answer at once.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from collections.abc import Sequence
from contextlib import ExitStack, nullcontext, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from count_video.errors import (
    CountVideoError,
    MachineError,
    OutputError,
    UsageError,
    reason_of,
)
from count_video.inputs import read_json_object
from count_video.options import complete_options, is_campaign, plan_values, read_options
from count_video.outputs import remedy
from count_video.process import (
    DRAWING_BYTES,
    LIBRARIES_BYTES,
    before_the_end,
    check_limits,
    check_memory,
    end_well_on_signals,
    give_stdout_up,
    keep_libraries_off_the_streams,
    shortage_explained,
    show_any_file_name,
    spare_the_processor,
)
from count_video.progress import NO_PROGRESS, Progress, TerminalBar, counted_off
from count_video.reports.words import labelled, plural, printable

if TYPE_CHECKING:
    from count_video.planning.request import PlanRequest
    from count_video.reports.campaign import TrialRow
    from count_video.result import Result

PROGRAM = "count-video"
NARROWEST, WIDEST = 40, 100
"""Columns within which sentences stay readable, on whatever terminal."""
EXIT_COUNTED = 0
EXIT_NOT_COUNTED = 1
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130  # what shells report for an end by Ctrl-C
EXIT_BROKEN_PIPE = 141  # and for an end because nobody reads on


def run() -> None:
    """Run the command and leave the interpreter with its exit code."""
    if "_ARGCOMPLETE" in os.environ:  # the shell asks what may follow
        complete_options()
    spare_the_processor()
    keep_libraries_off_the_streams()
    end_well_on_signals(_complain)
    sys.exit(main())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command on ``arguments`` (None: those of this process) and return its exit code."""
    show_any_file_name()
    try:
        with shortage_explained():
            try:
                code = _answer(read_options(arguments))
            except SystemExit as done:  # --help and --version
                code = int(done.code or EXIT_COUNTED)
        if sys.stdout is not None:  # it is None when the caller has closed it
            sys.stdout.flush()  # so that an error comes now and not as the interpreter leaves
    except (UsageError, MachineError, ImportError) as error:
        said = str(error)
        if isinstance(error, ImportError):  # of something else of a part's name, or of a library
            said = f"a part of this program cannot be loaded ({error}); install count-video again, "
            said += "in an environment of its own"
        _complain(said)
        return EXIT_NOT_COUNTED if isinstance(error, OutputError) else EXIT_USAGE
    except KeyboardInterrupt:
        _complain("interrupted")
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        give_stdout_up()
        return EXIT_BROKEN_PIPE
    except OSError as error:  # those of the clips have become answers
        give_stdout_up()
        _complain(f"cannot write what was asked for: {error.strerror or error}")
        return EXIT_NOT_COUNTED
    return code


def _answer(options: argparse.Namespace) -> int:
    check_limits()
    if options.output is not None:
        check_memory(LIBRARIES_BYTES + DRAWING_BYTES)
        _load_the_drawing()
    if options.theory is not None:
        return _answer_theory(options)
    if options.plan is not None:
        return _answer_plan(options)
    return _answer_campaign(options) if is_campaign(options) else _answer_clips(options)


def _answer_campaign(options: argparse.Namespace) -> int:
    """Print the row of each trial as it comes, and what they say together."""
    from count_video.batch.executor import jobs_done
    from count_video.batch.manifest import jobs_of
    from count_video.batch.results import OWN_FILES, open_store
    from count_video.batch.summary import run_campaign, summarise
    from count_video.outputs import clear_unfinished
    from count_video.parallel import end_processes
    from count_video.reports.campaign import campaign_text, name_columns, trial_heading, trial_line
    from count_video.reports.exports import json_line

    folder, kind, dialect = options.output, options.picture_format, options.csv_dialect
    pages = options.evidence if options.pages else None
    jobs = jobs_of(options.clips, options.settings, pages)
    if all(job.problem for job in jobs):  # no clip at all
        raise UsageError(f"{jobs[0].clip}: {jobs[0].problem}")
    progress, columns = _progress("clips"), name_columns(job.name for job in jobs)
    rows: list[TrialRow] = []
    with ExitStack() as stack:
        store = None
        if folder is not None:
            own = [name.format(kind) for name in OWN_FILES]
            _refuse_to_overwrite_manifests(options, own)
            store = stack.enter_context(open_store(folder, own, fresh=options.fresh))
            if names := [job.name for job in jobs if store.shows_another_clip(job)]:
                results = f"{plural(len(names), 'result')} of other clips of the same names"
                _complain(f"{folder}: replaces {results} ({names[0]} first)")
            before_the_end(partial(clear_unfinished, folder))
        before_the_end(end_processes)  # the latest comes first
        count = partial(jobs_done, processes=options.jobs, scheduler=options.scheduler)
        for row in run_campaign(jobs, count, store, progress):
            with progress.aside() if isinstance(progress, TerminalBar) else nullcontext():
                if not rows and not options.json:
                    print(trial_heading(columns))
                rows.append(row)
                line = json_line(row.result) if options.json else trial_line(row, columns)
                print(line, flush=True)
                if row.missing and (options.json or not _is_seen()):
                    _complain(f"{row.result.clip}: {row.missing}")
        summary = summarise(rows)
        if not options.json:
            print(f"\n{campaign_text(rows, summary, _columns())}", flush=True)
        if store is not None:
            missing = list(own)
            try:
                for name in store.write_campaign(rows, summary, kind, dialect):
                    missing.remove(name)
            except OSError as error:
                _complain(f"{folder}: {_not_written(missing, rows, error)}")
                return EXIT_NOT_COUNTED
            if not options.json:
                _say_what_is_kept([folder / name for name in own], ", and NAME.json for each trial")
    return EXIT_NOT_COUNTED if any(row.missing for row in rows) else EXIT_COUNTED


def _not_written(names: Sequence[str], rows: Sequence[TrialRow], error: OSError) -> str:
    """Say that some of a campaign's own files could not be written, and what to do."""
    text = f"{', '.join(names)} could not be written ({error.strerror}); "
    text += remedy(error, "give another folder with -o")
    kept = sum(row.not_kept is None for row in rows)
    which = f"{kept} of the {len(rows)} results {'is' if kept == 1 else 'are'}"
    which = "the results of the trials are" if kept == len(rows) else which
    return f"{text}: {which} kept" if kept else text


def _refuse_to_overwrite_manifests(options: argparse.Namespace, own: Sequence[str]) -> None:
    """Refuse to write over a manifest that is to be read again, even one that we wrote."""
    written = [os.path.realpath(options.output / name) for name in own]
    for path in options.clips:
        if path.suffix.lower() == ".csv" and os.path.realpath(path) in written:
            raise UsageError(
                f"{path}: the results would overwrite this manifest; rename it, or give another "
                "folder with -o"
            )


def _answer_clips(options: argparse.Namespace) -> int:
    """Answer clip by clip; the exit code is that of the worst."""
    plan = None
    if options.plan_file is not None:
        from count_video.planning.request import read_request

        plan = read_request(options.plan_file)  # before a long count
    if options.corrections is not None:
        read_json_object(options.corrections)  # likewise
    code, gap = EXIT_COUNTED, ""
    progress = _progress()
    for path in options.clips:
        result, kept, said = _count(path, options, plan, progress)
        if _show(result, gap, kept, as_json=options.json):
            gap = "\n"
        if result.count is None:
            wrong = isinstance(result.error, UsageError)
            code = max(code, EXIT_USAGE if wrong else EXIT_NOT_COUNTED)
        if said:
            _complain(f"{result.clip}: {said}")
        if options.output is not None and not kept:
            code = max(code, EXIT_NOT_COUNTED)
    return code


def _count(
    path: Path, options: argparse.Namespace, plan: PlanRequest | None, progress: Progress
) -> tuple[Result, list[Path], str]:
    """Count a clip, lay over it what was asked for, and write the files that show it.

    Returns the result, these files, and what is to be said of them: why they could not be written,
    when the count stands, or that they replaced those of another clip.
    """
    from count_video.api import count_with
    from count_video.result import refused

    files = None
    try:
        if options.output is not None:
            from count_video.evidence import open_files

            files = open_files(path, options.evidence, "json")  # refused before a long count
        result = count_with(path, options.settings, progress)
        if options.corrections is not None:
            result = result.reviewed(options.corrections)
        if plan is not None:
            result = result.compared(plan)
    except (CountVideoError, OSError) as error:
        return refused(path, error), [], ""
    if files is None:
        return result, [], ""
    try:
        replaces = files.outputs.shows_another_clip(f"{files.name}.html", path)
        kept = result.write(options.evidence, progress)
    except (CountVideoError, OSError) as error:
        return result, [], reason_of(error, path)
    return result, kept, "replaced the evidence of another clip of this name" if replaces else ""


def _show(result: Result, gap: str, kept: Sequence[Path], *, as_json: bool) -> bool:
    """Show a result, as text below what came before it; true if such text was printed."""
    # Of what could not be read as footage there is nothing to say but why, on stderr.
    shown = result.error is None
    if as_json:
        from count_video.reports.exports import json_line

        print(json_line(result.answer), flush=True)
    elif shown:
        print(gap, result.text(_columns()), sep="", flush=True)
    as_text = shown and not as_json
    # The text has the reason in it: on a terminal that is enough, from a file nobody sees it now.
    if result.count is None and not (as_text and _is_seen()):
        said = filter(None, (result.answer.reason or "not counted", result.what_to_do))
        _complain(f"{result.clip}: {'; '.join(said)}")
    if not as_json:
        _say_what_is_kept(kept)
    return as_text


def _is_seen() -> bool:
    """Whether what is printed is seen now."""
    return sys.stdout is not None and sys.stdout.isatty()


def _load_the_drawing() -> None:
    """Load matplotlib, with its remarks (on its font cache, or on settings) kept off stderr."""
    import logging

    logging.getLogger("matplotlib").setLevel(logging.CRITICAL)
    try:
        import matplotlib as _  # noqa: F401 - reads a file of settings, also from this folder
    except (OSError, ValueError) as error:
        raise UsageError(
            f"the settings of matplotlib cannot be read ({error}); move its file matplotlibrc "
            "away, which is in this folder or among your settings"
        ) from error


def _answer_theory(options: argparse.Namespace) -> int:
    from count_video.reports.plan_text import theory_text

    print(theory_text(*options.theory))
    heavy, light = options.theory
    if heavy < light:
        _complain("the first mass is the smaller one; that of the cylinder comes first")
    if options.output is not None:
        from count_video.outputs import open_outputs
        from count_video.reports.drawing import picture_bytes
        from count_video.reports.figure import theory_figure

        name = f"theory.{options.picture_format}"
        picture = picture_bytes(theory_figure(heavy, light), options.picture_format)
        open_outputs(options.output).write_all([(name, picture)])
        _say_what_is_kept([options.output / name])
    return EXIT_COUNTED


def _answer_plan(options: argparse.Namespace) -> int:
    from count_video.planning.plan import make_plan
    from count_video.planning.request import PlanRequest, Tolerances

    tolerances = Tolerances(**dict(options.tolerance or ()))
    request = PlanRequest(**plan_values(options), tolerances=tolerances)
    kept = options.output is not None
    if kept:
        from count_video.outputs import open_outputs
        from count_video.reports.plan_picture import NAMES, plan_files

        outputs = open_outputs(options.output, NAMES)
    wanted = kept or options.trials is not None
    progress = _progress("steps")
    plan = make_plan(request, with_table=wanted, with_chart=kept, progress=progress)
    if kept:
        progress.start(len(NAMES), "drawing")
        outputs.write_all(counted_off(plan_files(plan, options.csv_dialect), progress))
        progress.finish()
    if options.json:
        import json

        from count_video.reports.exports import plan_object

        print(json.dumps(plan_object(plan), allow_nan=False))
    else:
        from count_video.reports.plan_text import plan_text

        print(plan_text(plan, _columns()))
        if kept:
            _say_what_is_kept([options.output / name for name in NAMES])
    return EXIT_COUNTED


def _progress(unit: str = "frames") -> Progress:
    if sys.stderr is None or not sys.stderr.isatty():
        return NO_PROGRESS
    bar = TerminalBar(sys.stderr, unit)
    before_the_end(bar.finish)
    return bar


def _say_what_is_kept(files: Sequence[Path], more: str = "") -> None:
    """Name the files that were written, the page to open first; ``more`` ends the sentence."""
    if not files:
        return
    first = next((file for file in files if file.suffix == ".html"), files[0])
    others = ", ".join(printable(file.name) for file in files if file != first)
    words = printable(str(first)) + (" (open it in a browser)" if first.suffix == ".html" else "")
    words += f", and beside it {others}{more}" if others else ""
    print("", *labelled("Written", words, _columns()), sep="\n", flush=True)


def _columns() -> int:
    """Columns for sentences: those that COLUMNS names, else the terminal's, else 80."""
    return min(max(shutil.get_terminal_size().columns, NARROWEST), WIDEST)


def _complain(message: str) -> None:
    """Write one line on stderr, whatever the message is made of."""
    if sys.stderr is None:  # closed by the caller; print would take stdout instead
        return
    with suppress(OSError):  # nobody there to read it
        print(f"{PROGRAM}: {printable(message)}", file=sys.stderr, flush=True)

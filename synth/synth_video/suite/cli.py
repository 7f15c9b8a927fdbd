"""The commands ``synth-video suite`` and ``synth-video score``."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from count_video.errors import UsageError
from synth_video.suite.condition import STRENGTHS
from synth_video.suite.filming import film, takes_of
from synth_video.suite.score_files import RESULTS, how_to_count, score_folder
from synth_video.suite.suites import SUITES, conditions_of
from synth_video.suite.table import markdown, scores_json, shortfalls


def suite(argv: Sequence[str]) -> None:
    """Render the clips of a suite.

    Raises
    ------
    UsageError
        The request is wrong or a clip cannot be written.
    SystemExit
        After ``--help``, or when the arguments make no sense.
    """
    # The folder may stand after options, which the plain parsing of optional arguments forbids.
    options = _suite_parser().parse_intermixed_args(argv)
    wanted = [name for name in options.conditions.split(",") if name]
    conditions = conditions_of(options.name, wanted)
    if options.folder is None:
        width = max(len(condition.name) for condition in conditions)
        for condition in conditions:
            sys.stdout.write(f"{condition.name:<{width}}  {condition.sentence}\n")
        return
    strengths = [options.strength] if options.strength else STRENGTHS
    takes = takes_of(conditions, strengths, range(options.seeds))
    for take, rendered in film(takes, options.folder, options.workers):
        if rendered:
            sys.stdout.write(f"{take.name}\n")
            sys.stdout.flush()
    sys.stdout.write(f"{len(takes)} clips in {options.folder}; {how_to_count(options.folder)}\n")


def score(argv: Sequence[str]) -> None:
    """Score the answers on a folder of clips; print the table and keep it in the folder.

    Raises
    ------
    UsageError
        Truths or answers are missing, or the table cannot be written.
    SystemExit
        After ``--help``, or when the arguments make no sense.
    """
    options = _score_parser().parse_args(argv)
    scores = score_folder(options.folder, options.results or options.folder / RESULTS)
    table = markdown(scores)
    _write(options.folder / "scores.md", f"{table}\n{shortfalls(scores)}")
    _write(options.folder / "scores.json", scores_json(scores))
    sys.stdout.write(f"{table}\n{shortfalls(scores)}")


def _suite_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="synth-video suite",
        description="Render trials under conditions that make footage hard to count. Clips that "
        "are there already are kept.",
    )
    parser.add_argument("name", help=f"which suite: {', '.join(SUITES)}")
    parser.add_argument(
        "folder", nargs="?", type=Path, help="folder to write to; without it the conditions' names"
    )
    parser.add_argument(
        "--conditions", default="", metavar="NAME,NAME", help="only these conditions (all)"
    )
    parser.add_argument("--strength", choices=STRENGTHS, help="only this strength (both)")
    parser.add_argument("--seeds", type=_from_one, default=10, help="clips of each cell (10)")
    parser.add_argument(
        "--workers", type=_from_one, default=os.cpu_count() or 1, help="clips to render at a time"
    )
    return parser


def _score_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="synth-video score",
        description="Compare what count-video --json said of the clips in a folder with their "
        "truths. The table is printed, and kept as scores.md and scores.json in the folder.",
    )
    parser.add_argument("folder", type=Path, help="folder with clips and truths")
    parser.add_argument(
        "results", nargs="?", type=Path, help=f"what count-video printed ({RESULTS} in the folder)"
    )
    return parser


def _from_one(text: str) -> int:
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number from 1")
    return int(text)


def _write(place: Path, text: str) -> None:
    try:
        place.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"cannot write {place}: {error.strerror}; check the folder") from error

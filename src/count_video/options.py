"""The options of ``count-video``: what they are called, what they take, what they say for help.

The defaults of a plan are those of ``planning.PlanRequest``: what is not given stays None here, so
that ``--help`` and a mistyped option answer at once.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import fields
from itertools import takewhile
from typing import Any, NoReturn

from count_video import __version__, inputs
from count_video.errors import UsageError
from count_video.inputs import shown
from count_video.outputs import without_own
from count_video.settings import READERS, EvidenceSettings, TrialSettings

DESCRIPTION = """\
Count the collisions in slow-motion footage of the "pi by collisions"
experiment: a light ball hangs between a heavy cylinder and a wall, the cylinder
swings in, and they collide again and again until the cylinder turns back.
At a mass ratio of 100 the count is 31."""

EPILOG = """\
examples:
  count-video trial.mp4
  count-video trial.mp4 --capture-fps 960 --masses 1050 10.5
  count-video --json clips/ > counts.jsonl
  count-video trial.mp4 -o evidence/
  count-video trial.mp4 --corrections trial.corrections.json
  count-video trials/ -o results/
  count-video --theory 1050 10.5
  count-video --plan 1050 10.5 --gap 0.03 --release 0.09 --capture-fps 240
  count-video trial.mp4 --plan-file plans/plan.json

exit code:
  0 every clip was counted, 1 a clip was not counted, 2 the request was wrong,
  130 interrupted, 143 and 129 ended by SIGTERM and SIGHUP"""

_OF_A_PLAN = ("gap", "release", "thread", "restitution", "damping", "trials", "tolerance", "seed")
_OF_A_COUNT = (
    *("clips", "start", "end", "region", "wall", "masses", "seen_only", "corrections"),
    *("theory", "plan_file", "jobs", "fresh", "pages", "scheduler", "presenter"),
)
"""Options that go with a plan alone, and those that do not go with one."""
_NOT_OF_A_PLAN = (*_OF_A_COUNT, "picture_format")
"""A plan has its picture in both formats."""
_NOT_OF_A_THEORY = (*_OF_A_PLAN, *_OF_A_COUNT, "plan", "json", "capture_fps", "ball_diameter_mm")
"""What the exact count of two masses needs not."""
_FIELDS = {"gap": "gap_m", "release": "release_m", "damping": "damping_per_s"}
"""Fields of a ``PlanRequest`` that are not called as the options are."""


def _value(metavar: str, read: Callable[[str], object], **more: Any) -> dict[str, Any]:
    """Return what argparse needs for an option whose values ``read`` checks."""
    return {"metavar": metavar, "type": read, **more}


_TWO_MASSES = {"metavar": ("HEAVY", "LIGHT"), "nargs": 2, "type": inputs.MASS.exact}


_HELP: dict[tuple[str, str | None] | None, dict[str, str]] = {
    None: {
        "clips": "a video file, or a folder: then every video file in it, in natural order; or a "
        "manifest (.csv): then a clip a line, with options of its own (a folder's own "
        "manifest.csv is read)",
        "--version": "print the version and leave",
        "--json": "print one JSON object a clip, each on a line, instead of text (default: text)",
        "-o": "folder to keep results in, made if needed: for a clip its page, picture, annotated "
        "clip and tables (default: nothing is kept)",
        "--format": "kind of the pictures in the output folder (default: png)",
        "--csv-dialect": "how tables in the output folder are written: comma, with decimal "
        "points, or semicolon, with decimal commas (default: comma)",
        "--presenter": "with -o write a clip for a talk as well, in full HD with a big counter, "
        "and a GIF of it (default: none)",
        "--corrections": "a person's corrections, saved from the clip's page: the reviewed count "
        "is printed beside the tool's own (default: none)",
        "--theory": "print the exact count for two masses, with angles and bounds on pi, instead "
        "of counting a clip; with -o draw the phase circle (default: count)",
        "--plan-file": "the plan.json of the set-up that was planned: what was set up otherwise "
        "is printed beside the count (default: none)",
    },
    ("before filming", "what a set-up will count; lengths in metres, masses in any one unit"): {
        "--plan": "say what a set-up with these masses will count and what a camera of "
        "--capture-fps sees of it; with -o draw the map and write the page (default: count)",
        "--gap": "from the wall to the ball's side that faces it, where it hangs (default: 0.03)",
        "--release": "from where the cylinder hangs, its face touching the hanging ball, to where "
        "it is let go (default: 0.09)",
        "--thread": "length of the threads, or first the cylinder's and then the ball's (default: "
        "1)",
        "--restitution": "relative speed after over before a collision, 0 to 1 (default: 1)",
        "--damping": "rate a second at which a free swing decays (default: 0)",
        "--trials": "add a table of so many simulated trials (default: none, or 30 with -o)",
        "--tolerance": "how trials scatter that are meant to be alike: gap, release and thread in "
        "metres, mass as a share, restitution as the width of its range, scatter from collision "
        "to collision; may be repeated (default: gap=0.001 release=0.002 thread=0.001 mass=0.005 "
        "restitution=0.05 scatter=0.005)",
        "--seed": "of all that is drawn (default: 0)",
    },
    ("the footage", None): {
        "--capture-fps": "rate at which the camera took the pictures, in frames per second "
        "(default: what the clip's metadata say; without either there are frames but no seconds)",
        "--start": "first frame to use, counted from 0 (default: 0)",
        "--end": "frame to stop before, counted from 0 (default: the end of the clip)",
        "--region": "part of the picture to use, in pixels: left edge, top edge, width, height "
        "(default: the whole picture)",
    },
    ("the apparatus", None): {
        "--wall": "side of the picture on which the wall stands; left means top where the bodies "
        "move up and down (default: found from the motion)",
        "--ball-diameter-mm": "diameter of the ball in millimetres, for the scale (default: 40)",
        "--masses": "the two masses in any one unit, taken at their exact decimal value, for the "
        "bounds on pi, and to narrow the count down where collisions lie between the frames "
        "(default: measured from the motion, where that is sharp enough)",
        "--seen-only": "count only what the frames show and infer nothing between them (default: "
        "where frames leave doubts, a model of the motion is fitted)",
    },
    ("a campaign of many clips", None): {
        "--jobs": "clips to count at the same time (default: one for every core; of several clips "
        "without a folder one after the other)",
        "--fresh": "count every clip again (default: a result kept in the output folder is used "
        "again while the clip, the options and the tool are the same)",
        "--pages": "write each clip's page, picture, annotated clip and tables into the output "
        "folder as well, and link them to the campaign's page (default: the campaign's own page "
        "and tables)",
        "--scheduler": "let a Dask cluster count the clips, e.g. tcp://host:8786; its workers "
        "need count-video and the clips under the same paths (default: this machine)",
    },
}
"""What each option is for, by the groups in which help lists them."""
_TAKES: dict[str, dict[str, Any]] = {
    "clips": _value("CLIP", inputs.some_path, nargs="*"),
    "--version": {"action": "version", "version": f"count-video {__version__}"},
    "--json": {"action": "store_true"},
    "-o": _value("DIR", inputs.some_path),
    "--format": {"dest": "picture_format", "choices": ("png", "svg"), "default": "png"},
    "--csv-dialect": {"choices": ("comma", "semicolon"), "default": "comma"},
    "--presenter": {"choices": ("wide", "upright")},
    "--corrections": _value("FILE", inputs.some_path),
    "--theory": _TWO_MASSES,
    "--plan-file": _value("FILE", inputs.some_path),
    "--plan": _TWO_MASSES,
    "--gap": _value("M", inputs.LENGTH),
    "--release": _value("M", inputs.LENGTH),
    "--thread": _value("M", inputs.LENGTH, nargs="+"),
    "--restitution": _value("E", inputs.SHARE),
    "--damping": _value("RATE", inputs.DAMPING),
    "--trials": _value("N", inputs.TRIALS),
    "--tolerance": _value("NAME=VALUE", inputs.tolerance, action="append"),
    "--seed": _value("N", inputs.SEED),
    "--capture-fps": _value("RATE", READERS["capture_fps"]),
    "--start": _value("FRAME", READERS["start"], default=0),
    "--end": _value("FRAME", READERS["end"]),
    "--region": _value("X,Y,W,H", READERS["region"]),
    "--wall": {"choices": ("left", "right")},
    "--ball-diameter-mm": _value("MM", READERS["ball_diameter_mm"], default=40.0),
    "--masses": _TWO_MASSES,
    "--seen-only": {"action": "store_true"},
    "--jobs": _value("N", inputs.CLIPS_AT_A_TIME),
    "--fresh": {"action": "store_true"},
    "--pages": {"action": "store_true"},
    "--scheduler": _value("ADDRESS", inputs.address),
}
"""What each takes; where that is not said it is None unless given."""


class _Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line, by raising it."""

    def __init__(self, **more: Any) -> None:
        super().__init__(**more)
        # What begins so is a value, which says itself what is wrong with it, and no option.
        self._negative_number_matcher = re.compile(r"-\d")

    def error(self, message: str) -> NoReturn:
        # What begins with a quotation mark was cut already.
        short = re.sub(r"(?<!\S)[^\s'\"]\S{80,}", lambda long: shown(long[0]), message)
        raise UsageError(f"{short if len(short) < 400 else shown(short)} (see {self.prog} --help)")


def read_options(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line (None: the one of this process) and check each value.

    The namespace has an attribute for each option, ``settings`` for the clips and, with a folder
    to write to, ``evidence``. Raises UsageError, or SystemExit with code 0 after ``--help`` or
    ``--version``.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    for argument in takewhile(lambda argument: argument != "--", arguments):
        # argparse takes these two dashes for the end of the options and passes on an empty list.
        if re.fullmatch(r"(--[a-z-]+=|-o)--", argument):
            raise UsageError(f"{argument}: two dashes are no value (see count-video --help)")
        # argparse would take it for an option, and -old.mp4 for a folder called ld.mp4.
        if argument.startswith("-") and len(argument) > 2 and os.path.lexists(argument):
            raise UsageError(f"{shown(argument)}: put ./ before a name that begins with a dash")
    parser = _parser()
    # Clips may stand on both sides of an option, but the parser that allows it knows no "--".
    parse = parser.parse_args if "--" in arguments else parser.parse_intermixed_args
    options = parse(arguments)
    options.clips = without_own(options.clips)
    for why in _refusals(options, parser):
        raise UsageError(why)
    options.masses = options.masses and inputs.masses(*options.masses)
    said = {one.name: getattr(options, one.name) for one in fields(TrialSettings)}
    options.settings = TrialSettings(**said)
    if options.output is not None:
        formats = (options.picture_format, options.csv_dialect, options.presenter)
        options.evidence = EvidenceSettings(options.output, *formats)
    return options


def _refusals(options: argparse.Namespace, parser: argparse.ArgumentParser) -> Iterator[str]:
    """Yield what is wrong with the options together, or does not go with what is asked for."""
    purpose = next((name for name in ("theory", "plan") if getattr(options, name)), None)

    def given(*names: str) -> list[str]:
        """Return what a person calls those of the options that were given."""
        others = {"clips": "a clip", "picture_format": "--format"}
        return [
            others.get(name, f"--{name.replace('_', '-')}")
            for name in names
            if name != purpose and getattr(options, name) not in (parser.get_default(name), [])
        ]

    alien = {"theory": _NOT_OF_A_THEORY, "plan": _NOT_OF_A_PLAN, None: _OF_A_PLAN}
    for option in given(*alien[purpose]):
        without = f"--{purpose} goes without {option}"
        yield without if purpose else f"{option} goes with --plan alone"
    if options.thread is not None and len(options.thread) > 2:
        yield "--thread takes one length, or the cylinder's and the ball's"
    if options.output is None:
        for option in given("picture_format", "csv_dialect", "fresh", "pages"):
            yield f"{option} needs a folder to write to: give one with -o"
    if purpose is not None:
        return
    clips, campaign = options.clips, is_campaign(options)
    if not clips:
        yield "no clip: give a video file or a folder (see count-video --help)"
    if options.presenter and (options.output is None or campaign):
        yield "--presenter goes with one clip, and with a folder to write to (-o DIR)"
    if options.plan_file and campaign:
        yield "--plan-file goes with clips, not with a campaign: give single clips"
    if options.corrections and (campaign or len(clips) > 1):
        yield "--corrections are those of one clip: give that clip alone"


def complete_options() -> None:
    """Answer the shell that asks how a line may go on, and leave, if argcomplete is there."""
    with suppress(ImportError):
        import argcomplete  # noqa: PLC0415 - comes with the extra ``completion``

        argcomplete.autocomplete(_parser())


def is_campaign(options: argparse.Namespace) -> bool:
    """Return whether clips make a campaign, which is summed up, or each is answered by itself."""
    manifest = any(path.suffix.lower() == ".csv" for path in options.clips)
    folder = any(os.path.isdir(path) for path in options.clips)
    together = options.output is not None or options.jobs is not None
    several = together and len(options.clips) > 1
    return manifest or folder or several or options.scheduler is not None


def plan_values(options: argparse.Namespace) -> dict[str, Any]:
    """Collect what was given, by the names of the fields of ``PlanRequest``."""
    given = dict(zip(("heavy", "light"), options.plan, strict=True))
    for name in ("gap", "release", "restitution", "damping", "trials", "seed", "capture_fps"):
        given[_FIELDS.get(name, name)] = getattr(options, name)
    threads = options.thread or [None]
    given |= {"heavy_thread_m": threads[0], "light_thread_m": threads[-1]}
    given["ball_diameter_m"] = options.ball_diameter_mm / 1000.0
    return {name: value for name, value in given.items() if value is not None}


def _parser() -> _Parser:
    parser = _Parser(
        prog="count-video",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,  # an abbreviation in a script breaks when an option is added
    )
    for title, options in _HELP.items():
        group = parser if title is None else parser.add_argument_group(*title)
        for name, text in options.items():
            names = ("-o", "--output") if name == "-o" else (name,)
            group.add_argument(*names, help=text, **_TAKES[name])
    return parser

"""The options of ``count-video``: what they are called, what they take, what they say for help."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from itertools import takewhile
from typing import NoReturn

from count_video import __version__, inputs
from count_video.errors import UsageError
from count_video.inputs import as_option, shown
from count_video.plan_options import add_plan_options, check_plan_options

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


class _Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line, by raising it."""

    def error(self, message: str) -> NoReturn:
        dashed = re.fullmatch("unrecognized arguments: (-.*)", message, re.DOTALL)
        if dashed and os.path.exists(dashed[1]):
            message = f"{shown(dashed[1])}: put -- before a file whose name begins with a dash"
        # What begins with a quotation mark was cut already.
        short = re.sub(r"(?<!\S)[^\s'\"]\S{80,}", lambda long: shown(long[0]), message)
        raise UsageError(f"{short if len(short) < 400 else shown(short)} (see {self.prog} --help)")


def read_options(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line (None: the one of this process) and check each value.

    The namespace has ``clips``, ``json`` and one attribute for every field of ``TrialSettings``.

    Raises
    ------
    UsageError
        An option, a value or a combination is wrong; the message is one line.
    SystemExit
        With code 0 after ``--help`` or ``--version``.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    for argument in takewhile(lambda argument: argument != "--", arguments):
        # argparse takes these two dashes for the end of the options and passes on an empty list.
        if re.fullmatch(r"(--[a-z-]+=|-o)--", argument):
            raise UsageError(f"{argument}: two dashes are no value (see count-video --help)")
    parser = _parser()
    options = parser.parse_args(arguments)
    check_plan_options(options, parser)
    if options.end is not None and options.start >= options.end:
        raise UsageError(
            f"--start {options.start} leaves no frame before --end {options.end}: "
            "give a start below the end"
        )
    if options.masses is not None:
        inputs.masses(*options.masses)
    _check_what_is_wanted(options)
    return options


def _check_what_is_wanted(options: argparse.Namespace) -> None:
    if options.plan is not None:
        return
    if options.theory is None and not options.clips:
        raise UsageError("no clip: give a video file or a folder (see count-video --help)")
    if options.theory is not None and options.clips:
        raise UsageError("--theory needs no clip: ask for the one or count the other")
    beside = (options.corrections, options.plan_file)
    if options.theory is not None and (options.json or beside != (None, None)):
        raise UsageError("--theory goes with -o and --format alone")
    if options.presenter is not None and (options.output is None or is_campaign(options)):
        raise UsageError("--presenter goes with one clip and a folder to write to: add -o DIR")
    if options.pages and options.output is None:
        raise UsageError("--pages need a folder to go to: give one with -o")
    if options.plan_file is not None and is_campaign(options):
        raise UsageError("--plan-file goes with clips, not with a campaign: give single clips")
    one_file = len(options.clips) == 1 and not os.path.isdir(options.clips[0])
    if options.corrections is not None and not one_file:
        raise UsageError("--corrections are those of one clip: give that clip alone")


def complete_options() -> None:
    """Answer the shell that asks how a line may go on, and leave; without argcomplete, do nothing.

    The package ``argcomplete`` comes with the extra ``completion``.
    """
    with suppress(ImportError):
        import argcomplete  # noqa: PLC0415 - an extra that is asked for by the shell alone

        argcomplete.autocomplete(_parser())


def is_campaign(options: argparse.Namespace) -> bool:
    """Return whether clips make a campaign, which is summed up, or each is answered by itself."""
    manifest = any(path.suffix.lower() == ".csv" for path in options.clips)
    folder = any(os.path.isdir(path) for path in options.clips)
    kept = options.output is not None and len(options.clips) > 1
    return manifest or folder or kept or options.scheduler is not None


def _parser() -> _Parser:
    parser = _Parser(
        prog="count-video",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,  # an abbreviation in a script breaks when an option is added
    )
    parser.add_argument(
        "clips",
        metavar="CLIP",
        nargs="*",
        type=as_option(inputs.some_path),
        help="a video file, or a folder: then every video file in it, in natural order; or a "
        "manifest (.csv): then a clip a line, with options of its own (a folder's own manifest.csv "
        "is read)",
    )
    _add_answer_options(parser)
    _add_other_answers(parser)
    add_plan_options(parser)
    _add_footage_options(parser.add_argument_group("the footage"))
    _add_apparatus_options(parser.add_argument_group("the apparatus"))
    _add_campaign_options(parser.add_argument_group("a campaign of many clips"))
    return parser


def _add_answer_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--version",
        action="version",
        version=f"count-video {__version__}",
        help="print the version and leave",
    )
    parser.add_argument(
        "--json",
        action="store_true",
        help="print one JSON object a clip, each on a line, instead of text (default: text)",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        type=as_option(inputs.some_path),
        help="folder to keep results in, made if needed: for a clip its page, picture, annotated "
        "clip and tables (default: nothing is kept)",
    )
    parser.add_argument(
        "--format",
        dest="picture_format",
        choices=("png", "svg"),
        default="png",
        help="kind of the pictures in the output folder (default: png)",
    )
    parser.add_argument(
        "--csv-dialect",
        choices=("comma", "semicolon"),
        default="comma",
        help="how tables in the output folder are written: comma, with decimal points, or "
        "semicolon, with decimal commas (default: comma)",
    )
    parser.add_argument(
        "--presenter",
        choices=("wide", "upright"),
        help="with -o write a clip for a talk as well, in full HD with a big counter, and a GIF of "
        "it (default: none)",
    )


def _add_other_answers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--corrections",
        metavar="FILE",
        type=as_option(inputs.some_path),
        help="a person's corrections, saved from the clip's page: the reviewed count is printed "
        "beside the tool's own (default: none)",
    )
    parser.add_argument(
        "--theory",
        metavar=("HEAVY", "LIGHT"),
        nargs=2,
        type=as_option(inputs.mass),
        help="print the exact count for two masses, with angles and bounds on pi, instead of "
        "counting a clip; with -o draw the phase circle (default: count)",
    )
    parser.add_argument(
        "--plan-file",
        metavar="FILE",
        type=as_option(inputs.some_path),
        help="the plan.json of the set-up that was planned: what was set up otherwise is printed "
        "beside the count (default: none)",
    )


def _add_footage_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--capture-fps",
        metavar="RATE",
        type=as_option(inputs.capture_rate),
        help="rate at which the camera took the pictures, in frames per second "
        "(default: what the clip's metadata say; without either there are frames but no seconds)",
    )
    group.add_argument(
        "--start",
        metavar="FRAME",
        type=as_option(inputs.frame),
        default=0,
        help="first frame to use, counted from 0 (default: 0)",
    )
    group.add_argument(
        "--end",
        metavar="FRAME",
        type=as_option(inputs.frame),
        help="frame to stop before, counted from 0 (default: the end of the clip)",
    )
    group.add_argument(
        "--region",
        metavar="X,Y,W,H",
        type=as_option(inputs.region),
        help="part of the picture to use, in pixels: left edge, top edge, width, height "
        "(default: the whole picture)",
    )


def _add_apparatus_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--wall",
        dest="wall_side",
        choices=("left", "right"),
        help="side of the picture on which the wall stands; left means top where the bodies "
        "move up and down (default: found from the motion)",
    )
    group.add_argument(
        "--ball-diameter-mm",
        metavar="MM",
        type=as_option(inputs.ball_diameter),
        default=40.0,
        help="diameter of the ball in millimetres, for the scale (default: 40)",
    )
    group.add_argument(
        "--masses",
        metavar=("HEAVY", "LIGHT"),
        nargs=2,
        type=as_option(inputs.mass),
        help="the two masses in any one unit, taken at their exact decimal value, "
        "for the bounds on pi (default: measured from the motion, where that is sharp enough)",
    )
    group.add_argument(
        "--seen-only",
        action="store_true",
        help="count only what the frames show and infer nothing between them (default: where "
        "frames leave doubts, a model of the motion is fitted)",
    )


def _add_campaign_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--jobs",
        metavar="N",
        type=as_option(inputs.clips_at_a_time),
        help="clips to count at the same time (default: one for every core)",
    )
    group.add_argument(
        "--fresh",
        action="store_true",
        help="count every clip again (default: a result kept in the output folder is used again "
        "while the clip, the options and the tool are the same)",
    )
    group.add_argument(
        "--pages",
        action="store_true",
        help="write each clip's page, picture, annotated clip and tables into the output folder as "
        "well, and link them to the campaign's page (default: the campaign's own page and tables)",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        type=as_option(inputs.address),
        help="let a Dask cluster count the clips, e.g. tcp://host:8786; its workers need "
        "count-video and the clips under the same paths (default: this machine)",
    )

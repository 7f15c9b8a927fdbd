"""The command ``synth-video``: a scene and a seed in, a clip and its truth out.

``campaign`` renders many trials with known truth, ``suite`` clips under named conditions, and
``score`` compares what was counted on them with their truths.
"""

from __future__ import annotations

import argparse
import os
import sys
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import fmean, pstdev
from typing import NoReturn

from count_video.errors import CountVideoError, UsageError
from count_video.process import give_stdout_up
from synth_video import campaign as campaigns
from synth_video.film import render_clip
from synth_video.scene_file import load_scene, scene_names
from synth_video.suite import suites
from synth_video.suite.condition import STRENGTHS
from synth_video.suite.scoring import RESULTS, how_to_count, score_folder
from synth_video.suite.table import markdown, scores_json, shortfalls
from synth_video.truth import ClipTruth, check_place, truth_path
from synth_video.variation import varied

WIDTH = 80
"""Columns that a terminal has at the least."""
EXIT_DONE, EXIT_USAGE, EXIT_INTERRUPTED, EXIT_BROKEN_PIPE = 0, 2, 130, 141


class _Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line, by raising it."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message} (see {self.prog} --help)")


def run() -> None:
    """Entry point of the command."""
    try:
        code = main(sys.argv[1:])
        sys.stdout.flush()  # so that an error comes now and not as the interpreter leaves
    except BrokenPipeError:  # nobody reads on
        give_stdout_up()
        code = EXIT_BROKEN_PIPE
    sys.exit(code)


def main(argv: Sequence[str]) -> int:
    """Run the command with these arguments and return its exit code."""
    commands = {"campaign": campaign, "suite": suite, "score": score}
    try:
        if argv[:1] and argv[0] in commands:
            commands[argv[0]](argv[1:])
        else:
            clip(argv)
    except SystemExit as leaving:  # how argparse ends --help
        return int(leaving.code or 0)
    except CountVideoError as error:
        sys.stderr.write(f"synth-video: {error}\n")
        return EXIT_USAGE
    except KeyboardInterrupt:
        goes_on = "; the same command goes on with what is missing" * (argv[0] == "suite")
        sys.stderr.write(f"synth-video: interrupted{goes_on}\n")
        return EXIT_INTERRUPTED
    return EXIT_DONE


def clip(argv: Sequence[str]) -> None:
    """Render one clip, or list the scenes.

    Raises
    ------
    UsageError
        The request is wrong or the clip cannot be written.
    SystemExit
        After ``--help``.
    """
    options = _parser().parse_args(argv)
    if options.list:
        sys.stdout.write(_listed({name: load_scene(name).purpose for name in scene_names()}))
        return
    if options.clip is None:
        _parser().error("name the clip to write, or ask for --list")
    scene = load_scene(options.scene, options.set)
    if options.vary:
        scene = varied(scene, options.seed)
    check_place(options.clip)
    truth = render_clip(scene, options.seed, options.clip)
    sys.stdout.write(_summary(options.clip, truth))


def _parser() -> _Parser:
    parser = _Parser(
        prog="synth-video",
        description="Render a simulated trial to a clip and write its truth beside it.",
        epilog="synth-video campaign --help says how to render many trials with known figures; "
        "synth-video suite --help and synth-video score --help how to measure accuracy.",
    )
    parser.add_argument(
        "clip", nargs="?", type=Path, help="clip to write; the suffix names the container"
    )
    parser.add_argument(
        "--scene", default="paper", help="name of a scene, or path of its TOML file (paper)"
    )
    parser.add_argument(
        "--seed", type=_seed, default=0, help="decides noise, texture and clock phase (0)"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="SECTION.KEY=VALUE",
        help="change a setting of the scene, e.g. camera.capture_fps=2000; may be repeated",
    )
    parser.add_argument(
        "--vary",
        action="store_true",
        help="let the seed draw masses, gaps, restitution, wall side and capture rate as well",
    )
    parser.add_argument("--list", action="store_true", help="list the scenes and what they are for")
    return parser


def _seed(text: str) -> int:
    """Whole number, not negative."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number from 0")
    return int(text)


def _listed(sentences: Mapping[str, str]) -> str:
    """List names, and beside each its sentence, in lines that a terminal has room for."""
    beside = max(map(len, sentences)) + 2
    indent = " " * beside
    return "".join(
        textwrap.fill(sentence, WIDTH, initial_indent=f"{name:<{beside}}", subsequent_indent=indent)
        + "\n"
        for name, sentence in sentences.items()
    )


def _summary(clip: Path, truth: ClipTruth) -> str:
    apart = "resolved" if truth.resolved else "not resolved"
    return (
        f"{clip}: {truth.frames} frame{'s'[truth.frames == 1 :]}, "
        f"{truth.count} collision{'s'[truth.count == 1 :]}, {apart} "
        f"(shortest interval {truth.shortest_interval_frames:.2f} frames); "
        f"truth in {truth_path(clip).name}\n"
    )


# ---- campaigns ----------------------------------------------------------------------------------


def campaign(argv: Sequence[str]) -> None:
    """Render the trials of a campaign, or search for its seed.

    Raises
    ------
    UsageError
        The request is wrong or a clip cannot be written.
    SystemExit
        After ``--help``.
    """
    parser = _campaign_parser()
    options = parser.parse_args(argv)
    target = campaigns.target_named(options.name)
    if options.search:
        seed = campaigns.search(target)
        counts = " ".join(map(str, sorted(campaigns.true_counts(target, seed), reverse=True)))
        sys.stdout.write(f"seed {seed}: {counts}\n")
        return
    if options.folder is None:
        parser.error("name the folder to write to, or ask for --search")
    takes = campaigns.takes_of(target, target.seed, options.set)
    campaigns.write_lists(takes, target.seed, options.folder)
    for take in campaigns.film(takes, options.folder, options.jobs):
        sys.stdout.write(_trial_line(take))
        sys.stdout.flush()
    sys.stdout.write(_campaign_line(takes))


def _campaign_parser() -> _Parser:
    parser = _Parser(
        prog="synth-video campaign",
        description="Render the trials of a campaign whose true counts have published figures.",
    )
    parser.add_argument("name", help=f"which campaign: {', '.join(campaigns.CAMPAIGNS)}")
    parser.add_argument("folder", nargs="?", type=Path, help="folder to write the clips to")
    parser.add_argument(
        "--search",
        action="store_true",
        help="render nothing; search again for the seed, from 0 on, and print its counts",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="SECTION.KEY=VALUE",
        help="change a setting of all scenes, e.g. camera.width_px=320; may be repeated",
    )
    parser.add_argument(
        "--jobs",
        type=_from_one,
        default=os.cpu_count() or 1,
        metavar="N",
        help="clips to render at the same time",
    )
    return parser


def _trial_line(take: campaigns.Take) -> str:
    rate = take.scene.camera.capture_fps
    return f"{take.name}.mp4: {take.count} collisions at {rate:g} frames a second\n"


def _campaign_line(takes: Sequence[campaigns.Take]) -> str:
    counts = [take.count for take in takes]
    return (
        f"truth: maximum {max(counts)}, minimum {min(counts)}, mean {fmean(counts):.2f}, "
        f"standard deviation {pstdev(counts):.2f} over {len(counts)} trials\n"
    )


# ---- suites and scores --------------------------------------------------------------------------


def suite(argv: Sequence[str]) -> None:
    """Render the clips of a suite.

    Raises
    ------
    UsageError
        The request is wrong or a clip cannot be written.
    SystemExit
        After ``--help``.
    """
    # The folder may stand after options, which the plain parsing of optional arguments forbids.
    options = _suite_parser().parse_intermixed_args(argv)
    wanted = [name for name in options.conditions.split(",") if name]
    conditions = suites.conditions_of(options.name, wanted)
    if options.folder is None:
        sys.stdout.write(_listed({one.name: one.sentence for one in conditions}))
        return
    strengths = [options.strength] if options.strength else STRENGTHS
    takes = suites.takes_of(conditions, strengths, range(options.seeds))
    for take, rendered in suites.film(takes, options.folder, options.jobs):
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
        After ``--help``.
    """
    options = _score_parser().parse_args(argv)
    scores = score_folder(options.folder, options.results or options.folder / RESULTS)
    table = markdown(scores)
    _write(options.folder / "scores.md", f"{table}\n{shortfalls(scores)}")
    _write(options.folder / "scores.json", scores_json(scores))
    sys.stdout.write(f"{table}\n{shortfalls(scores)}")


def _suite_parser() -> _Parser:
    parser = _Parser(
        prog="synth-video suite",
        description="Render trials under conditions that make footage hard to count. Clips that "
        "are there already are kept.",
    )
    parser.add_argument("name", help=f"which suite: {', '.join(suites.SUITES)}")
    parser.add_argument(
        "folder", nargs="?", type=Path, help="folder to write to; without it the conditions' names"
    )
    parser.add_argument(
        "--conditions", default="", metavar="NAME,NAME", help="only these conditions (all)"
    )
    parser.add_argument("--strength", choices=STRENGTHS, help="only this strength (both)")
    parser.add_argument("--seeds", type=_from_one, default=10, help="clips of each cell (10)")
    parser.add_argument(
        "--jobs",
        "--workers",
        type=_from_one,
        default=os.cpu_count() or 1,
        metavar="N",
        help="clips to render at the same time",
    )
    return parser


def _score_parser() -> _Parser:
    parser = _Parser(
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

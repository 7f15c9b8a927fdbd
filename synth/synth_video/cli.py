"""The command ``synth-video``: a scene and a seed in, a clip and its truth out."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from count_video.errors import CountVideoError
from synth_video.campaign.cli import main as campaign
from synth_video.experiments.course_truth import ExperimentTruth
from synth_video.film import render_clip
from synth_video.scene_file import load_scene, scene_names
from synth_video.suite import cli as suite
from synth_video.truth import Truth, truth_path
from synth_video.variation import varied

EXIT_DONE, EXIT_USAGE, EXIT_INTERRUPTED = 0, 2, 130
_COMMANDS = {"campaign": campaign, "suite": suite.suite, "score": suite.score}
"""Commands apart from rendering one clip, by their first word."""


def run() -> None:
    """Entry point of the command."""
    sys.exit(main(sys.argv[1:]))


def main(argv: Sequence[str]) -> int:
    """Run the command with these arguments and return its exit code."""
    try:
        if argv[:1] and argv[0] in _COMMANDS:
            _COMMANDS[argv[0]](argv[1:])
            return EXIT_DONE
        options = _parser().parse_args(argv)
        if options.list:
            sys.stdout.write(_scene_list())
            return EXIT_DONE
        if options.clip is None:
            _parser().error("name the clip to write, or ask for --list")
        scene = load_scene(options.scene, options.set)
        if options.vary:
            scene = varied(scene, options.seed)
        truth = render_clip(scene, options.seed, options.clip)
    except SystemExit as leaving:  # how argparse ends --help and a wrong usage
        return int(leaving.code or 0)
    except CountVideoError as error:
        sys.stderr.write(f"synth-video: {error}\n")
        return EXIT_USAGE
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED
    sys.stdout.write(_summary(options.clip, truth))
    return EXIT_DONE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
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


def _scene_list() -> str:
    names = scene_names()
    width = max(len(name) for name in names)
    return "".join(f"{name:<{width}}  {load_scene(name).purpose}\n" for name in names)


def _summary(clip: Path, truth: Truth | ExperimentTruth) -> str:
    apart = "resolved" if truth.resolved else "not resolved"
    return (
        f"{clip}: {truth.frames} frames, {truth.count} collisions, {apart} "
        f"(shortest interval {truth.shortest_interval_frames:.2f} frames); "
        f"truth in {truth_path(clip).name}\n"
    )

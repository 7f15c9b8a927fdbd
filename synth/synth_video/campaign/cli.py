"""The command ``synth-video campaign``: many trials with known truth, or the search for them."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from statistics import fmean, pstdev

from synth_video.campaign.rendering import Take, film, takes_of, write_lists
from synth_video.campaign.seed_search import CAMPAIGNS, search, target_named, true_counts


def main(argv: Sequence[str]) -> None:
    """Run the command with these arguments.

    Raises
    ------
    UsageError
        The request is wrong or a clip cannot be written.
    SystemExit
        After ``--help``, or when the arguments make no sense.
    """
    parser = _parser()
    options = parser.parse_args(argv)
    target = target_named(options.name)
    if options.search:
        seed = search(target)
        counts = " ".join(map(str, sorted(true_counts(target, seed), reverse=True)))
        sys.stdout.write(f"seed {seed}: {counts}\n")
        return
    if options.folder is None:
        parser.error("name the folder to write to, or ask for --search")
    takes = takes_of(target, target.seed, options.set)
    write_lists(takes, target.seed, options.folder)
    for take in film(takes, options.folder, options.jobs):
        sys.stdout.write(_line(take))
        sys.stdout.flush()
    sys.stdout.write(_sum(takes))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="synth-video campaign",
        description="Render the trials of a campaign whose true counts have published figures.",
    )
    parser.add_argument("name", help=f"which campaign: {', '.join(CAMPAIGNS)}")
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
        "--jobs", type=_jobs, default=os.cpu_count() or 1, help="clips to render at the same time"
    )
    return parser


def _jobs(text: str) -> int:
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number from 1")
    return int(text)


def _line(take: Take) -> str:
    rate = take.scene.camera.capture_fps
    return f"{take.name}.mp4: {take.count} collisions at {rate:g} frames a second\n"


def _sum(takes: Sequence[Take]) -> str:
    counts = [take.count for take in takes]
    return (
        f"truth: maximum {max(counts)}, minimum {min(counts)}, mean {fmean(counts):.2f}, "
        f"standard deviation {pstdev(counts):.2f} over {len(counts)} trials\n"
    )

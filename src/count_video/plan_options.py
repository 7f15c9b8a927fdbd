"""The options of ``count-video --plan``: what a set-up is, and how well hands repeat it.

Their defaults are those of ``planning.PlanRequest``: what is not given stays None here, so that
``--help`` and a mistyped option answer at once.
"""

from __future__ import annotations

import argparse
from typing import Any

from count_video import inputs
from count_video.errors import UsageError
from count_video.inputs import as_option

_OF_A_PLAN = ("gap", "release", "thread", "restitution", "damping", "trials", "tolerance", "seed")
_OF_A_COUNT = (
    *("clips", "start", "end", "region", "wall_side", "masses", "seen_only", "corrections"),
    *("theory", "plan_file", "jobs", "fresh", "pages", "scheduler", "presenter"),
)


def add_plan_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--plan`` and what goes with it as a group of their own."""
    group = parser.add_argument_group(
        "before filming", "what a set-up will count; lengths in metres, masses in any one unit"
    )
    group.add_argument(
        "--plan",
        metavar=("HEAVY", "LIGHT"),
        nargs=2,
        type=as_option(inputs.mass),
        help="say what a set-up with these masses will count and what a camera of --capture-fps "
        "sees of it; with -o draw the map and write the page (default: count)",
    )
    group.add_argument(
        "--gap",
        metavar="M",
        type=as_option(inputs.length),
        help="from the wall to the far face of the ball where it hangs (default: 0.03)",
    )
    group.add_argument(
        "--release",
        metavar="M",
        type=as_option(inputs.length),
        help="from where the cylinder hangs, its face touching the hanging ball, to where it is "
        "let go (default: 0.09)",
    )
    group.add_argument(
        "--thread",
        metavar="M",
        nargs="+",
        type=as_option(inputs.length),
        help="length of the threads, or first the cylinder's and then the ball's (default: 1)",
    )
    _add_losses(group)
    group.add_argument(
        "--trials",
        metavar="N",
        type=as_option(inputs.trials),
        help="add a table of so many simulated trials (default: no table)",
    )
    group.add_argument(
        "--tolerance",
        metavar="NAME=VALUE",
        action="append",
        type=as_option(inputs.tolerance),
        help="how trials scatter that are meant to be alike: gap, release and thread in metres, "
        "mass as a share, restitution as the width of its range, scatter from collision to "
        "collision; may be repeated (default: gap=0.001 release=0.002 thread=0.001 mass=0.005 "
        "restitution=0.05 scatter=0.005)",
    )
    group.add_argument(
        "--seed", metavar="N", type=as_option(inputs.seed), help="of all that is drawn (default: 0)"
    )


def _add_losses(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--restitution",
        metavar="E",
        type=as_option(inputs.share),
        help="relative speed after over before a collision, 0 to 1 (default: 1)",
    )
    group.add_argument(
        "--damping",
        metavar="RATE",
        type=as_option(inputs.damping),
        help="rate a second at which a free swing decays (default: 0)",
    )


def check_plan_options(options: argparse.Namespace, parser: argparse.ArgumentParser) -> None:
    """Refuse what does not go together.

    Raises
    ------
    UsageError
        An option stands without ``--plan`` that needs it, or beside it for nothing.
    """
    wanted = options.plan is not None
    for name in _OF_A_COUNT if wanted else _OF_A_PLAN:
        value = getattr(options, name)
        if value not in (parser.get_default(name), []):
            option = {"clips": "a clip", "wall_side": "--wall"}.get(name, f"--{_dashed(name)}")
            raise UsageError(
                f"--plan goes without {option}" if wanted else f"{option} goes with --plan alone"
            )
    if options.thread is not None and len(options.thread) > 2:
        raise UsageError("--thread takes one length, or the cylinder's and the ball's")


def plan_values(options: argparse.Namespace) -> dict[str, Any]:
    """Collect what was given, by the names of the fields of ``PlanRequest``."""
    heavy, light = options.plan
    threads = options.thread or [None]
    given = {
        "heavy": heavy,
        "light": light,
        "gap_m": options.gap,
        "release_m": options.release,
        "heavy_thread_m": threads[0],
        "light_thread_m": threads[-1],
        "capture_fps": options.capture_fps,
        "restitution": options.restitution,
        "damping_per_s": options.damping,
        "ball_diameter_m": options.ball_diameter_mm / 1000.0,
        "trials": options.trials,
        "seed": options.seed,
    }
    return {name: value for name, value in given.items() if value is not None}


def _dashed(name: str) -> str:
    return name.replace("_", "-")

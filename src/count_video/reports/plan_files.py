"""A plan in a folder: its picture for screen and print, its map as a table, page and values."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path

from count_video.errors import UsageError
from count_video.outputs import OutputFolder, open_outputs
from count_video.planning import forecast as measured
from count_video.planning.forecast import Measured
from count_video.planning.plan import Plan
from count_video.progress import NO_PROGRESS, Progress
from count_video.reports.drawing import picture_bytes
from count_video.reports.json_object import plan_object
from count_video.reports.page import render
from count_video.reports.plan_picture import map_csv, plan_figure
from count_video.reports.plan_text import change_words, plan_headline, plan_text

MOST_RATIO = 10_000.0
"""Largest mass ratio that the sliders reach, unless a larger one is planned."""
LIGHT_FACTOR = 4.0
NAMES = ("plan.json", "plan.csv", "plan.html", "plan.png", "plan.svg")


def open_folder(folder: Path) -> OutputFolder:
    """Open the folder that a plan goes to, made if needed, before the plan is worked out.

    Raises
    ------
    UsageError
        It cannot be made, or has files of these names that this program did not write.
    """
    outputs = open_outputs(folder)
    for name in NAMES:
        outputs.check(name)
    return outputs


def write_plan(plan: Plan, outputs: OutputFolder, progress: Progress = NO_PROGRESS) -> None:
    """Write the files of a plan; each appears when it is complete.

    Raises
    ------
    UsageError
        If one cannot be written, or would replace what this program did not write.
    """
    progress.start(len(NAMES), "drawing")
    figure = plan_figure(plan)
    files: Mapping[str, Callable[[], bytes]] = {
        "plan.json": lambda: json.dumps(plan_object(plan), indent=1).encode("ascii") + b"\n",
        "plan.csv": lambda: map_csv(plan.chart).encode("ascii"),
        "plan.html": lambda: plan_page(plan).encode("utf-8"),
        "plan.png": lambda: picture_bytes(figure, "png"),
        "plan.svg": lambda: picture_bytes(figure, "svg"),
    }
    for name in NAMES:
        try:
            outputs.write(name, files[name]())
        except OSError as error:
            place, reason = outputs.folder / name, error.strerror or "it failed"
            message = f"cannot write {place}: {reason}; give another folder with -o"
            raise UsageError(message) from error
        progress.advance(1)
    progress.finish()


def plan_page(plan: Plan) -> str:
    """Write the page: sliders over the same simulation, in one file, without a network."""
    planned = _planned(plan)
    return render(
        "plan",
        headline=plan_headline(plan),
        count=plan.burst.count,
        sliders=_sliders(planned),
        alike=planned["heavyThread"] == planned["lightThread"],
        change=change_words(plan),
        text=plan_text(plan),
        data=_data(plan, planned),
    )


def _planned(plan: Plan) -> dict[str, float]:
    """Values of the sliders, in metres, the masses' unit and frames a second."""
    request, camera = plan.request, plan.camera
    return {
        "gap": request.gap_m,
        "release": request.release_m,
        "heavy": float(request.heavy),
        "light": float(request.light),
        "heavyThread": request.heavy_thread_m,
        "lightThread": request.light_thread_m,
        "restitution": request.restitution,
        "rate": plan.framing.rate_needed_fps if camera is None else camera.capture_fps,
    }


def _sliders(planned: Mapping[str, float]) -> list[dict[str, object]]:
    """Sliders with their ends; masses and rate by the logarithm to base 10, in even steps."""
    light = planned["light"]
    most = light * max(MOST_RATIO, planned["heavy"] / light)
    ranges: Mapping[str, tuple[str, float, float, float]] = {
        "gap": ("Gap, ball to wall", 0.005, 0.1, 0.0005),
        "release": ("Release", 0.02, 0.2, 0.001),
        "heavy": ("Mass of the cylinder", light, most, 0),
        "light": ("Mass of the ball", light / LIGHT_FACTOR, light * LIGHT_FACTOR, 0),
        "heavyThread": ("Thread of the cylinder", 0.2, 3.0, 0.001),
        "lightThread": ("Thread of the ball", 0.2, 3.0, 0.001),
        "restitution": ("Restitution", 0.85, 1.0, 0.001),
        "rate": ("Camera", 24.0, 100_000.0, 0),
    }
    sliders = []
    for name, (label, low, high, step) in ranges.items():
        ends = [min(planned[name], low), max(planned[name], high), planned[name]]
        if not step:
            ends = [
                round(math.log10(ends[0]), 4),
                round(math.log10(ends[1]), 4),
                math.log10(ends[2]),
            ]
        least, most, value = ends
        style = {"name": name, "label": label, "step": step or 0.002}
        sliders.append({**style, "least": least, "most": most, "value": value})
    return sliders


def _data(plan: Plan, planned: Mapping[str, float]) -> dict[str, object]:
    request = plan.request

    def like(clips: Measured) -> dict[str, object]:
        return {**asdict(clips), "chance": clips.chance}

    return {
        "planned": planned,
        "damping": request.damping_per_s,
        "ballDiameter": request.ball_diameter_m,
        "tolerances": asdict(request.tolerances),
        "seed": request.seed,
        "measured": {
            "resolved": like(measured.RESOLVED),
            "between": like(measured.BETWEEN),
            "close": like(measured.CLOSE),
            "long": like(measured.LONG),
            "closest_frames": measured.CLOSEST_FRAMES,
            "closer_frames": measured.CLOSER_FRAMES,
            "most_of_a_short_burst": measured.MOST_OF_A_SHORT_BURST,
            "long_burst": list(measured.LONG_BURST),
            "long_burst_fps": measured.LONG_BURST_FPS,
        },
    }

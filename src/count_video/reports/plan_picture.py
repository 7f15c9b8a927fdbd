"""The picture of a plan: its map, and the planned trial as a measured one is drawn; its files."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from scipy import ndimage

from count_video.outputs import OutputFolder, explained, open_outputs
from count_video.physics.many import NO_COUNT
from count_video.planning.plan import Plan
from count_video.planning.spread import RESOLVED_FRAMES, Chart, rate_needed_fps
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import Floats
from count_video.reports.drawing import (
    BLACK,
    GREEN,
    HALO,
    OWN,
    VERMILION,
    drawable,
    picture_bytes,
    place_numbers,
    styled,
)
from count_video.reports.json_object import plan_object
from count_video.reports.page import plan_page
from count_video.reports.panels import draw_enlarged, draw_whole, legend_handles
from count_video.reports.plan_text import plan_headline
from count_video.reports.planned import planned_material
from count_video.reports.states import draw_states

SIZE_INCHES = (16.0, 12.0)
RATES_FPS = (60, 120, 240, 480, 960, 2000, 4000, 8000, 16_000, 32_000, 64_000, 128_000)
"""Rates whose contours are drawn, where they lie on the map."""
MOST_COLOURS = 12
"""From more counts on several share a colour."""
LETTER_CELLS = 2.2
"""A count is written where its region reaches this far to all sides."""
ELLIPSE_SIGMAS = 2.0


def plan_figure(plan: Plan) -> Figure:
    """Draw the map above the space-time picture, and the phase circle."""
    material = planned_material(plan)
    with styled():
        figure = Figure(figsize=SIZE_INCHES)
        figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.1)
        title = f"Plan: {plan_headline(plan)}"
        figure.suptitle(drawable(title), fontsize=20, weight="bold", parse_math=False)
        rows = figure.add_gridspec(2, 1, height_ratios=[1.25, 1])
        above = rows[0].subgridspec(1, 2, width_ratios=[1.25, 1])
        below = rows[1].subgridspec(1, 2)
        if plan.chart is not None:
            _draw_map(figure.add_subplot(above[0]), plan, plan.chart)
        circle = figure.add_subplot(above[1])
        draw_states(circle, material)
        circle.set_title("Phase circle: theory (lines) and planned states")
        for column, draw in enumerate((draw_whole, draw_enlarged)):
            axes = figure.add_subplot(below[column])
            draw(axes, material)
            axes.set_xlabel("frame, from the release")
        figure.legend(handles=legend_handles(material), loc="outside lower center", ncols=6)
        place_numbers(figure)
        return figure


def _draw_map(axes: Axes, plan: Plan, chart: Chart) -> None:
    """Draw the map; lengths in centimetres."""
    gap_cm, release_cm = 100 * chart.gap_m, 100 * chart.release_m
    _draw_cells(axes, gap_cm, release_cm, chart, plan.burst.theory)
    _draw_rates(axes, gap_cm, release_cm, chart)
    for count in np.unique(chart.count[chart.count != NO_COUNT]):
        _write_count(axes, gap_cm, release_cm, chart.count == count, str(count))
    _draw_setup(axes, plan)
    axes.set(xlim=_ends(gap_cm), ylim=_ends(release_cm))
    axes.set_xlabel("gap from the wall to the hanging ball (cm)")
    axes.set_ylabel("release (cm)")
    axes.set_title("Counts by gap and release; lines: frames a second to see each collision")


def _draw_cells(axes: Axes, gap_cm: Floats, release_cm: Floats, chart: Chart, theory: int) -> None:
    """Colour the counts, the theory's in green; no count is hatched."""
    counts = np.ma.masked_equal(chart.count, NO_COUNT)
    axes.set_facecolor("#f0f0f0")
    low, high = _ends(gap_cm), _ends(release_cm)
    axes.fill_between(low, high[0], high[1], facecolor="none", hatch="///", edgecolor="#c8c8c8")
    if counts.count() == 0:
        return
    least, most = int(counts.min()), int(counts.max())
    steps = max(1, math.ceil((most - least + 1) / MOST_COLOURS))
    borders = np.arange(least, most + steps + 1, steps) - 0.5
    colours = ListedColormap(mpl.colormaps["Blues"](np.linspace(0.1, 0.6, len(borders) - 1)))
    norm = BoundaryNorm(borders, colours.N)
    own = np.ma.masked_where(counts != theory, np.ones(counts.shape))
    # Thousands of squares would make a large file of an SVG, so they are drawn as pixels.
    kept: Any = {"rasterized": True}
    axes.pcolormesh(gap_cm, release_cm, counts, cmap=colours, norm=norm, zorder=1, **kept)
    axes.pcolormesh(gap_cm, release_cm, own, cmap=ListedColormap([OWN]), zorder=1.1, **kept)


def _draw_rates(axes: Axes, gap_cm: Floats, release_cm: Floats, chart: Chart) -> None:
    """Draw where each usual rate is just enough."""
    needed = RESOLVED_FRAMES / chart.shortest_s
    if not np.isfinite(needed).any():
        return
    low, high = np.nanmin(needed), np.nanmax(needed[np.isfinite(needed)])
    levels = [rate for rate in RATES_FPS if low < rate < high]
    if not levels:
        return
    style: Any = {"colors": BLACK, "linewidths": 0.9, "linestyles": "dashed", "zorder": 2}
    shown = np.ma.masked_invalid(needed)
    lines = axes.contour(gap_cm, release_cm, shown, levels=levels, **style)
    for label in axes.clabel(lines, fmt=lambda rate: f"{rate:g}/s", fontsize=9):
        label.set_path_effects(list(HALO))


def _write_count(
    axes: Axes, gap_cm: Floats, release_cm: Floats, region: np.ndarray, text: str
) -> None:
    """Write a count where its region is widest, if it is wide enough to hold it."""
    depth = ndimage.distance_transform_edt(np.pad(region, 1))[1:-1, 1:-1]
    row, column = np.unravel_index(int(depth.argmax()), depth.shape)
    widest = float(depth[row, column])
    if widest >= LETTER_CELLS:
        axes.text(
            float(gap_cm[column]),
            float(release_cm[row]),
            text,
            ha="center",
            va="center",
            fontsize=min(20.0, 8.0 + 1.2 * widest),
            weight="bold",
            path_effects=list(HALO),
            zorder=3,
            gid="count",
        )


def _draw_setup(axes: Axes, plan: Plan) -> None:
    """Draw the planned set-up as a dot, its tolerance as an ellipse, and what to change."""
    request, off = plan.request, plan.request.tolerances
    place = (100 * request.gap_m, 100 * request.release_m)
    size = (200 * ELLIPSE_SIGMAS * off.gap_m, 200 * ELLIPSE_SIGMAS * off.release_m)
    style: Any = {"facecolor": "none", "edgecolor": VERMILION, "linewidth": 2.0, "zorder": 4}
    axes.add_patch(Ellipse(place, *size, gid="tolerance", **style))
    axes.plot(*place, "o", color=VERMILION, markeredgecolor="white", markersize=9, zorder=5)
    for proposal in plan.proposals:
        if proposal.change != "heavy mass":
            value = 100 * proposal.value
            target = (value, place[1]) if proposal.change == "gap" else (place[0], value)
            arrow = {"arrowstyle": "-|>", "color": GREEN, "linewidth": 2.0}
            axes.annotate("", target, xytext=place, arrowprops=arrow, zorder=4)


def map_csv(chart: Chart | None) -> str:
    """Write the map as a table: a row a cell, lengths in metres."""
    lines = ["gap_m,release_m,count,shortest_s,rate_needed_fps"]
    if chart is not None:
        lines += [_cell_csv(chart, row, column) for row, column in np.ndindex(chart.count.shape)]
    return "\n".join(lines) + "\n"


def _cell_csv(chart: Chart, row: int, column: int) -> str:
    count, shortest = int(chart.count[row, column]), float(chart.shortest_s[row, column])
    known = count != NO_COUNT
    interval = f"{shortest:.6g}" if known and math.isfinite(shortest) else ""
    rate = f"{rate_needed_fps(shortest):.0f}" if known else ""
    place = f"{chart.gap_m[column]:.4f},{chart.release_m[row]:.4f}"
    return f"{place},{count if known else ''},{interval},{rate}"


def _ends(centres_cm: Floats) -> tuple[float, float]:
    """Outer borders of the first and the last cell."""
    half = (centres_cm[1] - centres_cm[0]) / 2
    return float(centres_cm[0] - half), float(centres_cm[-1] + half)


# ---- the files of a plan -----------------------------------------------------------------------

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
        with explained(outputs.folder / name):
            outputs.write(name, files[name]())
        progress.advance(1)
    progress.finish()

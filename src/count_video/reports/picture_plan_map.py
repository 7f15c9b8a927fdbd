"""The map of a plan: counts over gap and release, the rates they need, and the set-up's place."""

from __future__ import annotations

import math

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Ellipse
from scipy import ndimage

from count_video.physics.many import NO_COUNT
from count_video.planning.camera import rate_needed_fps
from count_video.planning.chart import Chart
from count_video.planning.measured import RESOLVED_FRAMES
from count_video.planning.whole import Plan
from count_video.records import Floats
from count_video.reports.drawing import HALO
from count_video.reports.palette import BLACK, GREEN, VERMILION

RATES_FPS = (60, 120, 240, 480, 960, 2000, 4000, 8000, 16_000, 32_000, 64_000, 128_000)
"""Rates whose contours are drawn, where they lie on the map."""
OWN = "#8fd4b4"
"""Colour of the theory's count."""
MOST_COLOURS = 12
"""From more counts on several share a colour."""
ROOM_CELLS = 2.2
"""A count is written where its region reaches this far to all sides."""
ELLIPSE_SIGMAS = 2.0


def draw_plan_map(axes: Axes, plan: Plan, chart: Chart) -> None:
    """Draw the map; lengths in centimetres."""
    gap_cm, release_cm = 100 * chart.gap_m, 100 * chart.release_m
    counts = np.ma.masked_equal(chart.count, NO_COUNT)
    _draw_cells(axes, gap_cm, release_cm, counts, plan.burst.theory)
    _draw_rates(axes, gap_cm, release_cm, chart)
    _write_counts(axes, chart)
    _draw_setup(axes, plan)
    axes.set_xlim(*_ends(gap_cm))
    axes.set_ylim(*_ends(release_cm))
    axes.set_xlabel("gap from the wall to the hanging ball (cm)")
    axes.set_ylabel("release (cm)")
    axes.set_title("Counts by gap and release; lines: frames a second to see each collision")


def _draw_cells(
    axes: Axes, gap_cm: Floats, release_cm: Floats, counts: np.ma.MaskedArray, theory: int
) -> None:
    """Colour the counts, the theory's in green; no count is hatched."""
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
    cells = axes.pcolormesh(gap_cm, release_cm, counts, cmap=colours, norm=norm, zorder=1)
    cells.set_rasterized(True)  # thousands of squares would make a large file of an SVG
    cells = axes.pcolormesh(gap_cm, release_cm, own, cmap=ListedColormap([OWN]), zorder=1.1)
    cells.set_rasterized(True)


def _draw_rates(axes: Axes, gap_cm: Floats, release_cm: Floats, chart: Chart) -> None:
    """Draw where each usual rate is just enough."""
    needed = RESOLVED_FRAMES / chart.shortest_s
    if not np.isfinite(needed).any():
        return
    low, high = np.nanmin(needed), np.nanmax(needed[np.isfinite(needed)])
    levels = [rate for rate in RATES_FPS if low < rate < high]
    if not levels:
        return
    lines = axes.contour(
        gap_cm,
        release_cm,
        np.ma.masked_invalid(needed),
        levels=levels,
        colors=BLACK,
        linewidths=0.9,
        linestyles="dashed",
        zorder=2,
    )
    labels = axes.clabel(lines, fmt=lambda rate: f"{rate:g}/s", fontsize=9)
    for label in labels:
        label.set_path_effects(list(HALO))


def _write_counts(axes: Axes, chart: Chart) -> None:
    """Write each count where its region is widest, if it is wide enough to hold it."""
    for count in np.unique(chart.count[chart.count != NO_COUNT]):
        depth = ndimage.distance_transform_edt(np.pad(chart.count == count, 1))[1:-1, 1:-1]
        row, column = np.unravel_index(int(depth.argmax()), depth.shape)
        if depth[row, column] >= ROOM_CELLS:
            axes.text(
                100 * float(chart.gap_m[column]),
                100 * float(chart.release_m[row]),
                str(count),
                ha="center",
                va="center",
                fontsize=min(20.0, 8.0 + 1.2 * float(depth[row, column])),
                weight="bold",
                path_effects=list(HALO),
                zorder=3,
                gid="count",
            )


def _draw_setup(axes: Axes, plan: Plan) -> None:
    """Draw the planned set-up as a dot, its tolerance as an ellipse, and what to change."""
    request, off = plan.request, plan.request.tolerances
    place = (100 * request.gap_m, 100 * request.release_m)
    axes.add_patch(
        Ellipse(
            place,
            2 * ELLIPSE_SIGMAS * 100 * off.gap_m,
            2 * ELLIPSE_SIGMAS * 100 * off.release_m,
            facecolor="none",
            edgecolor=VERMILION,
            linewidth=2.0,
            zorder=4,
            gid="tolerance",
        )
    )
    axes.plot(*place, "o", color=VERMILION, markeredgecolor="white", markersize=9, zorder=5)
    for proposal in plan.proposals:
        if proposal.change == "heavy mass":
            continue
        value = 100 * proposal.value
        target = (value, place[1]) if proposal.change == "gap" else (place[0], value)
        axes.annotate(
            "",
            target,
            xytext=place,
            arrowprops={"arrowstyle": "-|>", "color": GREEN, "linewidth": 2.0},
            zorder=4,
        )


def map_csv(chart: Chart) -> str:
    """Write the map as a table: a row a cell, lengths in metres."""
    lines = ["gap_m,release_m,count,shortest_s,rate_needed_fps"]
    for row, release in enumerate(chart.release_m):
        for column, gap in enumerate(chart.gap_m):
            count, shortest = int(chart.count[row, column]), float(chart.shortest_s[row, column])
            known = count != NO_COUNT
            interval = f"{shortest:.6g}" if known and math.isfinite(shortest) else ""
            rate = f"{rate_needed_fps(shortest):.0f}" if known else ""
            lines.append(f"{gap:.4f},{release:.4f},{count if known else ''},{interval},{rate}")
    return "\n".join(lines) + "\n"


def _ends(centres_cm: Floats) -> tuple[float, float]:
    """Outer borders of the first and the last cell."""
    half = (centres_cm[1] - centres_cm[0]) / 2
    return float(centres_cm[0] - half), float(centres_cm[-1] + half)

"""The picture of a plan: its map, and the planned trial drawn as a measured one is; its files."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from scipy import ndimage

from count_video.physics.setup import Setup, swing_rate
from count_video.planning.plan import PICTURE_WIDTH_PX, Plan
from count_video.planning.variations import RESOLVED_FRAMES
from count_video.records import (
    BodyTrack,
    Collision,
    Estimate,
    FittedSetup,
    Floats,
    MotionLine,
    Track,
    TrialResult,
    Velocities,
)
from count_video.reports.drawing import (
    GREEN,
    HALO,
    MEDIA_TYPES,
    OWN,
    VERMILION,
    drawable,
    figure_of,
    picture_bytes,
)
from count_video.reports.exports import plan_object, table_csv
from count_video.reports.figure import add_legend
from count_video.reports.material import Material
from count_video.reports.page import data_address, plan_page
from count_video.reports.panels import panels_of
from count_video.reports.plan_text import plan_headline
from count_video.settings import CsvDialect

RATES_FPS = (60, 120, 240, 480, 960, 2000, 4000, 8000, 16_000, 32_000, 64_000, 128_000)
"""Rates whose contours are drawn, where they lie on the map."""


def plan_figure(plan: Plan) -> Figure:
    """Draw the map above the space-time picture, and the phase circle."""
    material = planned_material(plan)
    draw = panels_of(material)
    below = ["space-time", "enlarged" if "enlarged" in draw else "space-time"]
    with figure_of(16.0, 12.0) as figure:
        title = drawable(f"Plan: {plan_headline(plan)}")
        figure.suptitle(title, fontsize=20, weight="bold", parse_math=False)
        rows: Any = [["map", "phase-circle"], below]
        panels = figure.subplot_mosaic(rows, height_ratios=[1.25, 1])
        _draw_map(panels.pop("map"), plan)
        for name, axes in panels.items():
            draw[name](axes, material)
        add_legend(figure, panels["space-time"])
    return figure


def _draw_map(axes: Axes, plan: Plan) -> None:
    """Draw the map; lengths in centimetres. The theory's count is green; no count is hatched."""
    chart = plan.chart
    if chart is None:
        axes.set_axis_off()
        return
    cells = 100 * chart["gap_m"][0], 100 * chart["release_m"][:, 0]
    counts = np.ma.masked_invalid(chart["count"])
    least, most = (counts.min(), counts.max()) if counts.count() else (0, 1)
    reach = max(1, most - least)
    axes.patch.set(facecolor="#f0f0f0", edgecolor="#c8c8c8", hatch="///")
    # Thousands of squares would make a large file of an SVG, so they are drawn as pixels.
    style: Any = {"rasterized": True, "zorder": 1}
    pale: Any = {"vmin": least - 0.2 * reach, "vmax": most + 0.8 * reach}  # numbers stay readable
    axes.pcolormesh(*cells, counts, cmap="Blues", **pale, **style)
    own = np.ma.masked_not_equal(counts, plan.burst.theory)
    axes.pcolormesh(*cells, own, cmap=ListedColormap([OWN]), **style)
    axes.set(xlim=axes.get_xlim(), ylim=axes.get_ylim())  # whatever else is drawn
    _draw_rates(axes, cells, RESOLVED_FRAMES / chart["shortest_s"])
    _write_counts(axes, cells, counts)
    _draw_setup(axes, plan)
    axes.set_xlabel("gap from the wall to the hanging ball (cm)")
    axes.set_ylabel("release (cm)")
    axes.set_title("Counts by gap and release; lines: frames a second to see each collision")


def _draw_rates(axes: Axes, cells: tuple[Floats, Floats], needed_fps: Floats) -> None:
    """Draw where each usual rate is just enough."""
    finite = needed_fps[np.isfinite(needed_fps)]
    levels = [rate for rate in RATES_FPS if (finite < rate).any() and (finite > rate).any()]
    if levels:
        style: Any = {"colors": "black", "linewidths": 0.9, "linestyles": "dashed", "zorder": 2}
        lines = axes.contour(*cells, np.ma.masked_invalid(needed_fps), levels=levels, **style)
        for label in axes.clabel(lines, fmt=lambda rate: f"{rate:g}/s", fontsize=9):
            label.set_path_effects(list(HALO))


def _write_counts(axes: Axes, cells: tuple[Floats, Floats], counts: Any) -> None:
    """Write each count where its region is widest, if it is wide enough to hold it."""
    style: Any = {"ha": "center", "va": "center", "weight": "bold", "gid": "count", "zorder": 3}
    for count in np.unique(counts.compressed()):
        region = np.pad(counts.filled(0) == count, 1)
        depth = ndimage.distance_transform_edt(region)[1:-1, 1:-1]
        row, column = np.unravel_index(int(depth.argmax()), depth.shape)
        widest = float(depth[row, column])
        if widest >= 2.2:
            place = float(cells[0][column]), float(cells[1][row])
            size = min(20.0, 8.0 + 1.2 * widest)
            axes.text(*place, f"{count:.0f}", fontsize=size, path_effects=list(HALO), **style)


def _draw_setup(axes: Axes, plan: Plan) -> None:
    """Draw the planned set-up as a dot, twice its tolerance as an ellipse, and what to change."""
    request, off = plan.request, plan.request.tolerances
    gap_cm, release_cm = place = (100 * request.gap_m, 100 * request.release_m)
    style: Any = {"facecolor": "none", "edgecolor": VERMILION, "linewidth": 2.0, "zorder": 4}
    size_cm = (400 * off.gap_m, 400 * off.release_m)
    axes.add_patch(Ellipse(place, *size_cm, gid="tolerance", **style))
    axes.plot(*place, "o", color=VERMILION, markeredgecolor="white", markersize=9, zorder=5)
    arrow = {"arrowstyle": "-|>", "color": GREEN, "linewidth": 2.0}
    for proposal in plan.proposals:
        value_cm = 100 * proposal.value
        targets = {"gap": (value_cm, release_cm), "release": (gap_cm, value_cm)}
        if proposal.change in targets:
            target = targets[proposal.change]
            axes.annotate("", target, xytext=place, arrowprops=arrow, zorder=4)


# ---- the planned trial as if it had been counted -------------------------------------------------


def planned_material(plan: Plan) -> Material:
    """Make what the panels of a measured trial are drawn from.

    Frame 0 is the release, and px are those of a picture that holds wall and burst and little else;
    places are counted from the wall. The paths are drawn between the frames as well.
    """
    motion, request, setup = plan.motion, plan.request, plan.motion.setup
    fps = plan.framing.rate_needed_fps if plan.camera is None else plan.camera.capture_fps
    diameter_px = plan.framing.ball_at_most_px
    half_px, px_per_m = diameter_px / 2, diameter_px / request.ball_diameter_m
    times_s = np.array([bounce.time_s for bounce in motion.burst])
    margin_s = 0.12 * max(times_s[-1] - times_s[0], 1e-3)
    even = np.linspace(max(0.0, times_s[0] - margin_s), times_s[-1] + margin_s, 1000)
    drawn_s = np.union1d(even, times_s)  # the paths have corners at the collisions
    sample, still = motion.sample(drawn_s), np.zeros(len(drawn_s))
    ball_px = half_px + px_per_m * sample.ball_far_face_m
    heavy_px = px_per_m * sample.heavy_face_m
    track = Track(
        frame=drawn_s * fps,
        ball=BodyTrack(ball_px, still, -half_px, half_px),
        heavy=BodyTrack(heavy_px, still, 0.0, float(PICTURE_WIDTH_PX)),
        wall_side="left",
        ball_diameter_px=diameter_px,
        line=MotionLine(0.0, 0.0, 0.0, upright=False),
        warnings=(),
    )
    collisions = _as_counted(plan, fps, px_per_m, np.interp(times_s, drawn_s, ball_px))
    result = TrialResult(
        clip="plan",
        status="counted",
        reason=None,
        count=len(collisions),
        collisions=collisions,
        wall_side=track.wall_side,
        capture_fps=fps,
        millimetres_per_px=1e3 / px_per_m,
        mass_ratio=request.mass_ratio,
        setup=_as_fitted(setup, fps, px_per_m),
    )
    return Material(result, track)


def _as_fitted(setup: Setup, fps: float, px_per_m: float) -> FittedSetup:
    """Describe a set-up as a fit would that knows all of it."""
    lengths = (setup.wall_gap_m, setup.release_m, setup.bodies_gap_m)
    threads = (setup.heavy_thread_m, setup.light_thread_m)
    periods = (2 * math.pi / swing_rate(thread, setup.gravity_m_s2) for thread in threads)
    known = [*(px_per_m * one for one in lengths), *(fps * one for one in periods)]
    return FittedSetup(*(Estimate(one, 0.0) for one in known))


def _as_counted(
    plan: Plan, fps: float, px_per_m: float, places_px: Floats
) -> tuple[Collision, ...]:
    """Describe the collisions; one counts as seen if both its neighbours are far enough away."""
    gaps_s = np.array([math.inf, *plan.burst.intervals_s, math.inf])
    clear = np.minimum(gaps_s[:-1], gaps_s[1:]) >= RESOLVED_FRAMES / fps
    unit = px_per_m / fps
    return tuple(
        Collision(
            number=number,
            kind=one.kind,
            frame=one.time_s * fps,
            frame_sigma=0.0,
            time_s=one.time_s,
            seen=bool(seen),
            position_px=float(place_px),
            velocity_before=Velocities(unit * one.light_before_m_s, unit * one.heavy_before_m_s),
            velocity_after=Velocities(unit * one.light_after_m_s, unit * one.heavy_after_m_s),
        )
        for number, (one, seen, place_px) in enumerate(
            zip(plan.motion.burst, clear, places_px, strict=True), 1
        )
    )


# ---- the files of a plan -----------------------------------------------------------------------

NAMES = ("plan.json", "plan.csv", "plan.html", "plan.png", "plan.svg")


def plan_files(plan: Plan, csv_dialect: CsvDialect = "comma") -> Iterator[tuple[str, bytes]]:
    """Yield the names of the files, and what each holds."""
    yield "plan.json", json.dumps(plan_object(plan), indent=1).encode("ascii") + b"\n"
    table = "" if plan.chart is None else table_csv(plan.chart.ravel(), csv_dialect)
    yield "plan.csv", table.encode("ascii")
    figure = plan_figure(plan)
    yield "plan.svg", picture_bytes(figure, "svg")
    picture = picture_bytes(figure, "png")
    yield "plan.png", picture
    page = plan_page(plan, data_address(picture, MEDIA_TYPES["png"]))
    yield "plan.html", page.encode("utf-8")

"""The picture of a plan: its map, and the planned trial drawn as a measured one is; its files."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from numpy.typing import NDArray
from scipy import ndimage

from count_video.outputs import OutputFolder, explained
from count_video.physics.simulator import NO_COUNT
from count_video.planning.plan import PICTURE_WIDTH_PX, Plan
from count_video.planning.spread import RESOLVED_FRAMES, Chart
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import (
    BodyTrack,
    Collision,
    Floats,
    MotionLine,
    Track,
    TrialResult,
    Velocities,
)
from count_video.reports.drawing import (
    BLACK,
    GREEN,
    HALO,
    OWN,
    VERMILION,
    drawable,
    picture_bytes,
    styled,
    thin_numbers,
)
from count_video.reports.figure import add_legend, figure_of
from count_video.reports.json_object import plan_object
from count_video.reports.material import Material, Pendulum
from count_video.reports.page import plan_page
from count_video.reports.panels import draw_enlarged, draw_states, draw_whole
from count_video.reports.plan_text import plan_headline
from count_video.reports.tables import map_csv

SIZE_INCHES = (16.0, 12.0)
RATES_FPS = (60, 120, 240, 480, 960, 2000, 4000, 8000, 16_000, 32_000, 64_000, 128_000)
"""Rates whose contours are drawn, where they lie on the map."""
LETTER_CELLS = 2.2
"""A count is written where its region reaches this far to all sides."""
ELLIPSE_SIGMAS = 2.0


def plan_figure(plan: Plan) -> Figure:
    """Draw the map above the space-time picture, and the phase circle."""
    material = planned_material(plan)
    with styled():
        figure = figure_of(*SIZE_INCHES)
        title = f"Plan: {plan_headline(plan)}"
        figure.suptitle(drawable(title), fontsize=20, weight="bold", parse_math=False)
        (above, circle), below = figure.subplots(2, 2, height_ratios=[1.25, 1])
        if plan.chart is None:
            above.set_axis_off()
        else:
            _draw_map(above, plan, plan.chart)
        draw_states(circle, material)
        circle.set_title("Phase circle: theory (lines) and planned states")
        for axes, draw in zip(below, (draw_whole, draw_enlarged), strict=True):
            draw(axes, material)
            axes.set_xlabel("frame, from the release")
        add_legend(figure, below[0])
        thin_numbers(figure)
        return figure


def _draw_map(axes: Axes, plan: Plan, chart: Chart) -> None:
    """Draw the map; lengths in centimetres. The theory's count is green; no count is hatched."""
    cells = 100 * chart.gap_m, 100 * chart.release_m
    counts = np.ma.masked_equal(chart.count, NO_COUNT)
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
    _draw_rates(axes, cells, RESOLVED_FRAMES / chart.shortest_s)
    for count in np.unique(counts.compressed()):
        _write_count(axes, cells, chart.count == count, str(count))
    _draw_setup(axes, plan)
    axes.set_xlabel("gap from the wall to the hanging ball (cm)")
    axes.set_ylabel("release (cm)")
    axes.set_title("Counts by gap and release; lines: frames a second to see each collision")


def _draw_rates(axes: Axes, cells: tuple[Floats, Floats], needed_fps: Floats) -> None:
    """Draw where each usual rate is just enough."""
    finite = needed_fps[np.isfinite(needed_fps)]
    levels = [rate for rate in RATES_FPS if (finite < rate).any() and (finite > rate).any()]
    if levels:
        style: Any = {"colors": BLACK, "linewidths": 0.9, "linestyles": "dashed", "zorder": 2}
        lines = axes.contour(*cells, np.ma.masked_invalid(needed_fps), levels=levels, **style)
        for label in axes.clabel(lines, fmt=lambda rate: f"{rate:g}/s", fontsize=9):
            label.set_path_effects(list(HALO))


def _write_count(
    axes: Axes, cells: tuple[Floats, Floats], region: NDArray[np.bool_], count: str
) -> None:
    """Write a count where its region is widest, if it is wide enough to hold it."""
    depth = ndimage.distance_transform_edt(np.pad(region, 1))[1:-1, 1:-1]
    row, column = np.unravel_index(int(depth.argmax()), depth.shape)
    widest = float(depth[row, column])
    if widest >= LETTER_CELLS:
        place = float(cells[0][column]), float(cells[1][row])
        size = min(20.0, 8.0 + 1.2 * widest)
        style: Any = {"ha": "center", "va": "center", "weight": "bold", "gid": "count"}
        axes.text(*place, count, fontsize=size, path_effects=list(HALO), zorder=3, **style)


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


# ---- the planned trial as if it had been counted -------------------------------------------------

POINTS = 1000
"""Of the paths, besides those at the collisions, between which they are smooth."""
BEYOND = 0.12
"""The picture begins this share of the burst before the first collision, and ends so after it."""


def planned_material(plan: Plan) -> Material:
    """Make what the panels of a measured trial are drawn from.

    Frame 0 is the release, and px are those of a picture that holds wall and burst and little else;
    places are counted from the wall. The paths are drawn between the frames as well. A collision
    counts as seen if both its neighbours are far enough away.
    """
    motion, burst, request = plan.motion, plan.motion.burst, plan.request
    fps = plan.framing.rate_needed_fps if plan.camera is None else plan.camera.capture_fps
    px_per_m = plan.framing.ball_at_most_px / request.ball_diameter_m
    half_px, wide_px = plan.framing.ball_at_most_px / 2, float(PICTURE_WIDTH_PX)
    times_s = np.array([bounce.time_s for bounce in burst])
    margin_s = BEYOND * max(times_s[-1] - times_s[0], 1e-3)
    even = np.linspace(max(0.0, times_s[0] - margin_s), times_s[-1] + margin_s, POINTS)
    drawn_s = np.union1d(even, times_s)  # the paths have corners at the collisions
    sample, still = motion.sample(drawn_s), np.zeros(len(drawn_s))
    ball_px = half_px + px_per_m * sample.ball_far_face_m
    track = Track(
        frame=drawn_s * fps,
        ball=BodyTrack(ball_px, still, -half_px, half_px),
        heavy=BodyTrack(px_per_m * sample.heavy_face_m, still, 0.0, wide_px),
        wall_side="left",
        ball_diameter_px=2 * half_px,
        line=MotionLine(0.0, 0.0, 0.0, upright=False),
        warnings=(),
    )
    gaps_s = np.diff(times_s, prepend=-np.inf, append=np.inf)
    clear = np.minimum(gaps_s[:-1], gaps_s[1:]) >= RESOLVED_FRAMES / fps
    unit = px_per_m / fps
    collisions = tuple(
        Collision(
            number=number,
            kind=bounce.kind,
            frame=bounce.time_s * fps,
            frame_sigma=0.0,
            time_s=bounce.time_s,
            seen=bool(seen),
            position_px=float(np.interp(bounce.time_s, drawn_s, ball_px)),
            velocity_before=Velocities(
                unit * bounce.light_before_m_s, unit * bounce.heavy_before_m_s
            ),
            velocity_after=Velocities(unit * bounce.light_after_m_s, unit * bounce.heavy_after_m_s),
        )
        for number, (bounce, seen) in enumerate(zip(burst, clear, strict=True), 1)
    )
    result = TrialResult(
        clip="plan",
        status="counted",
        reason=None,
        count=len(burst),
        collisions=collisions,
        capture_fps=fps,
        millimetres_per_px=1e3 / px_per_m,
        mass_ratio=request.mass_ratio,
    )
    setup = motion.setup
    rate_squared = setup.gravity_m_s2 / setup.heavy_thread_m / fps**2
    return Material(result, track, Pendulum(rate_squared, px_per_m * setup.heavy_rest_m))


# ---- the files of a plan -----------------------------------------------------------------------

_CONTENTS: Mapping[str, Callable[[Plan, Figure], bytes]] = {
    "plan.json": lambda plan, _: json.dumps(plan_object(plan), indent=1).encode("ascii") + b"\n",
    "plan.csv": lambda plan, _: map_csv(plan.chart).encode("ascii") if plan.chart else b"",
    "plan.html": lambda plan, _: plan_page(plan).encode("utf-8"),
    "plan.png": lambda _, figure: picture_bytes(figure, "png"),
    "plan.svg": lambda _, figure: picture_bytes(figure, "svg"),
}
NAMES = tuple(_CONTENTS)
"""Files of a plan, and above what each holds."""


def write_plan(plan: Plan, outputs: OutputFolder, progress: Progress = NO_PROGRESS) -> None:
    """Write the files of a plan; each appears when it is complete.

    Raises
    ------
    UsageError
        If one cannot be written, or would replace what this program did not write.
    """
    progress.start(len(NAMES), "drawing")
    figure = plan_figure(plan)
    for name, content in _CONTENTS.items():
        with explained(outputs.folder / name):
            outputs.write(name, content(plan, figure))
        progress.advance(1)
    progress.finish()

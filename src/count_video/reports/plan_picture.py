"""The picture of a plan: its map, and the planned trial drawn as a measured one is; its files."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
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
    place_numbers,
    styled,
)
from count_video.reports.json_object import plan_object
from count_video.reports.material import Material, Pendulum
from count_video.reports.page import plan_page
from count_video.reports.panels import draw_enlarged, draw_whole, legend_handles
from count_video.reports.plan_text import plan_headline
from count_video.reports.states import draw_states
from count_video.reports.tables import map_csv

SIZE_INCHES = (16.0, 12.0)
RATES_FPS = (60, 120, 240, 480, 960, 2000, 4000, 8000, 16_000, 32_000, 64_000, 128_000)
"""Rates whose contours are drawn, where they lie on the map."""
MOST_COLOURS = 12
"""Where there are more counts than this, several share a colour."""
LETTER_CELLS = 2.2
"""A count is written where its region reaches this far to all sides."""
ELLIPSE_SIGMAS = 2.0


def plan_figure(plan: Plan) -> Figure:
    """Draw the map above the space-time picture, and the phase circle."""
    material = _Filmed(plan).material()
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
        _write_count(axes, gap_cm, release_cm, chart.count == count, count)
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
    axes: Axes, gap_cm: Floats, release_cm: Floats, region: np.ndarray, count: int
) -> None:
    """Write a count where its region is widest, if it is wide enough to hold it."""
    depth = ndimage.distance_transform_edt(np.pad(region, 1))[1:-1, 1:-1]
    row, column = np.unravel_index(int(depth.argmax()), depth.shape)
    widest = float(depth[row, column])
    if widest >= LETTER_CELLS:
        axes.text(
            float(gap_cm[column]),
            float(release_cm[row]),
            str(count),
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


def _ends(centres_cm: Floats) -> tuple[float, float]:
    """Outer borders of the first and the last cell."""
    half = (centres_cm[1] - centres_cm[0]) / 2
    return float(centres_cm[0] - half), float(centres_cm[-1] + half)


# ---- the planned trial as if it had been counted -------------------------------------------------
# Frame 0 is the release, and px are those of a picture that holds wall and burst and little else;
# places are counted from the wall. The paths are drawn between the frames as well.

POINTS = 1000
"""Of the paths, besides those at the collisions, between which they are smooth."""
BEYOND = 0.12
"""The picture begins this share of the burst before the first collision, and ends so after it."""


@dataclass(frozen=True)
class _Filmed:
    """A plan, and the scales at which it is drawn."""

    plan: Plan

    @cached_property
    def rate(self) -> float:
        """Rate of the planned camera in frames a second, or else the one needed."""
        camera = self.plan.camera
        return self.plan.framing.rate_needed_fps if camera is None else camera.capture_fps

    @cached_property
    def px_per_m(self) -> float:
        return self.plan.framing.ball_at_most_px / self.plan.request.ball_diameter_m

    def material(self) -> Material:
        """Make what the panels of a measured trial are drawn from."""
        setup = self.plan.motion.setup
        swing = Pendulum(
            rate_squared=setup.gravity_m_s2 / setup.heavy_thread_m / self.rate**2,
            centre_px=self.px_per_m * setup.heavy_rest_m,
        )
        return Material(self._result(), self._track(), None, swing)

    def _track(self) -> Track:
        """Sample the paths evenly, and at the collisions, where they have corners."""
        motion, burst = self.plan.motion, self.plan.burst
        margin_s = BEYOND * max(burst.last_s - burst.first_s, 1e-3)
        ends_s = max(0.0, burst.first_s - margin_s), burst.last_s + margin_s
        even = np.linspace(*ends_s, POINTS)
        times_s = np.unique(np.append(even, [c.time_s for c in motion.burst]))
        sample, still = motion.sample(times_s), np.zeros_like(times_s)
        half = motion.setup.ball_diameter_m / 2 * self.px_per_m
        ball_px, heavy_px = sample.ball_far_face_m * self.px_per_m, sample.heavy_face_m
        return Track(
            frame=times_s * self.rate,
            ball=BodyTrack(ball_px + half, still, -half, half),
            heavy=BodyTrack(heavy_px * self.px_per_m, still, 0.0, float(PICTURE_WIDTH_PX)),
            wall_side="left",
            ball_diameter_px=2 * half,
            line=MotionLine(0.0, 0.0, 0.0, upright=False),
            warnings=(),
        )

    def _result(self) -> TrialResult:
        """Say what the panels need to know of the trial."""
        collisions = self._collisions()
        return TrialResult(
            clip="plan",
            status="counted",
            reason=None,
            count=len(collisions),
            collisions=collisions,
            capture_fps=self.rate,
            millimetres_per_px=1e3 / self.px_per_m,
            mass_ratio=self.plan.request.mass_ratio,
        )

    def _collisions(self) -> tuple[Collision, ...]:
        """List the burst; a collision counts as seen if both its neighbours are far enough away."""
        plan, burst = self.plan, self.plan.motion.burst
        times_s = [bounce.time_s for bounce in burst]
        gaps_s = [math.inf, *(b - a for a, b in pairwise(times_s)), math.inf]
        camera_fps = plan.camera.capture_fps if plan.camera else plan.framing.rate_needed_fps
        clear_s = RESOLVED_FRAMES / camera_fps
        far_face_m = plan.motion.sample(np.array(times_s)).ball_far_face_m
        places = self.px_per_m * (far_face_m + plan.request.ball_diameter_m / 2)
        return tuple(
            Collision(
                number=number,
                kind=bounce.kind,
                frame=bounce.time_s * self.rate,
                frame_sigma=0.0,
                time_s=bounce.time_s,
                seen=min(gaps_s[number - 1], gaps_s[number]) >= clear_s,
                position_px=float(places[number - 1]),
                velocity_before=self._velocities(bounce.light_before_m_s, bounce.heavy_before_m_s),
                velocity_after=self._velocities(bounce.light_after_m_s, bounce.heavy_after_m_s),
            )
            for number, bounce in enumerate(burst, 1)
        )

    def _velocities(self, *speeds_m_s: float) -> Velocities:
        return Velocities(*(speed * self.px_per_m / self.rate for speed in speeds_m_s))


# ---- the files of a plan -----------------------------------------------------------------------

_CONTENTS: Mapping[str, Callable[[Plan, Figure], bytes]] = {
    "plan.json": lambda plan, _: json.dumps(plan_object(plan), indent=1).encode("ascii") + b"\n",
    "plan.csv": lambda plan, _: map_csv(plan.chart).encode("ascii"),
    "plan.html": lambda plan, _: plan_page(plan).encode("utf-8"),
    "plan.png": lambda _, figure: picture_bytes(figure, "png"),
    "plan.svg": lambda _, figure: picture_bytes(figure, "svg"),
}
NAMES = tuple(_CONTENTS)
"""Files of a plan, and above what each holds."""


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
    for name, content in _CONTENTS.items():
        with explained(outputs.folder / name):
            outputs.write(name, content(plan, figure))
        progress.advance(1)
    progress.finish()

"""The picture of a plan: its map, and the planned trial as a measured one is drawn."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from scipy import ndimage

from count_video.physics.engine import SimulatedCollision
from count_video.physics.flights import Pendulum as Swing
from count_video.physics.many import NO_COUNT
from count_video.physics.simulator import Motion, Sample
from count_video.planning.forecast import PICTURE_WIDTH_PX, RESOLVED_FRAMES, rate_needed_fps
from count_video.planning.plan import Plan
from count_video.planning.spread import Chart
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
    VERMILION,
    drawable,
    place_numbers,
    styled,
)
from count_video.reports.material import Luma, Material, Pendulum, SpaceTime
from count_video.reports.panels import draw_enlarged, draw_states, draw_whole, legend_handles
from count_video.reports.plan_text import plan_headline

IMAGE_PX = PICTURE_WIDTH_PX + 500
"""Length of the line of motion that is drawn: somewhat more than a picture holds."""
MOST_FRAMES = 6000
"""Frames of the image; a camera that takes more is drawn as one that takes these."""
POINTS_A_FRAME = 6
MOST_POINTS = 60_000
BEYOND = 0.12
"""The picture begins this share of the burst before the first collision, and ends so after it."""
WALL_DIAMETERS = 0.5
"""From the picture's border to the wall, in ball diameters."""
BACKDROP, WALL, BALL, CYLINDER = 70, 150, 225, 180
"""Brightness of what the image shows, 0 to 255."""
SIZE_INCHES = (16.0, 12.0)
RATES_FPS = (60, 120, 240, 480, 960, 2000, 4000, 8000, 16_000, 32_000, 64_000, 128_000)
"""Rates whose contours are drawn, where they lie on the map."""
OWN = "#8fd4b4"
"""Colour of the theory's count."""
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
    for row, column in np.ndindex((0, 0) if chart is None else chart.count.shape):
        assert chart is not None
        count, shortest = int(chart.count[row, column]), float(chart.shortest_s[row, column])
        known = count != NO_COUNT
        interval = f"{shortest:.6g}" if known and math.isfinite(shortest) else ""
        rate = f"{rate_needed_fps(shortest):.0f}" if known else ""
        place = f"{chart.gap_m[column]:.4f},{chart.release_m[row]:.4f}"
        lines.append(f"{place},{count if known else ''},{interval},{rate}")
    return "\n".join(lines) + "\n"


def _ends(centres_cm: Floats) -> tuple[float, float]:
    """Outer borders of the first and the last cell."""
    half = (centres_cm[1] - centres_cm[0]) / 2
    return float(centres_cm[0] - half), float(centres_cm[-1] + half)


# ---- the planned trial as if it had been filmed and counted ------------------------------------
# The lines of its tracks are drawn between the frames as well, as only a plan can; the image behind
# them is what the planned camera would show, frame by frame.


def planned_material(plan: Plan) -> Material:
    """Turn a plan into what the panels of a measured trial are drawn from.

    Frame 0 is the release; px are those of a picture that holds wall and burst and little else.
    """
    rate = drawn_fps(plan)
    px_per_m = plan.framing.ball_at_most_px / plan.request.ball_diameter_m
    frames = _shown_frames(plan, rate)
    points = _points(frames, [bounce.time_s * rate for bounce in plan.motion.burst])
    return Material(
        result=_result(plan, rate, px_per_m),
        track=_track(plan.motion, points, rate, px_per_m),
        space_time=SpaceTime(frames, _image(plan.motion, frames / rate, px_per_m)),
        pendulum=_pendulum(plan.motion, rate, px_per_m),
    )


def drawn_fps(plan: Plan) -> float:
    """Rate of the planned camera, or the one that is needed; less where that is too many frames."""
    camera = plan.camera
    wanted = plan.framing.rate_needed_fps if camera is None else camera.capture_fps
    burst = plan.burst
    return min(wanted, MOST_FRAMES / max(burst.last_s - burst.first_s, 1e-3))


def _shown_frames(plan: Plan, rate: float) -> Floats:
    """Whole frames from shortly before the first collision to the turn, shape (n,)."""
    burst = plan.burst
    margin_s = BEYOND * max(burst.last_s - burst.first_s, 1e-3)
    first = math.floor(max(0.0, burst.first_s - margin_s) * rate)
    return np.arange(first, math.ceil((burst.last_s + margin_s) * rate) + 1, dtype=np.float64)


def _points(frames: Floats, collisions: list[float]) -> Floats:
    """Frame coordinates at which the lines are drawn: the corners among them."""
    number = min(MOST_POINTS, POINTS_A_FRAME * len(frames))
    return np.unique(np.concatenate([np.linspace(frames[0], frames[-1], number), collisions]))


def _track(motion: Motion, points: Floats, rate: float, px_per_m: float) -> Track:
    sample = motion.sample(points / rate)
    half = motion.setup.ball_diameter_m / 2 * px_per_m
    wall = _wall_px(motion, px_per_m)
    ball = wall + px_per_m * sample.ball_far_face_m + half
    heavy = wall + px_per_m * sample.heavy_face_m
    still = np.zeros_like(points)
    return Track(
        frame=points,
        ball=BodyTrack(ball, still, -half, half),
        heavy=BodyTrack(heavy, still, 0.0, float(PICTURE_WIDTH_PX)),
        wall_side="left",
        ball_diameter_px=2 * half,
        line=MotionLine(0.0, 0.0, 0.0, upright=False),
        warnings=(),
    )


def _wall_px(motion: Motion, px_per_m: float) -> float:
    return WALL_DIAMETERS * motion.setup.ball_diameter_m * px_per_m


def _image(motion: Motion, times_s: Floats, px_per_m: float) -> Luma:
    """Draw the line of motion of each frame, shape (n, IMAGE_PX)."""
    sample: Sample = motion.sample(times_s)
    place_m = (np.arange(IMAGE_PX) - _wall_px(motion, px_per_m)) / px_per_m
    image = np.full((len(times_s), IMAGE_PX), BACKDROP, np.uint8)
    image[:, place_m < 0] = WALL
    far, near = sample.ball_far_face_m[:, None], sample.ball_near_face_m[:, None]
    image[(place_m >= far) & (place_m <= near)] = BALL
    image[place_m >= sample.heavy_face_m[:, None]] = CYLINDER
    return image


def _pendulum(motion: Motion, rate: float, px_per_m: float) -> Pendulum:
    setup = motion.setup
    swing = Swing.from_thread(setup.heavy_thread_m, setup.gravity_m_s2, 0.0, 0.0)
    centre = _wall_px(motion, px_per_m) + px_per_m * setup.heavy_rest_m
    return Pendulum((swing.natural_rad_s / rate) ** 2, centre)


def _result(plan: Plan, rate: float, px_per_m: float) -> TrialResult:
    burst = plan.motion.burst
    collisions = _collisions(plan, rate, px_per_m)
    seen = sum(collision.seen for collision in collisions)
    return TrialResult(
        clip="plan",
        status="counted",
        reason=None,
        count=len(burst),
        seen=seen,
        between_frames=len(burst) - seen,
        probability={},
        count_after_burst=0,
        collisions=collisions,
        capture_fps=rate,
        capture_fps_source="option",
        frames_decoded=None,
        frames_promised=None,
        wall_side="left",
        ball_diameter_px=plan.framing.ball_at_most_px,
        millimetres_per_px=1e3 / px_per_m,
        pi_low=None,
        pi_high=None,
        mass_ratio=plan.request.mass_ratio,
        warnings=(),
    )


def _collisions(plan: Plan, rate: float, px_per_m: float) -> tuple[Collision, ...]:
    """List the burst; a collision counts as seen if both its neighbours are far enough away."""
    burst = plan.motion.burst
    frames = [bounce.time_s * rate for bounce in burst]
    gaps = [math.inf, *(later - earlier for earlier, later in pairwise(frames)), math.inf]
    camera = plan.camera.capture_fps if plan.camera else plan.framing.rate_needed_fps
    clear = RESOLVED_FRAMES * rate / camera
    places = plan.motion.sample(np.array([bounce.time_s for bounce in burst])).ball_far_face_m
    half_m = plan.request.ball_diameter_m / 2
    wall = _wall_px(plan.motion, px_per_m)
    return tuple(
        Collision(
            number=number,
            kind=bounce.kind,
            frame=frames[number - 1],
            frame_sigma=0.0,
            time_s=bounce.time_s,
            seen=min(gaps[number - 1], gaps[number]) >= clear,
            position_px=wall + px_per_m * (float(places[number - 1]) + half_m),
            velocity_before=_velocities(bounce, px_per_m / rate, before=True),
            velocity_after=_velocities(bounce, px_per_m / rate, before=False),
        )
        for number, bounce in enumerate(burst, 1)
    )


def _velocities(bounce: SimulatedCollision, factor: float, *, before: bool) -> Velocities:
    if before:
        return Velocities(bounce.light_before_m_s * factor, bounce.heavy_before_m_s * factor)
    return Velocities(bounce.light_after_m_s * factor, bounce.heavy_after_m_s * factor)

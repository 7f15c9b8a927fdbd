"""The panels of the picture of a trial, measured or planned: each drawn into given axes.

The phase circle's coordinates are those of ``material.States``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Wedge
from matplotlib.ticker import MaxNLocator

from count_video.physics.theory import Mass, collision_count, state_points, theta_rad
from count_video.planning.comparison import expected_counts
from count_video.records import CollisionKind, Floats
from count_video.reports.drawing import (
    BALL,
    BARS,
    BLUE,
    GREEN,
    GREY,
    HEAVY,
    MARKS,
    PAPER,
    SKY_BLUE,
    VERMILION,
    YELLOW,
    number_marks,
)
from count_video.reports.material import Material, Range
from count_video.reports.words import counts_words, shortened

TIME = "time"
"""Group of the panels in which time runs to the right."""
MOST_POINTS = 700
"""More points than this cannot be seen one by one; the phase circle is then drawn alone."""
SHOWN_SHARE = 0.05
"""Of the energy: less than that hardly shows beside the circle's line."""


def draw_whole(axes: Axes, material: Material) -> None:
    """Draw the whole trial, and a frame around what another panel shows enlarged."""
    draw_space_time(axes, material, material.shown_frames)
    numbered = {c.number for c in material.result.collisions}
    walled = material.result.wall_side is not None
    title = "Space and time, the wall at the bottom" if walled else "Space and time"
    if material.is_dense:
        low, high = material.dense_frames
        frame = YELLOW if material.lines else "black"
        axes.axvspan(low, high, fill=False, edgecolor=frame, linewidth=2.0)
        title += "; the framed part is enlarged"
        numbered -= {c.number for c in [c for c in material.burst if low <= c.frame <= high][1:-1]}
    axes.set_title(title)
    _number_and_label(axes, material, numbered, size=9)


def draw_enlarged(axes: Axes, material: Material) -> None:
    """Draw the part of the trial in which the collisions follow each other fastest."""
    low, high = material.dense_frames
    draw_space_time(axes, material, (low, high))
    shown = [c.number for c in material.result.collisions if low <= c.frame <= high]
    axes.set_title(f"Enlarged: collisions {shown[0]} to {shown[-1]}")
    _number_and_label(axes, material, shown[:: -(-len(shown) // 60)], size=10)


def draw_space_time(axes: Axes, material: Material, frames: Range, size: float = 52) -> None:
    """Draw image, tracks and marks of a stretch of frames; ``size`` is that of the marks."""
    places, track = material.shown_places(frames), material.track
    low, high = material.ball_edges_px
    face = None if track.heavy is None else track.heavy.position_px
    if material.lines:
        _draw_image(axes, material, frames, places)
    elif face is not None:
        axes.axhspan(places[0], 0.0, color=GREY, alpha=0.4, linewidth=0)
        axes.fill_between(track.frame, low, high, color=BALL, alpha=0.35, linewidth=0)
        axes.fill_between(track.frame, face, places[1], color=HEAVY, alpha=0.35, linewidth=0)
    axes.plot(track.frame, low, color=BALL, linewidth=1.4, gid="ball", label="ball (its two edges)")
    axes.plot(track.frame, high, color=BALL, linewidth=1.4, gid="ball")
    if face is not None:
        label = f"{_heavy_name(material)} (its face)"
        style: Any = {"linewidth": 1.8, "gid": "heavy", "label": label}
        axes.plot(track.frame, face, color=HEAVY, **style)
    _draw_marks(axes, material, frames, size)
    axes.set_xlim(*frames)
    axes.set_ylim(*places[:: material.outward])


def _draw_image(axes: Axes, material: Material, frames: Range, places: Range) -> None:
    """Draw the lines of motion side by side; copies that were left out get the line before them."""
    image, begins = np.array(material.lines), material.track.frame[: len(material.lines)] - 0.5
    inside = slice(*np.searchsorted(begins, (frames[0] - 1.0, frames[1] + 1.0)))
    low, high = np.clip((round(places[0]), round(places[1])), 0, image.shape[1])
    shown = image[inside, low:high]
    if shown.size:
        darkest, brightest = np.percentile(shown, (1.0, 99.5))
        ends = np.append(begins[inside], begins[inside][-1] + 1.0), np.arange(low, high + 1) - 0.5
        greys: Any = {"cmap": "gray", "vmin": darkest, "vmax": max(brightest, darkest + 1)}
        axes.pcolorfast(*ends, shown.T, zorder=0, **greys)


def _draw_marks(axes: Axes, material: Material, frames: Range, size: float) -> None:
    """Mark the collisions; filled where they were seen, grey after the burst."""
    alike: dict[tuple[CollisionKind, bool, bool], list[tuple[float, float]]] = defaultdict(list)
    for c in material.result.collisions:
        if frames[0] <= c.frame <= frames[1]:
            counts = c.number <= material.result.burst_size
            alike[c.kind, c.seen, counts].append((c.frame, material.contact_px(c)))
    for (kind, seen, counts), places in alike.items():
        colour = MARKS[kind].colour if counts else GREY
        label = f"collision {MARKS[kind].words}{'' if seen else ', inferred'}"
        x, y = zip(*places, strict=True)
        axes.scatter(
            x,
            y,
            s=size,
            marker=MARKS[kind].shape,
            facecolor=colour if seen else "white",
            edgecolor="white" if seen else colour,
            linewidth=(1.0 if seen else 2.2) * min(1.0, size / 30),
            zorder=4,
            gid="collision" if counts else "beyond",
            label=label if counts else f"{label}, after the burst",
        )


def _number_and_label(
    axes: Axes, material: Material, numbers: Collection[int], *, size: float
) -> None:
    """Write the numbers of some collisions, and name the axes.

    Contacts of the bodies are numbered towards the heavy body, those with the wall towards it, and
    those of a body alone on its own side. Real units stand on the far sides where they are known;
    the wall side of the ball's path is 0.
    """
    track, outward = material.track, material.outward
    alone = track.heavy is None
    marks = [
        (str(c.number), (c.frame, material.contact_px(c)), (0.0, up))
        for c in material.result.collisions
        for up in [c.push * outward if alone else 1.0 if c.kind == "bodies" else -1.0]
        if c.number in numbers
    ]
    number_marks(axes, marks, size=size)
    _count_frames(axes, material)
    axes.set_ylabel("position along the line (px)")
    (low, high), mm_a_px = material.ball_edges_px, material.result.millimetres_per_px
    wall = float(np.nanmin(low) if outward > 0 else np.nanmax(high))
    if mm_a_px:
        side = axes.secondary_yaxis("right", functions=_linear(outward * mm_a_px, wall))
        walled = material.result.wall_side is not None
        side.set_ylabel("from the wall (mm)" if walled else "way (mm)")
    if material.result.capture_fps:
        ms_a_frame = 1000.0 / material.result.capture_fps
        top = axes.secondary_xaxis("top", functions=_linear(ms_a_frame, 0.0))
        top.set_xlabel("time (ms)", loc="right", labelpad=2)


def _count_frames(axes: Axes, material: Material) -> None:
    """Let time run to the right, in whole frames."""
    axes.set_gid(TIME)
    axes.set_xlabel("frame" if material.lines else "frame, from the release")
    axes.locator_params("x", integer=True)


def _linear(factor: float, zero: float) -> Any:
    """Give y = factor (x - zero) and its inverse."""
    return lambda x: factor * (np.asarray(x) - zero), lambda y: np.asarray(y) / factor + zero


def draw_velocities(axes: Axes, material: Material) -> None:
    """Draw the velocities where the collisions lie densest; positive is away from the wall.

    Steps from frame to frame that hold a collision are left out.
    """
    frames = material.dense_frames if material.is_dense else material.shown_frames
    collisions, track = material.result.collisions, material.track
    speed, unit_name = material.speed_scale
    unit, times = speed * material.outward, np.array([c.frame for c in collisions])
    clear = np.diff(np.searchsorted(times, track.frame)) == 0
    middle = (track.frame[1:] + track.frame[:-1]) / 2
    sides = [side for c in collisions for side in (c.velocity_before, c.velocity_after)]
    when = np.repeat(times, 2)
    shown = [] if sides else [0.0]
    for name, label, colour, body in (
        ("ball", "ball", BALL, track.ball),
        ("heavy", _heavy_name(material), HEAVY, track.heavy),
    ):
        if body is None:
            continue
        step = np.diff(body.position_px) / np.diff(track.frame) * unit
        axes.plot(middle[clear], step[clear], ".", color=colour, markersize=5, alpha=0.55)
        shown += [] if sides else step[np.isfinite(step)].tolist()
        fitted = np.array([getattr(side, f"{name}_px_frame") for side in sides]) * unit
        sigma = np.array([getattr(side, f"{name}_sigma_px_frame") for side in sides]) * abs(unit)
        drawn = axes.errorbar(when, fitted, sigma, color=colour, lw=2.0, label=label, **BARS)
        drawn.lines[0].set_gid(label)
        inside = (when >= frames[0]) & (when <= frames[1]) & np.isfinite(fitted)
        shown += fitted[inside].tolist()
    for collision in collisions:
        colour = MARKS[collision.kind].colour
        axes.axvline(collision.frame, color=colour, linewidth=0.8, alpha=0.45, zorder=0)
    axes.axhline(0.0, color="black", linewidth=0.8)
    beside = 0.12 * float(np.ptp(shown)) or 1.0
    _count_frames(axes, material)
    axes.set(xlim=frames, ylim=(min(shown) - beside, max(shown) + beside))
    axes.set_ylabel(f"velocity ({unit_name})\n{_upward(material)} is up")
    axes.set_title("Velocities: dots from frame to frame, bars fitted at collisions, lines between")


def _heavy_name(material: Material) -> str:
    """Name the body that is not the ball: without a wall it may be another ball."""
    return "other body" if material.result.wall_side is None else "cylinder"


def _upward(material: Material) -> str:
    """Which way positive velocities lead: along the image where there is no wall."""
    if material.result.wall_side is not None:
        return "away from the wall"
    ways = ("upward", "downward") if material.result.upright else ("to the left", "to the right")
    return ways[material.outward > 0]


# ---- states and energies after each collision --------------------------------------------------


def draw_phase_circle(
    axes: Axes, heavy: Mass, light: Mass, *, colour: str = VERMILION, alpha: float = 0.7
) -> Floats:
    """Draw the theory into a panel and return its state points, shape (n, 2); n = 0 if too many.

    The momentum lines, of this colour and opacity, have slope -sqrt(M/m); the stopping region lies
    between the V1 axis and the line of slope sqrt(m/M) through the centre.
    """
    theta = theta_rad(heavy, light)
    opening = float(np.degrees(theta))
    axes.add_patch(Wedge((0, 0), 1.0, 0.0, opening, color=SKY_BLUE, alpha=0.35, gid="stopping"))
    axes.plot([0, 1.12 * np.cos(theta)], [0, 1.12 * np.sin(theta)], color=SKY_BLUE, linewidth=1.2)
    axes.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor="black", linewidth=1.3, gid="circle"))
    axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=0)
    axes.axvline(0.0, color=GREY, linewidth=0.7, zorder=0)
    few = collision_count(heavy, light) < MOST_POINTS
    states = state_points(heavy, light) if few else np.empty((0, 2))
    for step in range(1, len(states)):
        # Momentum lines slant (odd steps), mirrors at the wall are upright and dashed (even ones).
        style: Any = {"gid": "mirror", "color": GREY, "linestyle": (0, (3, 2))}
        if step % 2:
            style = {"gid": "momentum", "color": colour}
        axes.plot(*states[step - 1 : step + 1].T, zorder=1, linewidth=1.0, alpha=alpha, **style)
    axes.set(xlim=(-1.24, 1.24), ylim=(-1.24, 1.24), aspect="equal", anchor="N")
    axes.text(0.5, -0.03, "stops here", ha="center", va="top", fontsize=9, color=BLUE, bbox=PAPER)
    axes.set_xlabel("V₁ = √M v₁  (in units of the first state)")
    axes.set_ylabel("V₂ = √m v₂")
    return states


def draw_states(axes: Axes, material: Material) -> None:
    """Draw the phase circle: theory and measurement; a sentence where the ratio is not known."""
    origin = "measured" if material.lines else "planned"
    axes.set_title(f"Phase circle: theory (lines) and {origin} states")
    states, ratio = material.states, material.result.mass_ratio
    expected = expected_counts(material.result)
    if states is None or ratio is None or expected is None:
        _ask_for_masses(axes)
        return
    draw_phase_circle(axes, ratio, 1, colour=GREY, alpha=0.55)
    x, y = states.scaled
    if np.isfinite(states.sigma).any():
        x_sigma, y_sigma = states.sigma
        axes.errorbar(x, y, y_sigma, x_sigma, fmt="none", ecolor=GREY, zorder=3, **BARS)
    axes.scatter(x[0], y[0], s=64, marker="^", color="black", gid="state", zorder=4)
    for kind, mark in MARKS.items():
        chosen = [k for k, c in enumerate(material.burst, 1) if c.kind == kind]
        style: Any = {"s": 49, "marker": mark.shape, "color": mark.colour, "edgecolor": "white"}
        axes.scatter(x[chosen], y[chosen], gid="state", zorder=4, **style)
    step = 1 if len(x) <= 45 else 5
    places = list(enumerate(states.scaled.T.tolist()))[::step]
    number_marks(axes, [(str(number), (x, y), (x, y)) for number, (x, y) in places], size=9)
    words = f"M : m = {shortened(ratio)} : 1\ntheory counts {counts_words(*expected.free)}"
    axes.text(0.0, 0.06, words, ha="center", va="bottom", fontsize=11, bbox=PAPER)
    swing = states.swing_energy
    if swing is not None:
        whole = (states.scaled**2).sum(axis=0) + swing
        lost = whole[-1] < (1 - SHOWN_SHARE) * whole[0]
        where = ["energy lost"] * bool(lost)
        where += ["energy in the swing"] * bool((swing - swing[0]).max() > SHOWN_SHARE)
        if where:
            words = "inside the circle: " + "\nand ".join(where)
            axes.text(0.0, -0.12, words, ha="center", va="top", fontsize=9, bbox=PAPER)


def _ask_for_masses(axes: Axes) -> None:
    words = "needs the mass ratio:\ngive --masses HEAVY LIGHT"
    axes.set_axis_off()
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center", fontsize=12)


def draw_energy(axes: Axes, material: Material) -> None:
    """Draw each share of the energy against the collision's number, in % of the first state's.

    Heights count from where each body hangs at rest, as in ``energy_kept``.
    Uncertainties are propagated to first order (JCGM 100:2008, 5.1.2): that of a square is twice
    the value times its own. The two bodies' are taken as independent.
    """
    axes.set_title("Energy after each collision; bars: uncertainty")
    states = material.states
    if states is None:
        _ask_for_masses(axes)
        return
    swing_energy = states.swing_energy
    raised = np.zeros(states.scaled.shape[1]) if swing_energy is None else swing_energy
    first = 1.0 + raised[0]
    moving, swing = 100 * states.scaled**2 / first, 100 * raised / first
    sigma = 200 * np.abs(states.scaled) * states.sigma / first
    known = swing_energy is not None
    whole = "all together" if known else "both together; the swing is not known"
    for label, shape, colour, energy, bar in (
        ("cylinder, moving", "s", HEAVY, moving[0], sigma[0]),
        ("ball, moving", "o", BALL, moving[1], sigma[1]),
        *([("raised on the threads", "^", GREEN, swing, 0.0 * swing)] if known else []),
        (whole, "D", "black", moving.sum(axis=0) + swing, np.hypot(*sigma)),
    ):
        style: Any = {"fmt": f"{shape}-", "color": colour, "ms": 4, "label": label, **BARS}
        drawn = axes.errorbar(np.arange(len(energy)), energy, bar, **style)
        drawn.lines[0].set_gid("total" if label == whole else label)
    axes.axhline(100.0, color="black", linewidth=0.7, linestyle=":")
    axes.set_xlabel("after collision number (0: before the first)")
    axes.set_ylabel("energy (% of the first state's)")
    axes.set_ylim(0.0, 138.0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(loc="upper center", ncols=2, fontsize=9)


Draw = Callable[[Axes, Material], None]
PANELS: Mapping[str, Draw] = {
    "space-time": draw_whole,
    "enlarged": draw_enlarged,
    "velocities": draw_velocities,
    "phase-circle": draw_states,
    "energy": draw_energy,
}
"""The panels of a trial, by the names of their own files."""


def panels_of(material: Material) -> dict[str, Draw]:
    """Choose the panels that show something of a clip.

    Nothing is enlarged where no collisions lie close together, and only a ball and a cylinder that
    collide at a wall have the states and energies of the theory; their velocities must be of one
    unit.
    """
    result = material.result
    at_wall = material.track.heavy is not None and result.wall_side is not None
    states = at_wall and result.even_rate and bool(material.burst)
    shown = {"enlarged": material.is_dense, "phase-circle": states, "energy": states}
    return {name: draw for name, draw in PANELS.items() if shown.get(name, True)}

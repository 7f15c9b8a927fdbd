"""The panels of the picture of a trial, measured or planned: each drawn into axes of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from count_video.records import Collision, Floats
from count_video.reports.drawing import (
    BALL,
    BARS,
    BLACK,
    GREY,
    HEAVY,
    MARKS,
    WHITE,
    YELLOW,
    number_marks,
)
from count_video.reports.material import (
    Material,
    Range,
    SpaceTime,
    ball_edges_px,
    contact_px,
    scale_of,
)

TIME = "time"
"""Group of the panels in which time runs to the right."""
ENLARGED_SHARE = 0.5
"""What takes more than this share of the whole is not worth a panel that enlarges it."""
MOST_NUMBERS = 60
"""Where there are more collisions, not every one is numbered in the enlarged panel either."""
BRIGHTEST_PERCENTILES = (1.0, 99.5)


# ---- space and time ---------------------------------------------------------------------------


def worth_enlarging(material: Material) -> bool:
    """Return whether the burst has a part that is dense, and more than that part."""
    (low, high), (first, last) = material.dense_frames, material.shown_frames
    return high - low < ENLARGED_SHARE * (last - first)


def draw_whole(axes: Axes, material: Material) -> None:
    """Draw the whole trial, and a frame around what another panel shows enlarged."""
    draw_space_time(axes, material, material.shown_frames)
    _label(axes, material)
    axes.set_title("Space and time, the wall at the bottom")
    inside: Sequence[int] = ()
    if worth_enlarging(material):
        low, high = material.dense_frames
        frame = BLACK if material.space_time is None else YELLOW
        axes.axvspan(low, high, fill=False, edgecolor=frame, linewidth=2.0)
        axes.set_title("Space and time, the wall at the bottom; the framed part is enlarged")
        inside = [c.number for c in material.burst if low <= c.frame <= high][1:-1]
    _number(axes, material, material.result.collisions, size=9, but=inside)


def draw_enlarged(axes: Axes, material: Material) -> None:
    """Draw the part of the trial in which the collisions follow each other fastest."""
    low, high = material.dense_frames
    draw_space_time(axes, material, (low, high))
    _label(axes, material)
    shown = [c for c in material.result.collisions if low <= c.frame <= high]
    step = -(-len(shown) // MOST_NUMBERS)
    few = [c.number for place, c in enumerate(shown) if place % step]
    _number(axes, material, shown, size=10, but=few)
    axes.set_title(f"Enlarged: collisions {shown[0].number} to {shown[-1].number}")


def draw_space_time(axes: Axes, material: Material, frames: Range, size: float = 52) -> None:
    """Draw image, tracks and marks of a stretch of frames; ``size`` is that of the marks."""
    places, track = material.shown_places(frames), material.track
    if material.space_time is not None:
        _draw_image(axes, material.space_time, frames, places)
    elif track.heavy is not None:
        axes.axhspan(places[0], 0.0, color=GREY, alpha=0.4, linewidth=0)
        axes.fill_between(track.frame, *ball_edges_px(track), color=BALL, alpha=0.35, linewidth=0)
        face = track.heavy.position_px
        axes.fill_between(track.frame, face, places[1], color=HEAVY, alpha=0.35, linewidth=0)
    for edge in ball_edges_px(track):
        axes.plot(track.frame, edge, color=BALL, linewidth=1.4, gid="ball")
    if track.heavy is not None:
        axes.plot(track.frame, track.heavy.position_px, color=HEAVY, linewidth=1.8, gid="heavy")
    for c in material.result.collisions:
        if frames[0] <= c.frame <= frames[1]:
            _mark(axes, material, c, size)
    axes.set_xlim(*frames)
    axes.set_ylim(*places[:: material.outward])


def _draw_image(axes: Axes, filmed: SpaceTime, frames: Range, places: Range) -> None:
    rows, image = filmed.frame, filmed.image
    # Frames that were left out (copies) get the row before them: the image's time stays even.
    wanted = np.arange(np.floor(frames[0]), np.ceil(frames[1]) + 1)
    wanted = wanted[(wanted >= rows[0]) & (wanted <= rows[-1])]
    if wanted.size == 0:
        return
    low = max(0, int(np.floor(places[0])))
    high = min(image.shape[1], int(np.ceil(places[1])) + 1)
    piece = image[np.searchsorted(rows, wanted, side="right") - 1, low:high].T
    darkest, brightest = np.percentile(piece, BRIGHTEST_PERCENTILES)
    axes.imshow(
        piece,
        cmap="gray",
        vmin=darkest,
        vmax=max(brightest, darkest + 1),
        aspect="auto",
        origin="lower",
        extent=(wanted[0] - 0.5, wanted[-1] + 0.5, low - 0.5, high - 0.5),
        interpolation="nearest",
        zorder=0,
    )


def _mark(axes: Axes, material: Material, collision: Collision, size: float) -> None:
    """Draw one collision; filled where it was seen, grey after the burst."""
    mark = MARKS[collision.kind]
    inside = collision in material.burst
    colour = mark.colour if inside else GREY
    axes.scatter(
        collision.frame,
        contact_px(collision, material.track),
        s=size,
        marker=mark.shape,
        facecolor=colour if collision.seen else WHITE,
        edgecolor=WHITE if collision.seen else colour,
        linewidth=(1.0 if collision.seen else 2.2) * min(1.0, size / 30),
        zorder=4,
        gid="collision" if inside else "beyond",
    )


def _number(
    axes: Axes,
    material: Material,
    shown: Sequence[Collision],
    *,
    size: float,
    but: Sequence[int],
) -> None:
    """Write the numbers of the collisions shown, but for some.

    Contacts of the bodies are numbered towards the heavy body, those with the wall towards it.
    """
    two = material.track.heavy is not None
    number_marks(
        axes,
        np.array([(c.frame, contact_px(c, material.track)) for c in shown]).reshape(-1, 2),
        ["" if c.number in but else str(c.number) for c in shown],
        np.array([(0.0, 1.0 if (c.kind == "bodies") == two else -1.0) for c in shown]),
        size=size,
    )


def _label(axes: Axes, material: Material) -> None:
    """Name the axes, with real units on the far sides where they are known.

    The wall side of the ball's path is 0.
    """
    axes.set_gid(TIME)
    axes.set_ylabel("position along the line (px)")
    axes.set_xlabel("frame")
    scale = scale_of(material.result)
    edges = ball_edges_px(material.track)
    wall = float(np.nanmin(edges[0]) if material.outward > 0 else np.nanmax(edges[1]))
    factor = material.outward * scale.length
    if scale.length_unit != "px":
        side = axes.secondary_yaxis("right", functions=_linear(factor, -wall * factor))
        side.set_ylabel(f"from the wall ({scale.length_unit})")
    if scale.time_unit != "frame":
        top = axes.secondary_xaxis("top", functions=_linear(scale.time, 0.0))
        top.set_xlabel(f"time ({scale.time_unit})", loc="right", labelpad=2)


def _linear(factor: float, shift: float) -> Any:
    """Give y = factor x + shift and its inverse."""
    return lambda x: np.multiply(x, factor) + shift, lambda y: np.subtract(y, shift) / factor


def legend_handles(material: Material) -> list[Line2D]:
    """Say what the lines and marks of all panels mean."""
    handles = [Line2D([], [], color=BALL, linewidth=3, label="ball (its two edges)")]
    if material.track.heavy is not None:
        handles.append(Line2D([], [], color=HEAVY, linewidth=3, label="cylinder (its face)"))
    collisions = material.result.collisions
    marks = [
        (mark.shape, mark.colour, f"collision {mark.words}", True)
        for kind, mark in MARKS.items()
        if any(c.kind == kind for c in collisions)
    ]
    if not all(c.seen for c in collisions):
        marks.append(("o", BLACK, "hollow: inferred between frames", False))
    if len(collisions) > len(material.burst):
        marks.append(("o", GREY, "after the burst", True))
    for shape, colour, label, filled in marks:
        style: Any = {"mfc": colour if filled else WHITE, "mec": WHITE if filled else colour}
        width = 1.0 if filled else 2.0
        handles.append(Line2D([], [], ls="", marker=shape, ms=8, mew=width, label=label, **style))
    return handles


# ---- velocities -------------------------------------------------------------------------------


def draw_velocities(axes: Axes, material: Material) -> None:
    """Draw the velocities where the collisions lie densest; positive is away from the wall."""
    frames = material.dense_frames if worth_enlarging(material) else material.shown_frames
    scale, collisions = scale_of(material.result), material.result.collisions
    unit = scale.speed * material.outward
    bodies = [("ball", BALL, material.track.ball)]
    if material.track.heavy is not None:
        bodies.append(("cylinder", HEAVY, material.track.heavy))
    known: list[Floats] = []
    for label, colour, body in bodies:
        _draw_steps(axes, material, body.position_px, colour, unit)
        name = "ball" if label == "ball" else "heavy"
        sides = [side for c in collisions for side in (c.velocity_before, c.velocity_after)]
        fitted = np.array([getattr(side, f"{name}_px_frame") for side in sides]) * unit
        sigma = np.array([getattr(side, f"{name}_sigma_px_frame") for side in sides]) * abs(unit)
        times = np.repeat([c.frame for c in collisions], 2)
        drawn = axes.errorbar(times, fitted, sigma, color=colour, lw=2.0, label=label, **BARS)
        drawn.lines[0].set_gid(label)
        known.append(fitted[(times >= frames[0]) & (times <= frames[1]) & np.isfinite(fitted)])
    for collision in collisions:
        colour = MARKS[collision.kind].colour
        axes.axvline(collision.frame, color=colour, linewidth=0.8, alpha=0.45, zorder=0)
    axes.axhline(0.0, color=BLACK, linewidth=0.8)
    values = np.concatenate(known) if np.concatenate(known).size else np.array([-1.0, 1.0])
    beside = 0.12 * float(np.ptp(values)) or 1.0
    axes.set_gid(TIME)
    axes.set_xlim(*frames)
    axes.set_ylim(float(values.min()) - beside, float(values.max()) + beside)
    axes.set_xlabel("frame")
    axes.set_ylabel(f"velocity ({scale.speed_unit})\naway from the wall is up")
    axes.set_title("Velocities: dots from frame to frame, lines and bars fitted between collisions")


def _draw_steps(axes: Axes, material: Material, place_px: Floats, colour: str, unit: float) -> None:
    """Draw the velocity from each frame to the next, without steps that hold a collision."""
    frame = material.track.frame
    step = np.diff(place_px) / np.diff(frame) * unit
    times = np.array([c.frame for c in material.result.collisions])
    clear = np.searchsorted(times, frame[1:]) == np.searchsorted(times, frame[:-1])
    middle = (frame[1:] + frame[:-1]) / 2
    axes.plot(middle[clear], step[clear], ".", color=colour, markersize=5, alpha=0.55)

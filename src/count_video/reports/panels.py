"""Panels over time of the picture of a trial, measured or planned: each drawn into given axes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from count_video.records import CollisionKind
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
    Point,
    Range,
    SpaceTime,
    ball_edges_px,
    contact_px,
    scale_of,
)

TIME = "time"
"""Group of the panels in which time runs to the right."""
MOST_NUMBERS = 60
"""Where there are more collisions, not every one is numbered in the enlarged panel either."""
BRIGHTEST_PERCENTILES = (1.0, 99.5)


def draw_whole(axes: Axes, material: Material) -> None:
    """Draw the whole trial, and a frame around what another panel shows enlarged."""
    draw_space_time(axes, material, material.shown_frames)
    numbered = {c.number for c in material.result.collisions}
    title = "Space and time, the wall at the bottom"
    if material.is_dense:
        low, high = material.dense_frames
        frame = BLACK if material.space_time is None else YELLOW
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
    _number_and_label(axes, material, shown[:: -(-len(shown) // MOST_NUMBERS)], size=10)


def draw_space_time(axes: Axes, material: Material, frames: Range, size: float = 52) -> None:
    """Draw image, tracks and marks of a stretch of frames; ``size`` is that of the marks."""
    places, track = material.shown_places(frames), material.track
    low, high = ball_edges_px(track)
    face = None if track.heavy is None else track.heavy.position_px
    if material.space_time is not None:
        _draw_image(axes, material.space_time, frames, places)
    elif face is not None:
        axes.axhspan(places[0], 0.0, color=GREY, alpha=0.4, linewidth=0)
        axes.fill_between(track.frame, low, high, color=BALL, alpha=0.35, linewidth=0)
        axes.fill_between(track.frame, face, places[1], color=HEAVY, alpha=0.35, linewidth=0)
    axes.plot(track.frame, low, color=BALL, linewidth=1.4, gid="ball", label="ball (its two edges)")
    axes.plot(track.frame, high, color=BALL, linewidth=1.4, gid="ball")
    if face is not None:
        style: Any = {"linewidth": 1.8, "gid": "heavy", "label": "cylinder (its face)"}
        axes.plot(track.frame, face, color=HEAVY, **style)
    _draw_marks(axes, material, frames, size)
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


def _draw_marks(axes: Axes, material: Material, frames: Range, size: float) -> None:
    """Mark the collisions; filled where they were seen, grey after the burst."""
    alike: dict[tuple[CollisionKind, bool, bool], list[Point]] = defaultdict(list)
    for c in material.result.collisions:
        if frames[0] <= c.frame <= frames[1]:
            counts = c.number <= material.result.burst_size
            alike[c.kind, c.seen, counts].append((c.frame, contact_px(c, material.track)))
    for (kind, seen, counts), places in alike.items():
        colour = MARKS[kind].colour if counts else GREY
        x, y = zip(*places, strict=True)
        axes.scatter(
            x,
            y,
            s=size,
            marker=MARKS[kind].shape,
            facecolor=colour if seen else WHITE,
            edgecolor=WHITE if seen else colour,
            linewidth=(1.0 if seen else 2.2) * min(1.0, size / 30),
            zorder=4,
            gid="collision" if counts else "beyond",
            label=f"collision {MARKS[kind].words}{'' if seen else ', inferred'}"
            f"{'' if counts else ', after the burst'}",
        )


def _number_and_label(
    axes: Axes, material: Material, numbers: Collection[int], *, size: float
) -> None:
    """Write the numbers of some collisions, and name the axes.

    Contacts of the bodies are numbered towards the heavy body, those with the wall towards it. Real
    units stand on the far sides where they are known; the wall side of the ball's path is 0.
    """
    track, outward = material.track, material.outward
    outer = 1.0 if track.heavy is not None else -1.0
    marks = [
        (str(c.number), (c.frame, contact_px(c, track)), (0.0, up))
        for c in material.result.collisions
        for up in [outer if c.kind == "bodies" else -outer]
        if c.number in numbers
    ]
    number_marks(axes, marks, size=size)
    axes.set_gid(TIME)
    axes.set_ylabel("position along the line (px)")
    axes.set_xlabel("frame")
    scale, (low, high) = scale_of(material.result), ball_edges_px(track)
    wall = float(np.nanmin(low) if outward > 0 else np.nanmax(high))
    if scale.length_unit != "px":
        side = axes.secondary_yaxis("right", functions=_linear(outward * scale.length, wall))
        side.set_ylabel(f"from the wall ({scale.length_unit})")
    if scale.time_unit != "frame":
        top = axes.secondary_xaxis("top", functions=_linear(scale.time, 0.0))
        top.set_xlabel(f"time ({scale.time_unit})", loc="right", labelpad=2)


def _linear(factor: float, zero: float) -> Any:
    """Give y = factor (x - zero) and its inverse."""
    return lambda x: factor * (np.asarray(x) - zero), lambda y: np.asarray(y) / factor + zero


def draw_velocities(axes: Axes, material: Material) -> None:
    """Draw the velocities where the collisions lie densest; positive is away from the wall.

    Steps from frame to frame that hold a collision are left out.
    """
    frames = material.dense_frames if material.is_dense else material.shown_frames
    scale, collisions, track = scale_of(material.result), material.result.collisions, material.track
    unit, times = scale.speed * material.outward, np.array([c.frame for c in collisions])
    clear = np.diff(np.searchsorted(times, track.frame)) == 0
    middle = (track.frame[1:] + track.frame[:-1]) / 2
    sides = [side for c in collisions for side in (c.velocity_before, c.velocity_after)]
    when = np.repeat(times, 2)
    shown = [-1.0, 1.0] if not sides else []
    for name, label, colour, body in (
        ("ball", "ball", BALL, track.ball),
        ("heavy", "cylinder", HEAVY, track.heavy),
    ):
        if body is None:
            continue
        step = np.diff(body.position_px) / np.diff(track.frame) * unit
        axes.plot(middle[clear], step[clear], ".", color=colour, markersize=5, alpha=0.55)
        fitted = np.array([getattr(side, f"{name}_px_frame") for side in sides]) * unit
        sigma = np.array([getattr(side, f"{name}_sigma_px_frame") for side in sides]) * abs(unit)
        drawn = axes.errorbar(when, fitted, sigma, color=colour, lw=2.0, label=label, **BARS)
        drawn.lines[0].set_gid(label)
        inside = (when >= frames[0]) & (when <= frames[1]) & np.isfinite(fitted)
        shown += fitted[inside].tolist()
    for collision in collisions:
        colour = MARKS[collision.kind].colour
        axes.axvline(collision.frame, color=colour, linewidth=0.8, alpha=0.45, zorder=0)
    axes.axhline(0.0, color=BLACK, linewidth=0.8)
    beside = 0.12 * float(np.ptp(shown)) or 1.0
    axes.set_gid(TIME)
    axes.set_xlim(*frames)
    axes.set_ylim(min(shown) - beside, max(shown) + beside)
    axes.set_xlabel("frame")
    axes.set_ylabel(f"velocity ({scale.speed_unit})\naway from the wall is up")
    axes.set_title("Velocities: dots from frame to frame, lines and bars fitted between collisions")

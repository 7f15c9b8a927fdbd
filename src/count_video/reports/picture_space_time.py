"""The panel with the space-time image, the tracks over it and a numbered mark a collision."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from count_video.records import Collision, CollisionKind, Floats
from count_video.reports.drawing import HALO
from count_video.reports.material import Material, ball_edges_px, contact_px, scale_of
from count_video.reports.palette import BALL, BLACK, GREY, HEAVY, MARKS, YELLOW
from count_video.reports.stretch import Range, shown_places

Converter = Callable[[ArrayLike], Floats]
NUMBER_ROOM = 0.025
"""Numbers stand at least this share of the panel's width apart, where others show them all."""
MOST_NUMBERS = 60
"""Of more collisions than these not every one is numbered in the enlarged panel either."""
BRIGHTEST_PERCENTILES = (1.0, 99.5)


def draw_space_time(
    axes: Axes, material: Material, frames: Range, *, enlarged: Range | None = None
) -> None:
    """Draw a stretch of frames; ``enlarged`` is what another panel shows larger, if any does."""
    places = shown_places(material, frames)
    _draw_image(axes, material, frames, places)
    _draw_tracks(axes, material)
    _draw_marks(axes, material, frames, enlarged)
    axes.set_xlim(*frames)
    axes.set_ylim(*places[:: material.outward])
    axes.set_ylabel("position along the line (px)")
    axes.set_xlabel("frame")
    _add_units(axes, material)
    if enlarged is not None:
        axes.axvspan(*enlarged, fill=False, edgecolor=YELLOW, linewidth=2.0)
        axes.set_title("Space and time: the wall at the bottom, the framed part enlarged below")
        axes.set_xlabel("")
    else:
        axes.set_title("The crowded middle")
        axes.set_xlabel("")
        axes.tick_params(labelbottom=False)


def _draw_image(axes: Axes, material: Material, frames: Range, places: Range) -> None:
    rows, image = material.space_time.frame, material.space_time.image
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


def _draw_tracks(axes: Axes, material: Material) -> None:
    track = material.track
    for edge in ball_edges_px(track):
        axes.plot(track.frame, edge, color=BALL, linewidth=1.4, gid="ball")
    if track.heavy is not None:
        axes.plot(track.frame, track.heavy.position_px, color=HEAVY, linewidth=1.8, gid="heavy")


def _draw_marks(axes: Axes, material: Material, frames: Range, enlarged: Range | None) -> None:
    burst = material.burst
    shown = [c for c in material.result.collisions if frames[0] <= c.frame <= frames[1]]
    for kind in MARKS:
        for seen in (True, False):
            chosen = [c for c in shown if c.kind == kind and c.seen == seen]
            _scatter(axes, material, [c for c in chosen if c in burst], (kind, seen), None)
            _scatter(axes, material, [c for c in chosen if c not in burst], (kind, seen), GREY)
    size = 10 if enlarged is None else 8
    last: dict[CollisionKind, float] = {}
    room = NUMBER_ROOM * (frames[1] - frames[0])
    for collision in shown:
        crowded = collision.frame - last.get(collision.kind, -np.inf) < room
        hidden = enlarged is not None and _amid(collision, enlarged, burst)
        few = enlarged is None and len(shown) <= MOST_NUMBERS
        if few or not (crowded or hidden):
            _number(axes, material, collision, size)
            last[collision.kind] = collision.frame


def _amid(collision: Collision, stretch: Range, burst: Sequence[Collision]) -> bool:
    """Whether a collision stands between others of an enlarged stretch: numbered there alone."""
    inside = [c.number for c in burst if stretch[0] <= c.frame <= stretch[1]]
    return len(inside) > 2 and inside[0] < collision.number < inside[-1]


def _scatter(
    axes: Axes,
    material: Material,
    chosen: Sequence[Collision],
    look: tuple[CollisionKind, bool],
    colour: str | None,
) -> None:
    if not chosen:
        return
    mark = MARKS[look[0]]
    axes.scatter(
        [c.frame for c in chosen],
        [contact_px(c, material.track) for c in chosen],
        s=52,
        marker=mark.shape,
        # Seen: filled with a white rim. Inferred: hollow, of twice the rim.
        facecolor=(colour or mark.colour) if look[1] else "white",
        edgecolor="white" if look[1] else (colour or mark.colour),
        linewidth=1.0 if look[1] else 2.2,
        zorder=4,
        gid="collision" if colour is None else "beyond",
    )


def _number(axes: Axes, material: Material, collision: Collision, size: int) -> None:
    # Contacts of the bodies are numbered towards the heavy body, those with the wall towards it.
    up = (collision.kind == "bodies") == (material.track.heavy is not None)
    axes.annotate(
        str(collision.number),
        (collision.frame, contact_px(collision, material.track)),
        xytext=(0, 8 if up else -8),
        textcoords="offset points",
        ha="center",
        va="bottom" if up else "top",
        fontsize=size,
        weight="bold",
        path_effects=list(HALO),
        zorder=5,
        gid="number",
        annotation_clip=True,
    )


def _add_units(axes: Axes, material: Material) -> None:
    """Real units on the far sides, where they are known; the wall side of the ball's path is 0."""
    scale = scale_of(material.result)
    edges = ball_edges_px(material.track)
    outward = material.outward
    wall = float(np.nanmin(edges[0])) if outward > 0 else float(np.nanmax(edges[1]))
    if scale.length_unit != "px":
        factor = outward * scale.length
        side = axes.secondary_yaxis("right", functions=_linear(factor, -wall * factor))
        side.set_ylabel(f"from the wall ({scale.length_unit})")
    if scale.time_unit != "frame":
        top = axes.secondary_xaxis("top", functions=_linear(scale.time, 0.0))
        top.set_xlabel(f"time ({scale.time_unit})", loc="right", labelpad=2)


def _linear(factor: float, shift: float) -> tuple[Converter, Converter]:
    """Give y = factor x + shift and its inverse."""

    def forward(values: ArrayLike) -> Floats:
        return np.asarray(values, np.float64) * factor + shift

    def backward(values: ArrayLike) -> Floats:
        return (np.asarray(values, np.float64) - shift) / factor

    return forward, backward


def legend_handles(material: Material) -> list[Line2D]:
    """Say what the lines and marks of all panels mean."""
    handles = [Line2D([], [], color=BALL, linewidth=3, label="ball (its two edges)")]
    if material.track.heavy is not None:
        handles.append(Line2D([], [], color=HEAVY, linewidth=3, label="cylinder (its face)"))
    for kind, mark in MARKS.items():
        if any(c.kind == kind for c in material.result.collisions):
            label = f"collision {mark.words}"
            handles.append(_handle(mark.shape, mark.colour, label, filled=True))
    if not all(c.seen for c in material.result.collisions):
        handles.append(_handle("o", BLACK, "hollow: inferred between frames", filled=False))
    if len(material.result.collisions) > len(material.burst):
        handles.append(_handle("o", GREY, "after the burst", filled=True))
    return handles


def _handle(shape: str, colour: str, label: str, *, filled: bool) -> Line2D:
    return Line2D(
        [],
        [],
        linestyle="",
        marker=shape,
        markersize=8,
        markerfacecolor=colour if filled else "white",
        markeredgecolor="white" if filled else colour,
        markeredgewidth=1.0 if filled else 2.0,
        label=label,
    )

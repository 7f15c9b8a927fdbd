"""The panel with the space-time image, the tracks over it and a numbered mark a collision."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from count_video.records import Collision, CollisionKind
from count_video.reports.drawing import HALO
from count_video.reports.material import Material, ball_edges_px, contact_px, scale_of
from count_video.reports.palette import BALL, BLACK, GREY, HEAVY, MARKS, YELLOW

Range = tuple[float, float]
CROWD_SHARE = 0.6
"""The enlarged stretch is the shortest that holds this share of the burst."""
MARGIN_SHARE = 0.06
"""Of a stretch of frames, shown on either side of it."""
BRIGHTEST_PERCENTILES = (1.0, 99.5)


def shown_frames(material: Material) -> Range:
    """First and last frame of the whole picture: all collisions, or the clip without any."""
    frames = material.track.frame
    ends = (float(frames[0]), float(frames[-1]))
    collisions = material.result.collisions
    if not collisions:
        return ends
    low, high = collisions[0].frame, collisions[-1].frame
    margin = max(10.0, 2 * MARGIN_SHARE * (high - low))
    return max(ends[0], low - margin), min(ends[1], high + margin)


def crowded_frames(material: Material) -> Range:
    """The shortest stretch of frames that holds most of the burst."""
    times = [collision.frame for collision in material.burst]
    if len(times) < 3:
        return shown_frames(material)
    held = max(3, round(CROWD_SHARE * len(times)))
    starts = range(len(times) - held + 1)
    start = min(starts, key=lambda first: times[first + held - 1] - times[first])
    low, high = times[start], times[start + held - 1]
    margin = MARGIN_SHARE * (high - low) + 1.0
    return low - margin, high + margin


def draw_space_time(
    axes: Axes, material: Material, frames: Range, *, enlarged: Range | None = None
) -> None:
    """Draw a stretch of frames; ``enlarged`` is what another panel shows larger, if any does."""
    places = _shown_places(material, frames)
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


def _shown_places(material: Material, frames: Range) -> Range:
    """Lowest and highest position shown: from the wall to the heavy body's face, with room."""
    track = material.track
    inside = (track.frame >= frames[0]) & (track.frame <= frames[1])
    low, high = (edge[inside] for edge in ball_edges_px(track))
    face = track.heavy.position_px[inside] if track.heavy is not None else high
    values = np.concatenate([low, high, face])
    values = values[np.isfinite(values)]
    if values.size == 0:
        return 0.0, float(material.space_time.image.shape[1])
    room = 0.35 * track.ball_diameter_px
    return float(values.min()) - room, float(values.max()) + room


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
    for collision in shown:
        if enlarged is None or not _amid(collision, enlarged, burst):
            _number(axes, material, collision, size)


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
        side = axes.secondary_yaxis(
            "right",
            functions=(
                lambda place: (place - wall) * outward * scale.length,
                lambda length: length / scale.length * outward + wall,
            ),
        )
        side.set_ylabel(f"from the wall ({scale.length_unit})")
    if scale.time_unit != "frame":
        top = axes.secondary_xaxis(
            "top",
            functions=(lambda frame: frame * scale.time, lambda time: time / scale.time),
        )
        top.set_xlabel(f"time ({scale.time_unit})", loc="right", labelpad=2)


def legend_handles(material: Material) -> list[Line2D]:
    """What the lines and marks of all panels mean."""
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

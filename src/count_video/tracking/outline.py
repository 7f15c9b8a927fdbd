"""The outline of a body in the mean of many pictures that were laid upon each other in its frame.

What belongs to the body stays the same, so its edges stay sharp in the mean; what lies behind it,
the neighbour, or a reflection that does not quite follow, smears out and varies. The slope of the
mean over the standard deviation of the pixels is therefore high on the body's own edges only, and
so is that of the deviation where it begins to grow: they give the outline and the weights without a
word on shape, colour or brightness.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats, Indices, Mask, Pixels
from count_video.signals import beyond, weighted_quantile
from count_video.tracking.circle import Circle, Edges, circle_through, placed, steepest
from count_video.tracking.shape import Box
from count_video.tracking.template import Template, make_template

EDGE_POSSIBLE = 0.35
"""Slope per px over the standard deviation, from which on an edge can be the body's own."""
PIECE_SHARE = 0.01
PIECE_HEIGHT = 0.2
"""A piece of the outline has these shares of the clearest piece's weight and of the height."""
BEYOND_OUTLINE_PX = 2
"""Pixels kept beyond the outline: the blurred edge reaches that far."""
OUTSIDE_SHARE = 0.35
"""A circle is the outline if no larger share of what moves lies outside of it."""
CLEAR_SECTORS, SHADOW_SHARE = 12.5, 0.7
"""Of what more than half of a circle shows, that is a ball's shadow, or scenery that it hid in few
of the pictures; of a cart, four fifths lie outside of a wheel."""
ENDS_SECTORS = 11.5
"""So many sectors of a circle are shown by the ends of what moves, which are nowhere else."""
ROWS_AT_LEAST = 8
FAINT_SHARE = 0.5
"""Edges in a smaller share of the rows, or across a smaller share of what moves, are no outline."""
EDGE_WIDTH_PX = 2
"""An edge that is blurred as pictures are smoothed reaches so far to both sides."""
EDGE_REACH_PX = 4
OUTERMOST_SHARE, NEAR_OUTERMOST_PX = 0.1, 1.0
"""Outermost is the edge beyond which lies this share of the rows' steepness. Edges of rows this
near to it are taken together: the face of a cylinder is seen as a straight edge."""


@dataclass(frozen=True)
class Mean:
    """Pictures laid upon each other in the body's frame; arrays have shape (height, width)."""

    appearance: Pixels
    variance: Pixels
    moving: Mask
    """Where the pictures agree with each other better than with the background."""
    behind: Pixels
    """What lies behind the body."""
    through: Pixels
    """Variance that pixels have from that, where it shows through: at and beyond blurred edges."""
    theirs: Sequence[Callable[[], Pixels]] = ()
    """By how many grey levels the motion of each neighbour explains the pictures better: worked out
    where it is asked for, as few bodies hang together with others."""


@dataclass(frozen=True)
class Outline:
    """A body cut out of the mean."""

    template: Template
    box: Box
    """Outermost points of the outline, from the template's top left pixel."""
    round_: bool
    """Whether the outline is a circle (a ball seen from the side)."""
    begin_px: int
    """Column of the mean at which the template begins."""


def find_outline(mean: Mean, fence: tuple[float, float], *, circles: bool = True) -> Outline | None:
    """Trim the mean to the body and weight its pixels; None if there is no outline.

    ``fence`` gives the first and last column that can be the body's.
    """
    slope, across = (_steepness(mean, axis) for axis in (1, 0))
    columns = np.arange(mean.appearance.shape[1])
    own = mean.moving & (columns >= fence[0]) & (columns <= fence[1])
    clarity, clear_across = (
        np.where(own, one / np.sqrt(mean.variance), 0) for one in (slope, across)
    )
    body = _own_edges(clarity)
    upright = _edge_points(slope, clarity, body)
    level = _edge_points(across.T, clear_across.T, _own_edges(clear_across.T))
    every = upright.beside(level)
    circle = circle_through(every, len(body)) if circles else None
    if circles and (circle is None or not _is_outline(circle, mean)):
        circle = _circle_of_ends(mean, slope, own)
    if circle is not None:
        body = mean.moving & (circle.away_px(body.shape) < BEYOND_OUTLINE_PX)
    elif body.any(axis=1).sum() < FAINT_SHARE * body.shape[0] or _one_end(body, own):
        # Too faint for edges of its own: what moves together, less the blur of the decision.
        body = cv2.erode(mean.moving.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    rows = np.flatnonzero(body.sum(axis=1) >= 3)
    if len(rows) < ROWS_AT_LEAST:
        return None
    left, right = ends_of(body[rows])
    if circle is None:
        # By the mean alone: the deviation also grows where a neighbour comes and goes.
        along = np.abs(np.gradient(mean.appearance, axis=1))
        ends = _edge(along, rows, left, 1), _edge(along, rows, right, -1)
    else:
        circle = placed(circle, every)
        ends = circle.x_px - circle.radius_px, circle.x_px + circle.radius_px
    if ends[1] - ends[0] < ROWS_AT_LEAST:  # an edge and no body
        return None
    return _cut_out(mean, (rows, left, right), ends, circle)


def _steepness(mean: Mean, axis: int) -> Pixels:
    """How fast the law of the pixels' brightness changes along an axis, in grey levels per px.

    Of a normal law with mean m and standard deviation s, a pixel holds Fisher's information on a
    shift of (m'^2 + 2 s'^2) / s^2: where a body is as bright as the mean of what it hides, it ends
    where the deviation begins to grow.
    """
    both = np.stack([mean.appearance, np.sqrt(2 * mean.variance)])
    level, spread = np.gradient(both, axis=axis + 1)
    return np.asarray(np.hypot(level, spread), np.float32)


def _one_end(body: Mask, own: Mask) -> bool:
    """Whether edges span little of what moves: they are clear at one end of a body only."""
    rows = body.any(axis=1)
    return bool(widths_of(body)[rows].sum() < FAINT_SHARE * widths_of(own)[rows].sum())


def _circle_of_ends(mean: Mean, slope: Pixels, own: Mask) -> Circle | None:
    """Find a circle through the steepest edges at both ends of what moves in each row."""
    rows = np.flatnonzero(own.any(axis=1))
    first, last = ends_of(own[rows])
    ends = _edges(slope, rows, first, 1)[0], _edges(slope, rows, last, -1)[0]
    places = np.stack([np.concatenate(ends), np.r_[rows, rows]], axis=1)
    circle = circle_through(Edges(places, np.ones(len(places))), len(own))
    if circle is None or circle.sectors < ENDS_SECTORS or _beside(circle, mean) > OUTSIDE_SHARE:
        return None
    return circle


def _is_outline(circle: Circle, mean: Mean) -> bool:
    """Whether a circle is the outline, by how clear it is and how much of what moves it holds."""
    clear = circle.sectors >= CLEAR_SECTORS
    return _beside(circle, mean) <= (SHADOW_SHARE if clear else OUTSIDE_SHARE)


def _beside(circle: Circle, mean: Mean) -> float:
    """Share of what moves that lies outside of a circle."""
    outside = mean.moving & (circle.away_px(mean.moving.shape) >= BEYOND_OUTLINE_PX)
    return float(outside.sum() / mean.moving.sum())


def _cut_out(
    mean: Mean,
    spans: tuple[Indices, Indices, Indices],
    ends: tuple[float, float],
    circle: Circle | None,
) -> Outline:
    """Make the template of what lies between the outermost edge pixels of each row."""
    rows, first, last = spans
    width = mean.appearance.shape[1]
    begin = max(0, int(first.min()) - BEYOND_OUTLINE_PX)
    end = min(width, int(last.max()) + BEYOND_OUTLINE_PX + 1)
    columns = np.arange(begin, end)
    mask = np.zeros((len(mean.appearance), end - begin), np.bool_)
    mask[rows] = (columns >= first[:, None] - BEYOND_OUTLINE_PX) & (
        columns <= last[:, None] + BEYOND_OUTLINE_PX
    )
    inner = slice(begin, end)
    variance = np.maximum(mean.variance, mean.through)[:, inner]
    weight = np.where(mask & mean.moving[:, inner], 1 / variance, 0)
    template = make_template(mean.appearance[:, begin:end], weight.astype(np.float32))
    if circle is None:
        rows = np.flatnonzero(weight.any(axis=1))
        high = float(rows[0]), float(rows[-1])
    else:
        high = circle.y_px - circle.radius_px, circle.y_px + circle.radius_px
    box = ends[0] - begin, high[0], ends[1] - begin, high[1]
    return Outline(template, box, circle is not None, begin)


def ends_of(own: Mask) -> tuple[Indices, Indices]:
    """First and last column of each row; of a row with none, 0 and the last of all."""
    return np.argmax(own, axis=1), own.shape[1] - 1 - np.argmax(own[:, ::-1], axis=1)


def widths_of(own: Mask) -> Indices:
    """How many columns each row spans."""
    first, last = ends_of(own)
    return np.where(own.any(axis=1), last - first + 1, 0)


def _own_edges(clarity: Pixels) -> Mask:
    """Pixels of the body's own edges.

    Edges come in pieces: a long plain body shows its two ends and nothing between them, a ball two
    arcs and its ring. A piece counts if it is tall enough to be part of an outline.
    """
    possible = (cv2.blur(clarity, (3, 3)) > EDGE_POSSIBLE).astype(np.uint8)
    bridge = max(3, clarity.shape[0] // 6) | 1
    joined = cv2.morphologyEx(possible, cv2.MORPH_CLOSE, np.ones((bridge, bridge), np.uint8))
    _, labels = cv2.connectedComponents(joined)
    own = possible > 0
    worth = np.bincount(labels[own], weights=clarity[own], minlength=int(labels.max()) + 1)
    pieces = [
        label
        for label in np.flatnonzero(worth > PIECE_SHARE * worth.max())
        if (own & (labels == label)).any(axis=1).sum() > PIECE_HEIGHT * clarity.shape[0]
    ]
    return np.asarray(own & np.isin(labels, pieces), dtype=bool)


def _edge_points(slope: Pixels, clarity: Pixels, own: Mask) -> Edges:
    """Find those of a body's own edges that are steepest among their neighbours in the row.

    An edge is clearest a little further within the body, where what lies behind it does not vary
    yet.
    """
    clearest = cv2.dilate(clarity, np.ones((1, 2 * EDGE_WIDTH_PX + 1)))
    places, pixels = steepest(np.where(own, slope, 0))
    return Edges(places, clearest[pixels].astype(np.float64))


def _edge(slope: Pixels, rows: Indices, ends: Indices, inward: int) -> float:
    """Find the outermost point of one side of the outline, to a small part of a pixel.

    A quantile over the rows, which a stray row does not move, gives the outermost edge roughly; it
    would take noise for outline, so the mean of the edges nearby stands for it. Rows count by how
    steep their edges are: little where a shadow ends.
    """
    edges, steepness = _edges(slope, rows, ends, inward)
    outermost = inward * weighted_quantile(inward * edges, steepness, OUTERMOST_SHARE)
    return float(edges[np.abs(edges - outermost) <= NEAR_OUTERMOST_PX].mean())


def _edges(slope: Pixels, rows: Indices, ends: Indices, inward: int) -> tuple[Floats, Floats]:
    """Edge of each row: the steepest place within a few px of the mask's end, and how steep."""
    first = np.minimum(ends - (EDGE_REACH_PX - 1) * inward, ends + EDGE_REACH_PX * inward)
    columns = first[:, None] + np.arange(2 * EDGE_REACH_PX)
    inside = (columns >= 0) & (columns < slope.shape[1])
    steepness = slope[rows[:, None], columns.clip(0, slope.shape[1] - 1)]
    steepness[~inside] = -1.0
    best, each = np.argmax(steepness, axis=1), np.arange(len(rows))
    around = np.pad(steepness, ((0, 0), (1, 1)), constant_values=-1.0)
    low, top, high = (around[each, best + k] for k in range(3))
    between = np.where((low >= 0) & (high >= 0), beyond(low, top, high), 0.0)
    return np.asarray(columns[each, best] + between, np.float64), top.astype(np.float64)

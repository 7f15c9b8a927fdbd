"""Cut a body out of pieces of pictures: what moves with it and hangs together, in two views.

A wide view of reduced pictures shows what a body is and where it ends, without its threads, shadow
and neighbours; within that, a close view of the pictures as they are gives its template.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from count_video.records import Floats, Indices, Mask, Point
from count_video.tracking.composite import NEIGHBOURHOOD_PX, Source, cut_pieces, median_of
from count_video.tracking.outline import Mean, Outline, find_outline, widths_of
from count_video.tracking.paths import only

EDGE_PX = 3
"""So far around what moves with a body its blurred edges reach."""
CLOSE_PX = 2 * EDGE_PX + 1
"""A close view shows so many px, and one of the wide view's, around a body."""
WIDE_ROWS = 0.45
"""The rows of a body are at least so wide, as a share of the widest; a circle's are, but for a
twentieth of its height at the top and at the bottom. Threads are narrower."""
THREAD_SHARE, THREAD_PX = 0.1, NEIGHBOURHOOD_PX + 4
"""What is narrower than this share of a body's shorter side, and than so many px, is no part of it,
but a thread."""
FULL_ROWS, LINE_RATIO = 0.9, 2.0
"""Rows with threads are less wide than this share of the widest one, and the contrast of lines in
them is so many times that of the rest."""
GAP_SHARES = 0.1, 0.15
"""Where a body is as bright as what lies behind it, gaps of these shares of its shorter side, from
row to row and from column to column, are its own."""
PART_SHARE = 0.1
"""A long plain body shows its two ends and nothing between them: parts at least so large, as a
share of the largest, belong to it if they lie in its box, ..."""
AS_HIGH_SHARE = 0.6
"""... and beside a box that is higher than wide parts that are nearly as high, in this share of its
rows: it may be that of one end."""
PIECES_AT_LEAST, PIXELS = 12, 1_000_000
"""Of large bodies fewer pieces are taken, so that all have no more pixels than this together."""
AREA_SHARE = 0.6
"""What fills more of the picture than this is the scene."""
SIGHTINGS_AT_LEAST = 4

Fence = tuple[float, float]
"""Image x, from a body's path, beyond which its neighbours' corners begin."""


@dataclass(frozen=True)
class Stage:
    """What is known of a body on the way, in px of pictures that may be reduced."""

    scale: int
    """How many px of the pictures one of its holds."""
    corner: Point
    """Of the box around it, from its path."""
    shape: tuple[int, int]
    """Height and width of the box."""
    path_px: Floats
    """Image x and y of the box's top left pixel, shape (samples, 2); NaN in samples that are left
    out."""
    own: Mask | None = None
    """Which pixels of the box are the body's; None where that is not known."""
    unsure_px: int = 1
    """Up to so far from these."""
    agreement: float = 0.0
    """Median correlation with the pictures it was registered in."""
    agreeing: float = 0.0
    """How many pictures agree with it, as a share of those that hold it."""

    @property
    def samples(self) -> Indices:
        """Those that are not left out."""
        return np.flatnonzero(np.isfinite(self.path_px[:, 0]))

    def at(self, path_px: Floats, samples: Indices) -> Stage:
        """Put it where its path is in some samples."""
        return replace(self, path_px=only(path_px + self.corner, samples))

    def reduced(self, scale: int) -> Stage:
        """Turn px of pictures into those of reduced ones."""
        (x, y), (height, width) = self.corner, self.shape
        shape = round(height / scale), round(width / scale)
        return Stage(scale, (x / scale, y / scale), shape, self.path_px / scale)

    def enlarged(self) -> Stage:
        """Turn px of reduced pictures into those of the pictures."""
        by, (x, y), (height, width) = self.scale, self.corner, self.shape
        own = None if self.own is None else self.own.repeat(by, axis=0).repeat(by, axis=1)
        return Stage(1, (by * x, by * y), (by * height, by * width), by * self.path_px, own, by)

    def fills(self, source: Source) -> bool:
        """Whether it takes up more of the picture than a body does."""
        height, width = self.shape
        return height * width > AREA_SHARE * source.background.luma.size


def cut_out(
    source: Source, stage: Stage, margin: tuple[int, int], fence: Fence
) -> tuple[Stage, Outline] | None:
    """Cut out what moves with a body and hangs together with its box; None if nothing does.

    Where its own pixels are known from a wide view, it lies within these.
    """
    if len(stage.samples) < SIGHTINGS_AT_LEAST or stage.fills(source):
        return None
    mean = _mean(source, stage, margin)
    own = _connected(mean, stage, margin)
    if own is None:
        return None
    edge = -(-EDGE_PX // stage.scale)
    rows, columns = (np.flatnonzero(own.any(axis=axis)) for axis in (1, 0))
    top, left = max(0, int(rows[0]) - edge), max(0, int(columns[0]) - edge)
    part = slice(top, int(rows[-1]) + edge + 1), slice(left, int(columns[-1]) + edge + 1)
    begin = left - margin[1]
    ends = [side / stage.scale - stage.corner[0] - begin for side in fence]
    held = Mean(
        mean.appearance[part], mean.variance[part], own[part], mean.behind[part], mean.through[part]
    )
    del mean  # it holds the pieces, by which neighbours are weighed
    outline = find_outline(held, (ends[0], ends[1]), circles=stage.own is not None)
    if outline is None:
        return None
    x, y = begin + outline.begin_px, top - margin[0]
    shape = outline.template.shape
    pixels = held.moving[:, outline.begin_px : outline.begin_px + shape[1]]
    corner = stage.corner[0] + x, stage.corner[1] + y
    return Stage(stage.scale, corner, shape, stage.path_px + np.array([x, y]), pixels), outline


def _mean(source: Source, stage: Stage, margin: tuple[int, int]) -> Mean:
    """Lay pieces of some samples upon each other."""
    samples = stage.samples
    pixels = (stage.shape[0] + 2 * margin[0]) * (stage.shape[1] + 2 * margin[1])
    count = max(PIECES_AT_LEAST, PIXELS // pixels)
    some = np.linspace(0, len(samples) - 1, min(count, len(samples))).astype(int)
    pieces = cut_pieces(source, only(stage.path_px, samples[some]), stage.shape, margin)
    return median_of(pieces, stage.scale)


def _connected(mean: Mean, stage: Stage, margin: tuple[int, int]) -> Mask | None:
    """Part of what moves with a body that hangs together with its box; None if nothing does."""
    moving = mean.moving
    if stage.own is None:
        return _hanging_together(mean, stage, margin)
    reach = 2 * stage.unsure_px + 1
    around = np.pad(stage.own, [(size, size) for size in margin]).astype(np.uint8)
    near = cv2.dilate(around, np.ones((reach, reach), np.uint8)) > 0
    own = np.asarray(near & moving)
    return own if own.any() else None


def _hanging_together(mean: Mean, stage: Stage, margin: tuple[int, int]) -> Mask | None:
    """Part of what moves with a body that hangs together with its box.

    Threads are no part of it, nor is what a neighbour's motion explains better.
    """
    shape, scale = stage.shape, stage.scale
    box = tuple(slice(begin, begin + size) for begin, size in zip(margin, shape, strict=True))
    moving = mean.moving
    side = scale * min(shape)
    width = _reduced(max(THREAD_PX, round(THREAD_SHARE * side)), scale)
    kernel = np.ones((width, width), np.uint8)
    gap = np.ones([_reduced(round(share * side), scale) for share in GAP_SHARES], np.uint8)
    whole = cv2.morphologyEx(moving.astype(np.uint8), cv2.MORPH_CLOSE, gap)
    opened = cv2.morphologyEx(whole, cv2.MORPH_OPEN, kernel)
    _, labels = cv2.connectedComponents(opened)
    inner = labels[box]
    held = np.bincount(inner.ravel(), minlength=max(2, int(labels.max()) + 1))
    held[0] = 0
    if not held.any():
        return None
    if np.count_nonzero(held) > 1:
        own = [k for k in np.flatnonzero(held) if not _belongs_to_others(mean, labels == k)]
        held *= np.isin(np.arange(len(held)), own or np.flatnonzero(held))
    parts = np.flatnonzero(held > PART_SHARE * held.max()).tolist()
    if shape[1] <= shape[0]:
        main = labels == np.argmax(held)
        rows, columns = main.any(axis=1), main.any(axis=0)
        beside = np.setdiff1d(labels[rows], np.append(labels[:, columns], 0)).tolist()
        as_high = [k for k in beside if (labels[rows] == k).any(axis=1).mean() > AS_HIGH_SHARE]
        parts += [k for k in as_high if not _belongs_to_others(mean, labels == k)]
    body = _without_threads(np.isin(labels, parts), mean, box, width)
    return np.asarray((cv2.dilate(body.astype(np.uint8), kernel) > 0) & moving)


def _belongs_to_others(mean: Mean, part: Mask) -> bool:
    """Whether the motion of a neighbour explains a part and its edges better."""
    if not mean.theirs:
        return False
    size = 2 * EDGE_PX + 1
    around = cv2.dilate(part.astype(np.uint8), np.ones((size, size), np.uint8)) > 0
    return any(float(better()[around].sum()) > 0 for better in mean.theirs)


def _reduced(width_px: int, scale: int) -> int:
    """Odd width of a kernel for reduced pictures that joins or removes no more than this one."""
    return ((width_px | 1) - 1) // (2 * scale) * 2 + 1


def _without_threads(own: Mask, mean: Mean, box: tuple[slice, ...], width: int) -> Mask:
    """Keep rows one below the other that are nearly as wide as the widest one of the box.

    Threads span much of a row as well, but go on to the border of what is shown, and lines of less
    than a ``width`` are all that is in their rows. Where there are several broad rows, with narrow
    ones in between, those with the sharpest edges are kept: the edges of a shadow are soft. Only
    slopes along the motion count, for lines along it of what lies behind the body are sharp as
    well.
    """
    wide = widths_of(own)
    widest = max(1, wide[box[0]].max())
    broad = wide >= WIDE_ROWS * widest
    solid = broad & ((wide >= FULL_ROWS * widest) | ~_lines_only(own, mean, width))
    for rows in (slice(None), slice(None, None, -1)):
        shown = mean.appearance[rows].any(axis=1)
        if wide[rows][np.argmax(shown)] > 0:
            broad[rows][: np.argmax(solid[rows])] = False
    runs = np.cumsum(np.diff(broad, prepend=False)) * broad
    slopes = np.gradient(mean.appearance[box[0]], axis=1)[:, box[1]]
    sharp = np.where(own[box], slopes**2, 0).sum(axis=1)
    worth = np.bincount(runs[box[0]], weights=sharp, minlength=2)
    worth[0] = -1.0  # the narrow rows
    return np.asarray(own & (runs == np.argmax(worth))[:, None])


def _lines_only(own: Mask, mean: Mean, width: int) -> Mask:
    """Which rows differ from what lies behind them by lines and hardly else, shape (rows,).

    A line is what an opening or closing along the row, by a ``width``, removes.
    """
    along, without = np.ones((1, width), np.uint8), mean.appearance
    for removing in (cv2.MORPH_OPEN, cv2.MORPH_CLOSE):
        without = np.asarray(cv2.morphologyEx(without, removing, along), np.float32)
    lines, rest = (
        np.sqrt(np.sum((one - other) ** 2, axis=1, where=own))
        for one, other in ((mean.appearance, without), (without, mean.behind))
    )
    return np.asarray(lines > LINE_RATIO * rest)

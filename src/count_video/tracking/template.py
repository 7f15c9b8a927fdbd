"""The template of a body: its median appearance over many pictures, with a weight for each pixel.

Pieces of pictures are laid upon each other where the body's corners were followed to, and
registered to their median; the median of the registered pieces is the template. A pixel belongs to
the body if the median explains the pieces better than what lies behind it does: the background and
the bodies that are known already. Pictures are chosen by how rare they are: those in which a body
rests, or two move along side by side, are many and show nothing new.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.background import Background
from count_video.tracking.composite import NEIGHBOURHOOD_PX, cut_pieces, median_of
from count_video.tracking.outline import Mean, Outline, find_outline
from count_video.tracking.registration import register
from count_video.tracking.shape import Box, Place, Shape
from count_video.tracking.sprite import Sprite, look, make_sprite

Luma = NDArray[np.uint8]

SURROUNDINGS, ENDS_APART = 0.6, 1.5
"""The surroundings that are averaged too, on all sides, as a share of the box's longer side, and at
both ends also of its height: the other end of a plain body may be so far away."""
EDGE_PX = 3
"""So far around what moves with a body its blurred edges reach."""
WIDE_ROWS = 0.45
"""The rows of a body are at least so wide, as a share of the widest; a circle's are, but for a
twentieth of its height at the top and at the bottom. Threads are narrower."""
THREAD_SHARE = 0.1
"""What is narrower than this share of a body's shorter side is no part of it, but a thread."""
GAP_SHARES = 0.1, 0.15
"""Where a body is as bright as what lies behind it, gaps of these shares of its shorter side, from
row to row and from column to column, are its own."""
PART_SHARE = 0.1
"""A long plain body shows its two ends and nothing between them: parts at least so large, as a
share of the largest, belong to it if they lie in its box, ..."""
AS_HIGH_SHARE = 0.6
"""... and beside a box that is higher than wide parts that are nearly as high, in this share of its
rows: it may be that of one end."""
PICTURES, PICTURES_AT_LEAST, PIXELS = 40, 12, 2_000_000
"""A template is the median of so many pictures; of large bodies of fewer, so that all pieces have
no more pixels than this together."""
ROUND_HEIGHT = 0.87, 1.15
"""Height of the rows at least half as wide as a ball's outline, over its width."""
ROUNDS, ROUNDS_AGAIN = 3, 2
"""So often a body is cut out and registered: once less if its places are known already."""
AREA_SHARE = 0.6
"""What fills more of the picture than this is the scene."""
SIGHTINGS_AT_LEAST = 4
AGREEMENT_AT_LEAST = 0.5
"""Correlation below which a piece is not taken for the body."""
AGREEMENT_SHARE = 0.9
"""Pieces that agree less than this share of the median are dropped."""
INSIDE_AT_LEAST = 0.7
"""Share of the template that must lie within a picture to learn from it."""
PLACE_BIN_PX = 3.0
"""Pictures with the same bin of places, or of distances to the neighbour, are alike."""


@dataclass(frozen=True)
class Rough:
    """A body as its corners show it; positions are those of a point that moves with it."""

    path_px: Mapping[int, Place]
    """Frame index -> image x and y of that point."""
    box: Box
    """Around the corners, from that point."""
    fence: tuple[float, float]
    """Image x, from that point, beyond which the neighbours' corners begin."""
    blurred: bool = False
    """Whether the path is that of a region, right to some px only."""
    patterned: bool = True
    """Whether many corners show it."""
    corners: Shape | None = None
    """Its outermost corners."""


@dataclass(frozen=True)
class Body:
    """A template with its outline; x is measured from the template's left column."""

    sprite: Sprite
    left_edge_px: float
    right_edge_px: float
    """Where the outline's outermost points are."""
    round_: bool
    """Whether the outline is a circle, or as high as one of its width."""
    sightings: dict[int, Place]
    """Frame index -> (x, y) of the template's top left pixel, roughly where it was not learnt."""
    learnt: tuple[int, ...]
    """Frames of the pictures it was learnt from, in which it was registered."""
    typical_agreement: float
    """Median correlation with the pictures it was learnt from."""

    @property
    def box(self) -> Box:
        """Outline, from the template's top left pixel."""
        rows = np.flatnonzero((self.sprite.weight > 0).any(axis=1))
        return self.left_edge_px, float(rows[0]), self.right_edge_px, float(rows[-1])


def learn(
    pictures: Mapping[int, Luma],
    background: Background,
    rough: Rough,
    others: Sequence[Mapping[int, Place]],
    known: Sequence[Shape] = (),
) -> Body | None:
    """Learn the template of a body that is roughly known.

    Parameters
    ----------
    pictures
        Frame index -> luma, shape (height, width).
    background
        What stands still in them.
    rough
        The body as its corners show it.
    others
        Paths of the other bodies, by which pictures are told to be alike.
    known
        What hides the body in some pictures.

    Returns
    -------
    Body or None
        None where the pieces show no outline, or too few agree with their median.
    """
    left, top, right, bottom = (round(edge) for edge in rough.box)
    shape = bottom - top, right - left
    margin = _margin(shape, rough)
    rarity = _rarity(rough.path_px, others)
    chosen = _some(rarity, (shape[0] + 2 * margin[0], shape[1] + 2 * margin[0]))
    places = {k: _plus(rough.path_px[k], (left, top)) for k in chosen if k in pictures}
    if rough.blurred:
        places = _aligned(pictures, places, shape)
    cut: _Cut | None = None
    corner, agreement = (float(left), float(top)), 0.0
    largest = AREA_SHARE * float(background.luma.size)
    for _ in range(ROUNDS if rough.corners is not None else ROUNDS_AGAIN):
        if len(places) < SIGHTINGS_AT_LEAST or shape[0] * shape[1] > largest:
            return None
        fence = rough.fence[0] - corner[0], rough.fence[1] - corner[0]
        pieces = cut_pieces((pictures, background, known), places, (shape, margin))
        mean = median_of(pieces)
        cut = _own_part(mean, shape, margin, fence)
        if cut is None:
            return None
        moved = {k: _plus(place, cut.corner) for k, place in places.items()}
        places, agreement = _registered(pictures, moved, cut.outline)
        corner, shape = _plus(corner, cut.corner), cut.outline.sprite.shape
        margin = _margin(shape, rough)
    if cut is None or len(places) < SIGHTINGS_AT_LEAST or shape[0] * shape[1] > largest:
        return None
    return _body(cut.outline, rough.path_px, places, (corner, agreement))


def _margin(shape: tuple[int, int], rough: Rough) -> tuple[int, int]:
    """Rows and columns around a box of this shape that are averaged too."""
    around = SURROUNDINGS * max(shape)
    ends = 0.0 if rough.blurred or shape[1] > shape[0] else ENDS_APART * shape[0]
    return round(around), round(max(around, ends))


@dataclass(frozen=True)
class _Cut:
    """A body cut out of the mean of the pieces."""

    outline: Outline
    corner: tuple[int, int]
    """Column and row of the box that was asked for at which its template begins."""


def _own_part(
    mean: Mean, shape: tuple[int, int], margin: tuple[int, int], fence: tuple[float, float]
) -> _Cut | None:
    """Cut out what moves with the body and hangs together with its box; None if nothing does.

    ``mean`` is that of the box, of this shape, with a margin all around.
    """
    own = _connected(mean.moving, shape, margin)
    if own is None:
        return None
    rows, columns = (np.flatnonzero(own.any(axis=axis)) for axis in (1, 0))
    top, bottom = max(0, int(rows[0]) - EDGE_PX), int(rows[-1]) + EDGE_PX + 1
    left, right = max(0, int(columns[0]) - EDGE_PX), int(columns[-1]) + EDGE_PX + 1
    part = Mean(
        mean.appearance[top:bottom, left:right],
        mean.variance[top:bottom, left:right],
        own[top:bottom, left:right],
    )
    begin = left - margin[1]
    outline = find_outline(part, (fence[0] - begin, fence[1] - begin))
    if outline is None:
        return None
    return _Cut(outline, (begin + outline.begin_px, top - margin[0]))


def _connected(
    moving: NDArray[np.bool_], shape: tuple[int, int], margin: tuple[int, int]
) -> NDArray[np.bool_] | None:
    """Part of what moves with a body that hangs together with its box, without threads."""
    width = max(NEIGHBOURHOOD_PX + 4, round(THREAD_SHARE * min(shape))) | 1
    kernel = np.ones((width, width), np.uint8)
    gap = np.ones([round(share * min(shape)) | 1 for share in GAP_SHARES], np.uint8)
    whole = cv2.morphologyEx(moving.astype(np.uint8), cv2.MORPH_CLOSE, gap)
    opened = cv2.morphologyEx(whole, cv2.MORPH_OPEN, kernel)
    _, labels = cv2.connectedComponents(opened)
    box = tuple(slice(begin, begin + size) for begin, size in zip(margin, shape, strict=True))
    inner = labels[box]
    held = np.bincount(inner.ravel(), minlength=max(2, int(labels.max()) + 1))
    held[0] = 0
    if not held.any():
        return None
    parts = np.flatnonzero(held > PART_SHARE * held.max()).tolist()
    if shape[1] <= shape[0]:
        main = labels == np.argmax(held)
        rows, columns = main.any(axis=1), main.any(axis=0)
        beside = np.setdiff1d(labels[rows], np.append(labels[:, columns], 0)).tolist()
        parts += [k for k in beside if (labels[rows] == k).any(axis=1).mean() > AS_HIGH_SHARE]
    own = _without_threads(np.isin(labels, parts), box)
    return np.asarray((cv2.dilate(own.astype(np.uint8), kernel) > 0) & moving)


def _without_threads(own: NDArray[np.bool_], box: tuple[slice, ...]) -> NDArray[np.bool_]:
    """Keep the rows about the widest one of the box that are nearly as wide."""
    last = own.shape[1] - np.argmax(own[:, ::-1], axis=1)
    wide = np.where(own.any(axis=1), last - np.argmax(own, axis=1), 0)
    inner = wide[box[0]]
    middle = box[0].start + int(np.argmax(inner))
    narrow = np.flatnonzero(wide < WIDE_ROWS * inner.max())
    begin = int(narrow[narrow < middle].max(initial=-1)) + 1
    end = int(narrow[narrow > middle].min(initial=len(wide)))
    kept = np.zeros_like(own)
    kept[begin:end] = own[begin:end]
    return kept


def _aligned(
    pictures: Mapping[int, Luma], places: Mapping[int, Place], shape: tuple[int, int]
) -> dict[int, Place]:
    """Places that are right to some px, made better by registration to one of the pieces."""
    if not places:
        return {}
    height, width = shape
    weight = np.zeros(shape, dtype=np.float32)
    y, x = np.indices(weight.shape)
    across, along = (height - 1) / 2, (width - 1) / 2
    weight[((y - across) / across) ** 2 + ((x - along) / along) ** 2 < 1] = 1.0
    best: dict[int, Place] = {}
    for first in sorted(places)[len(places) // 4 :: max(1, len(places) // 4)]:
        sprite = make_sprite(look(pictures[first], *places[first], (height, width)), weight)
        fits = {k: register(pictures[k], sprite, place) for k, place in places.items()}
        good = {
            k: (fit.x_px, fit.y_px)
            for k, fit in fits.items()
            if fit is not None and fit.agreement > AGREEMENT_AT_LEAST
        }
        best = max(best, good, key=len)
    return best


def _body(
    outline: Outline,
    path: Mapping[int, Place],
    places: Mapping[int, Place],
    corner_and_agreement: tuple[Place, float],
) -> Body:
    corner, agreement = corner_and_agreement
    away = np.array([np.subtract(places[k], _plus(path[k], corner)) for k in places])
    drift = np.median(away, axis=0)
    rough = {
        k: _plus(place, (corner[0] + drift[0], corner[1] + drift[1])) for k, place in path.items()
    }
    sightings = rough | dict(places)
    return Body(
        outline.sprite,
        outline.left_px,
        outline.right_px,
        outline.round_ or _as_high_as_wide(outline),
        sightings,
        tuple(sorted(places)),
        agreement,
    )


def _as_high_as_wide(outline: Outline) -> bool:
    """Whether the rows at least half as wide as the outline are as many as a circle has.

    A circle's chords are longer than its radius over 0.87 of its diameter; the edge's blur, which
    the template holds as well, adds some px. Threads are narrow and add none.
    """
    held = outline.sprite.weight > 0
    last = held.shape[1] - np.argmax(held[:, ::-1], axis=1)
    wide = np.where(held.any(axis=1), last - np.argmax(held, axis=1), 0)
    width = outline.right_px - outline.left_px
    high = float(np.count_nonzero(wide >= 0.5 * width))
    return ROUND_HEIGHT[0] * width < high < ROUND_HEIGHT[1] * width


def _plus(place: Place, corner: tuple[float, float]) -> Place:
    return place[0] + corner[0], place[1] + corner[1]


def _some(rarity: Mapping[int, float], shape: tuple[int, int]) -> list[int]:
    """Pictures to learn from, evenly spread over the clip by their rarity."""
    count = int(np.clip(PIXELS // (shape[0] * shape[1]), PICTURES_AT_LEAST, PICTURES))
    frames = sorted(rarity)
    if len(frames) <= count:
        return frames
    share = np.cumsum([rarity[frame] for frame in frames])
    picked = np.searchsorted(share, (np.arange(count) + 0.5) / count * share[-1])
    return [frames[place] for place in np.unique(picked)]


def _rarity(path: Mapping[int, Place], others: Sequence[Mapping[int, Place]]) -> dict[int, float]:
    """Weight of each picture: rare places and rare distances from other bodies count more."""
    bins = [{k: round(x / PLACE_BIN_PX) for k, (x, _) in path.items()}]
    for other in others:
        apart = {k: other[k][0] - x for k, (x, _) in path.items() if k in other}
        bins.append({k: round(x / PLACE_BIN_PX) for k, x in apart.items()})
    counts = [Counter(binned.values()) for binned in bins]
    return {
        k: float(np.prod([1 / c[b[k]] for b, c in zip(bins, counts, strict=True) if k in b]))
        for k in path
    }


def _registered(
    pictures: Mapping[int, Luma], places: Mapping[int, Place], outline: Outline
) -> tuple[dict[int, Place], float]:
    """Places of the template, registered in the pictures, and the median agreement."""
    fits = {k: register(pictures[k], outline.sprite, place) for k, place in places.items()}
    good = {
        k: fit
        for k, fit in fits.items()
        if fit and fit.agreement >= AGREEMENT_AT_LEAST and fit.inside >= INSIDE_AT_LEAST
    }
    if not good:
        return {}, 0.0
    typical = float(np.median([fit.agreement for fit in good.values()]))
    kept = {k: fit for k, fit in good.items() if fit.agreement > AGREEMENT_SHARE * typical}
    return {k: (fit.x_px, fit.y_px) for k, fit in kept.items()}, typical


def line_tilt_deg(paths: Sequence[Floats]) -> float:
    """Find the common direction of paths, shape (n, 2) each, in (-90, 90] degrees from image x."""
    moments = np.zeros((2, 2))
    for path in paths:
        known = path[np.isfinite(path[:, 0])]
        away = known - known.mean(axis=0)
        moments += away.T @ away
    return float(np.degrees(0.5 * np.arctan2(2 * moments[0, 1], moments[0, 0] - moments[1, 1])))

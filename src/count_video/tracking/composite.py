"""Pieces of pictures laid upon each other: their median, and which pixels move with a body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.background import Background
from count_video.tracking.outline import Mean
from count_video.tracking.shape import Place, Shape, hidden
from count_video.tracking.sprite import Pixels

Luma = NDArray[np.uint8]

SHOWN_AT_LEAST, SHOWN_PICTURES = 0.15, 4
"""A pixel is learnt only if nothing hides it in more than this share, and number, of pictures: of
fewer, the median is always near."""
ROUNDING = 0.3
"""Grey levels by which bytes differ from what they stand for, as a standard deviation."""
NOISE_FLOOR = 0.25
"""Variance in grey levels squared that every pixel has at least (rounding, compression)."""
MOST, MOST_SIGMAS = 0.65, 0.935
"""Pieces agree if this share of them does: a neighbour stands at one distance in many pictures, but
not in most. Of normal noise, that share lies within so many standard deviations."""
NOISE_STRIDE = 4
"""Noise is told by every fourth pixel of every fourth row."""
MEDIAN_TO_SIGMA = 1.4826
CUT_SIGMAS, CUT_LEVELS = 6.0, 10.0
"""Mistakes larger than so many standard deviations and grey levels count as such ones."""
NEIGHBOURHOOD_PX, COVERED_RATIO = 5, 1.25
"""A pixel moves with the body if the pieces differ from what lies behind it by this many times as
much as from their median, over a neighbourhood of this side."""


@dataclass(frozen=True)
class Pieces:
    """Pieces of n pictures, laid upon each other; arrays have shape (n, height, width)."""

    seen: Pixels
    behind: Pixels
    """What lies behind the body there: the background with the bodies that are known."""
    covered: NDArray[np.bool_]
    """Where a piece shows nothing: beyond its picture, or where something of unknown look is."""
    others: NDArray[np.bool_]
    """Where bodies that are known are."""
    around: tuple[tuple[int, int], tuple[int, int]]
    """Rows above and below, columns before and after, that no picture shows: left out here."""

    @property
    def least(self) -> float:
        """A pixel that is not covered in more pictures than this is learnt."""
        return max(SHOWN_AT_LEAST * len(self.seen), SHOWN_PICTURES)


def cut_pieces(
    source: tuple[Mapping[int, Luma], Background, Sequence[Shape]],
    places: Mapping[int, Place],
    shape_and_margin: tuple[tuple[int, int], tuple[int, int]],
) -> Pieces:
    """Cut pieces out of pictures at these places, with a margin of some rows and columns around."""
    pictures, background, known = source
    (height, width), margin = shape_and_margin
    corners = np.array(list(places.values())) - margin[::-1]
    size = background.luma.shape
    columns, rows = (
        _shown(corners[:, axis], length + 2 * margin[1 - axis], size[1 - axis])
        for axis, length in enumerate((width, height))
    )
    shape = height + 2 * margin[0] - sum(rows), width + 2 * margin[1] - sum(columns)
    boxes = [one for one in known if one.sprite is None]
    seen, behind, covered, others = [], [], [], []
    for frame, inner in places.items():
        place = inner[0] + (columns[0] - margin[1]), inner[1] + (rows[0] - margin[0])
        beyond = _outside(place, shape, pictures[frame].shape)
        back = background.behind(frame, place, shape)
        body = [one.paint(back, frame, place) for one in known if one.sprite is not None]
        seen.append(background.levelled(pictures[frame], frame, place, shape))
        behind.append(back)
        covered.append(beyond | (hidden(boxes, frame, place, shape) > 0))
        others.append(np.logical_or.reduce([np.zeros(shape, np.bool_), *body]))
    arrays = [np.array(one) for one in (seen, behind, covered, others)]
    return Pieces(arrays[0], arrays[1], arrays[2], arrays[3], (rows, columns))


def _shown(begins: Floats, length: int, size: int) -> tuple[int, int]:
    """How many px at both ends of pieces lie beyond all pictures of this size."""
    before = int(np.clip(np.floor(-begins.max()), 0, length - 1))
    after = int(np.clip(np.floor(length - size + begins.min()), 0, length - 1 - before))
    return before, after


def median_of(pieces: Pieces) -> Mean:
    """Median and variance of pieces, and which pixels move with the body.

    A pixel moves with the body if the median explains the pieces better than what lies behind it
    does. Mistakes beyond what noise makes count alike, so that what passes by in a few pictures
    decides nothing.
    """
    hidden_by = pieces.covered | pieces.others
    often = (~hidden_by).sum(axis=0) > pieces.least
    free = np.where(often, hidden_by, pieces.covered)
    typical = _quantile(pieces.seen, free, 0.5)
    inner, outer = np.abs(pieces.seen - typical), np.abs(pieces.seen - pieces.behind)
    most = np.float32(_largest_mistake(inner, outer, free))
    own, still = (_mean(np.minimum(one, most), pieces.covered) for one in (inner, outer))
    size = NEIGHBOURHOOD_PX, NEIGHBOURHOOD_PX
    moving = cv2.blur(still, size) > COVERED_RATIO * (cv2.blur(own, size) + ROUNDING)
    shown = (~pieces.covered).sum(axis=0) > pieces.least
    variance = (_quantile(inner, free, MOST) / MOST_SIGMAS) ** 2 + NOISE_FLOOR
    return Mean(
        np.pad(typical, pieces.around),
        np.pad(variance, pieces.around, constant_values=NOISE_FLOOR),
        np.pad(moving & shown, pieces.around),
    )


def _largest_mistake(inner: Pixels, outer: Pixels, covered: NDArray[np.bool_]) -> float:
    """Grey levels that noise does not exceed, by the better of two explanations of each pixel."""
    some = (slice(None), slice(None, None, NOISE_STRIDE), slice(None, None, NOISE_STRIDE))
    usual = [_quantile(one[some], covered[some], 0.5) for one in (inner, outer)]
    return max(CUT_SIGMAS * MEDIAN_TO_SIGMA * float(np.median(np.minimum(*usual))), CUT_LEVELS)


def _outside(place: Place, shape: tuple[int, int], picture: tuple[int, ...]) -> NDArray[np.bool_]:
    """Mark what of a piece lies beyond the border of its picture."""
    x, y = place[0] + np.arange(shape[1]), place[1] + np.arange(shape[0])
    beyond_x, beyond_y = (
        (at < 0) | (at > size - 1) for at, size in ((x, picture[1]), (y, picture[0]))
    )
    return np.asarray(beyond_y[:, None] | beyond_x[None, :])


def _mean(values: Pixels, covered: NDArray[np.bool_]) -> Pixels:
    """Mean over the pictures in which a pixel is not covered, shape (height, width); else 0."""
    count = np.maximum((~covered).sum(axis=0), 1)
    return np.asarray((values * ~covered).sum(axis=0) / count, np.float32)


def _quantile(values: Pixels, covered: NDArray[np.bool_], share: float) -> Pixels:
    """Quantile over the pictures in which a pixel is not covered, shape (height, width); else 0."""
    ordered = np.sort(np.where(covered, np.float32(np.inf), values), axis=0)
    count = len(values) - covered.sum(axis=0)
    place = np.minimum((share * count).astype(np.intp), len(values) - 1)
    found = np.take_along_axis(ordered, place[None], axis=0)[0]
    return np.where(np.isfinite(found), found, np.float32(0)).astype(np.float32)

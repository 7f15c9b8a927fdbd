"""Pieces of pictures laid upon each other: their median, and which pixels move with a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache, partial

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Indices, Mask, Pixels, Point
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.background import Background
from count_video.tracking.medians import of_rank
from count_video.tracking.outline import Mean
from count_video.tracking.sequences import Lumas, Made
from count_video.tracking.shape import Shape, hidden
from count_video.video.pictures import reduced

Levels = NDArray[np.int16]
"""Smoothed brightness in steps of a grey level: half the bytes of floats, and sorted faster."""

Shifts = Indices
"""Whole px by y and x, shape (pictures, 2); FAR where they are not known."""
FAR = 10_000
"""Px that no picture has."""

STEPS = 64
"""Of a grey level: far below the rounding of the pictures."""
LAST = np.int16(np.iinfo(np.int16).max)
STRIP_PIXELS = 200_000
"""So many pixels of all pieces are laid upon each other at a time: they stay in the cache."""

REDUCED_BYTES = 8_000_000
"""Reduced pictures are kept up to so many bytes of each scale."""
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
"""Noise is measured in every fourth pixel of every fourth row."""
CUT_SIGMAS, CUT_LEVELS = 6.0, 10.0
"""Mistakes larger than so many standard deviations and grey levels count as such ones."""
NEIGHBOURHOOD_PX, COVERED_RATIO = 5, 1.25
"""A pixel moves with the body if the pieces differ from what lies behind it by this many times as
much as from their median, over a neighbourhood of this side in the pictures as they are."""


@dataclass(frozen=True)
class Source:
    """What bodies are cut out of."""

    pictures: Lumas
    """Samples, each of shape (height, width)."""
    background: Background
    known: Sequence[Shape] = ()
    """What hides a body in some pictures."""
    neighbours: Sequence[Floats] = ()
    """Paths of others that move otherwise: image x and y of one of their points, shape (samples,
    2); NaN where it is not seen. What they explain better is not the body's."""
    reduced_before: dict[int, Made] = field(default_factory=dict)
    """The pictures reduced by a scale; the last ones that were read are kept."""

    def reduced(self, scale: int) -> Source:
        """Reduce the pictures, and what is known of them."""
        if scale == 1:
            return self
        at_most = 1 + REDUCED_BYTES * scale**2 // self.background.luma.size
        kept = lru_cache(at_most)(lambda place: reduced(self.pictures[place], scale))
        small = self.reduced_before.setdefault(scale, Made(kept))
        known = [one.reduced(scale) for one in self.known]
        paths = [path / scale for path in self.neighbours]
        return Source(small, self.background.reduced(scale), known, paths)


@dataclass(frozen=True)
class Pieces:
    """Pieces of n pictures, laid upon each other; arrays have shape (n, height, width)."""

    seen: Levels
    behind: Levels
    """What lies behind the body there: the background with the bodies that are known."""
    covered: Mask
    """Where a piece shows nothing: beyond its picture, or where something unknown is."""
    others: Mask
    """Where bodies that are known are."""
    around: tuple[tuple[int, int], tuple[int, int]]
    """Rows above and below, columns before and after, that no picture shows: left out here."""
    away: Sequence[Shifts]
    """How far each neighbour is from its usual place beside the body."""

    @property
    def least(self) -> float:
        """A pixel that is not covered in more pictures than this is learnt."""
        return max(SHOWN_AT_LEAST * len(self.seen), SHOWN_PICTURES)


def cut_pieces(
    source: Source, places_px: Floats, inner: tuple[int, int], margin: tuple[int, int]
) -> Pieces:
    """Cut pieces out of samples, with a margin of some rows and columns around an inner part.

    ``places_px`` is image x and y of the inner part's top left pixel, shape (samples, 2); NaN for
    the samples that are left out. ``inner`` is the shape of that part.
    """
    background, known = source.background, source.known
    height, width = inner
    samples = np.flatnonzero(np.isfinite(places_px[:, 0]))
    corners = places_px[samples] - margin[::-1]
    size = background.luma.shape
    columns, rows = (
        _shown(corners[:, axis], length + 2 * margin[1 - axis], size[1 - axis])
        for axis, length in enumerate((width, height))
    )
    shape = height + 2 * margin[0] - sum(rows), width + 2 * margin[1] - sum(columns)
    boxes = [one for one in known if one.appearance is None]
    bodies = [one for one in known if one.appearance is not None]
    seen, behind = (np.empty((len(samples), *shape), np.int16) for _ in range(2))
    covered, others = (np.zeros((len(samples), *shape), np.bool_) for _ in range(2))
    begins = (places_px[samples] + np.subtract((columns[0], rows[0]), margin[::-1])).tolist()
    for number, (sample, (x, y)) in enumerate(zip(samples.tolist(), begins, strict=True)):
        picture, place = source.pictures[sample], (x, y)
        back = background.behind(sample, place, shape)
        for one in bodies:
            others[number] |= one.paint(back, sample, place)
        seen[number] = _levels(background.levelled(picture, sample, place, shape))
        behind[number] = _levels(back)
        covered[number] = _outside(place, shape, size)
        covered[number] |= hidden(boxes, sample, place, shape) > 0
    away = [_away(places_px[samples], path[samples]) for path in source.neighbours]
    return Pieces(seen, behind, covered, others, (rows, columns), away)


def _away(path_px: Floats, other_px: Floats) -> Shifts:
    """How far another body is from its usual place beside a body, by their paths."""
    apart, shifts = other_px - path_px, np.full(path_px.shape, FAR)
    known = np.isfinite(apart[:, 0])
    if known.any():
        away = apart[known] - np.median(apart[known], axis=0)
        shifts[known] = np.rint(away[:, ::-1])
    return shifts


def _levels(piece: Pixels) -> Levels:
    """Turn grey levels into steps; a dim picture that is brightened much has white beyond them."""
    # One pass of OpenCV rounds, and stops at LAST.
    return np.asarray(cv2.addWeighted(piece, STEPS, piece, 0.0, 0.0, dtype=cv2.CV_16S), np.int16)


def _shown(begins: Floats, length: int, size: int) -> tuple[int, int]:
    """How many px at both ends of pieces lie beyond all pictures of this size."""
    before = int(np.clip(np.floor(-begins.max()), 0, length - 1))
    after = int(np.clip(np.floor(length - size + begins.min()), 0, length - 1 - before))
    return before, after


def median_of(pieces: Pieces, scale: int = 1) -> Mean:
    """Median and variance of pieces, and which pixels move with the body.

    A pixel moves with the body if the median explains the pieces better than what lies behind it
    does. Mistakes beyond what noise makes count alike, so that what passes by in a few pictures
    decides nothing.
    """
    often = len(pieces.seen) - _count(pieces.covered | pieces.others) > pieces.least
    free = pieces.covered | (pieces.others & often)
    height, width = often.shape
    typical, variance, through = np.empty((3, height, width), np.float32)
    own, still = np.empty((2, height, width), np.float32)
    step = max(1, STRIP_PIXELS // (width * len(pieces.seen)))
    strips = [slice(top, top + step) for top in range(0, height, step)]
    for rows in strips:
        typical[rows] = _quantile(pieces.seen[:, rows], free[:, rows], 0.5)
    most = _largest_mistake(pieces, _levels(typical), free)
    theirs = [cache(partial(_less_mistaken, pieces, typical, most, away)) for away in pieces.away]
    for rows in strips:
        away = pieces.seen[:, rows] - _levels(typical[rows])
        through[rows] = _shown_through(away, pieces.behind[:, rows], free[:, rows])
        inner = np.abs(away)
        outer = np.abs(pieces.seen[:, rows] - pieces.behind[:, rows])
        own[rows], still[rows] = (
            _mean(np.minimum(one, most), pieces.covered[:, rows]) for one in (inner, outer)
        )
        variance[rows] = (_quantile(inner, free[:, rows], MOST) / MOST_SIGMAS) ** 2 + NOISE_FLOOR
    size = round(NEIGHBOURHOOD_PX / scale) | 1, round(NEIGHBOURHOOD_PX / scale) | 1
    moving = cv2.blur(still, size) > COVERED_RATIO * (cv2.blur(own, size) + ROUNDING)
    moving &= len(pieces.seen) - _count(pieces.covered) > pieces.least
    del free, own, still  # large pieces take much memory
    behind = np.asarray(pieces.behind.mean(axis=0, dtype=np.float32) / STEPS, np.float32)
    return Mean(
        np.pad(typical, pieces.around),
        np.pad(variance, pieces.around, constant_values=NOISE_FLOOR),
        np.pad(moving, pieces.around),
        np.pad(behind, pieces.around),
        np.pad(through, pieces.around),
        theirs,
    )


def _shown_through(away: Levels, behind: Levels, covered: Mask) -> Pixels:
    """Variance that pixels have from what lies behind them, in grey levels squared.

    Beyond a body's blurred edge a share b of what lies behind it shows: its regression coefficient.
    So b^2 times the variance of that is theirs, whatever most of the pieces agree on. Both arrays
    are levels from any that all pieces share.
    """
    hidden = _count(covered)
    count = np.maximum(len(away) - hidden, 1)
    one, other = (np.asarray(each / np.float32(STEPS)) for each in (away, behind - behind[0]))
    if hidden.any():
        one[covered] = other[covered] = 0
    means = one.sum(axis=0) / count, other.sum(axis=0) / count
    power = np.einsum("kij,kij->ij", other, other) - count * means[1] ** 2
    shared = np.einsum("kij,kij->ij", one, other) - count * means[0] * means[1]
    varies = power > count * ROUNDING**2
    squares = np.divide(shared**2, power, out=np.zeros_like(power), where=varies)
    return np.asarray(squares / count, np.float32)


def _less_mistaken(pieces: Pieces, typical: Pixels, most: np.int16, away: Shifts) -> Pixels:
    """By how many grey levels the median of what moves with a neighbour explains pieces better.

    It is that of the pieces moved back by where the neighbour is. Of each pixel those pieces count
    that both medians explain; where these are few, none does it better.
    """
    hidden = pieces.covered | pieces.others
    laid = _moved(np.where(hidden, LAST, pieces.seen), -away)
    unknown = laid == LAST
    mistake = np.minimum(np.abs(laid - _levels(_quantile(laid, unknown, 0.5))), most)
    few = len(laid) - _count(unknown) <= pieces.least
    theirs = _moved(np.where(unknown | few, LAST, mistake), away)
    hidden = theirs == LAST
    own = np.minimum(np.abs(pieces.seen - _levels(typical)), most)
    often = len(laid) - _count(hidden) > pieces.least
    better = np.where(often, _mean(own, hidden) - _mean(theirs, hidden), np.float32(0))
    return np.pad(better, pieces.around)


def _moved(pieces: Levels, shifts: Shifts) -> Levels:
    """Move pieces by whole px; where they show nothing then, they are LAST."""
    size, nearest, beyond = pieces.shape[:0:-1], cv2.INTER_NEAREST, int(LAST)
    matrices = [np.array([[1.0, 0.0, x], [0.0, 1.0, y]]) for y, x in shifts.tolist()]
    moved = [
        cv2.warpAffine(piece, matrix, size, flags=nearest, borderValue=beyond)
        for piece, matrix in zip(pieces, matrices, strict=True)
    ]
    return np.array(moved, np.int16)


def _largest_mistake(pieces: Pieces, typical: Levels, covered: Mask) -> np.int16:
    """Largest that noise makes, by the better of two explanations of each pixel, in levels."""
    some = (slice(None), slice(None, None, NOISE_STRIDE), slice(None, None, NOISE_STRIDE))
    seen = pieces.seen[some]
    usual = [
        _quantile(np.abs(seen - other), covered[some], 0.5)
        for other in (typical[some[1:]], pieces.behind[some])
    ]
    sigma = MEDIAN_TO_SIGMA * float(np.median(np.minimum(*usual)))
    return np.int16(STEPS * max(CUT_SIGMAS * sigma, CUT_LEVELS))


def _outside(place: Point, shape: tuple[int, int], picture: tuple[int, ...]) -> Mask:
    """Mark what of a piece lies beyond the border of its picture."""
    x, y = place[0] + np.arange(shape[1]), place[1] + np.arange(shape[0])
    beyond_x, beyond_y = (
        (at < 0) | (at > size - 1) for at, size in ((x, picture[1]), (y, picture[0]))
    )
    return np.asarray(beyond_y[:, None] | beyond_x[None, :])


def _count(marked: Mask) -> Indices:
    """Count in how many pieces a pixel is marked, shape (height, width)."""
    # Pieces are fewer than 256; sums of bytes take numpy a tenth of those of truth values.
    return np.asarray(marked.view(np.uint8).sum(axis=0, dtype=np.uint8), np.intp)


def _mean(values: Levels, covered: Mask) -> Pixels:
    """Mean where a pixel is not covered, shape (height, width), in grey levels; else 0."""
    hidden = _count(covered)
    if hidden.any():
        values[covered] = 0
    count = STEPS * np.maximum(len(values) - hidden, 1)
    return np.asarray(values.sum(axis=0, dtype=np.int32) / count, np.float32)


def _quantile(values: Levels, covered: Mask, share: float) -> Pixels:
    """Quantile where a pixel is not covered, shape (height, width), in grey levels; else 0."""
    count = len(values) - _count(covered)
    rank = np.minimum((share * count).astype(np.intp), len(values) - 1)
    # Covered ones come last.
    found = of_rank(np.where(covered, LAST, values), rank)
    return np.where(count > 0, found, 0).astype(np.float32) / np.float32(STEPS)

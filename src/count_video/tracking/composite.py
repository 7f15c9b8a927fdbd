"""Pieces of pictures laid upon each other: their median, and which pixels move with a body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, partial

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Indices, Luma, Mask, Pixels
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.background import Background
from count_video.tracking.outline import Mean
from count_video.tracking.shape import Place, Shape, hidden
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

    pictures: Mapping[int, Luma]
    """Frame index -> luma, shape (height, width)."""
    background: Background
    known: Sequence[Shape]
    """What hides a body in some pictures."""
    neighbours: Sequence[Mapping[int, Place]] = ()
    """Paths of others that move otherwise: frame index -> image x and y of one of their points."""
    reduced_before: dict[int, dict[int, Luma]] = field(default_factory=dict)
    """The pictures that were reduced already, by scale and frame index."""

    def reduced(self, scale: int, frames: Sequence[int]) -> Source:
        """Reduce the pictures with these frame indices, and what is known of them."""
        if scale == 1:
            return self
        small = self.reduced_before.setdefault(scale, {})
        small |= {k: reduced(self.pictures[k], scale) for k in frames if k not in small}
        pictures = {k: small[k] for k in frames}
        known = [one.reduced(scale, frames) for one in self.known]
        paths = [
            {k: (x / scale, y / scale) for k, (x, y) in path.items()} for path in self.neighbours
        ]
        return Source(pictures, self.background.reduced(scale, frames), known, paths)


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
    source: Source,
    places: Mapping[int, Place],
    shape_and_margin: tuple[tuple[int, int], tuple[int, int]],
) -> Pieces:
    """Cut pieces out of pictures at these places, with a margin of some rows and columns around."""
    pictures, background, known = source.pictures, source.background, source.known
    (height, width), margin = shape_and_margin
    corners = np.array(list(places.values())) - margin[::-1]
    size = background.luma.shape
    columns, rows = (
        _shown(corners[:, axis], length + 2 * margin[1 - axis], size[1 - axis])
        for axis, length in enumerate((width, height))
    )
    shape = height + 2 * margin[0] - sum(rows), width + 2 * margin[1] - sum(columns)
    boxes = [one for one in known if one.look is None]
    bodies = [one for one in known if one.look is not None]
    seen, behind = (np.empty((len(places), *shape), np.int16) for _ in range(2))
    covered, others = (np.zeros((len(places), *shape), np.bool_) for _ in range(2))
    for number, (frame, inner) in enumerate(places.items()):
        place = inner[0] + (columns[0] - margin[1]), inner[1] + (rows[0] - margin[0])
        back = background.behind(frame, place, shape)
        for one in bodies:
            others[number] |= one.paint(back, frame, place)
        seen[number] = _levels(background.levelled(pictures[frame], frame, place, shape))
        behind[number] = _levels(back)
        covered[number] = _outside(place, shape, pictures[frame].shape)
        covered[number] |= hidden(boxes, frame, place, shape) > 0
    away = [_away(places, path) for path in source.neighbours]
    return Pieces(seen, behind, covered, others, (rows, columns), away)


def _away(places: Mapping[int, Place], path: Mapping[int, Place]) -> Shifts:
    """How far another body is from its usual place beside a body."""
    apart = {k: np.subtract(path[k], place)[::-1] for k, place in places.items() if k in path}
    if not apart:
        return np.full((len(places), 2), FAR)
    usual = np.median(list(apart.values()), axis=0)
    shifts = [np.rint(apart[k] - usual) if k in apart else (FAR, FAR) for k in places]
    return np.array(shifts, np.intp)


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
    typical, variance, own, still = (np.empty((height, width), np.float32) for _ in range(4))
    step = max(1, STRIP_PIXELS // (width * len(pieces.seen)))
    strips = [slice(top, top + step) for top in range(0, height, step)]
    for rows in strips:
        typical[rows] = _quantile(pieces.seen[:, rows], free[:, rows], 0.5)
    most = _largest_mistake(pieces, _levels(typical), free)
    theirs = [cache(partial(_less_mistaken, pieces, typical, most, away)) for away in pieces.away]
    for rows in strips:
        inner = np.abs(pieces.seen[:, rows] - _levels(typical[rows]))
        outer = np.abs(pieces.seen[:, rows] - pieces.behind[:, rows])
        own[rows], still[rows] = (
            _mean(np.minimum(one, most), pieces.covered[:, rows]) for one in (inner, outer)
        )
        variance[rows] = (_quantile(inner, free[:, rows], MOST) / MOST_SIGMAS) ** 2 + NOISE_FLOOR
    size = round(NEIGHBOURHOOD_PX / scale) | 1, round(NEIGHBOURHOOD_PX / scale) | 1
    moving = cv2.blur(still, size) > COVERED_RATIO * (cv2.blur(own, size) + ROUNDING)
    shown = len(pieces.seen) - _count(pieces.covered) > pieces.least
    behind = np.asarray(pieces.behind.mean(axis=0, dtype=np.float32) / STEPS, np.float32)
    return Mean(
        np.pad(typical, pieces.around),
        np.pad(variance, pieces.around, constant_values=NOISE_FLOOR),
        np.pad(moving & shown, pieces.around),
        np.pad(behind, pieces.around),
        theirs,
    )


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
    size = pieces.shape[:0:-1]
    moved = [
        cv2.warpAffine(
            piece,
            np.array([[1.0, 0.0, x], [0.0, 1.0, y]]),
            size,
            flags=cv2.INTER_NEAREST,
            borderValue=int(LAST),
        )
        for piece, (y, x) in zip(pieces, shifts.tolist(), strict=True)
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


def _outside(place: Place, shape: tuple[int, int], picture: tuple[int, ...]) -> Mask:
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
    # Covered ones come last.
    ordered = _sorted(np.where(covered, LAST, values))
    place = np.minimum((share * count).astype(np.intp), len(values) - 1)
    found = np.take_along_axis(ordered, place[None], axis=0)[0]
    return np.where(count > 0, found, 0).astype(np.float32) / np.float32(STEPS)


def _sorted(values: Levels) -> Levels:
    """Sort each pixel's values, in place, by a network of comparisons of whole pieces.

    It takes a tenth of the time of numpy's sort of one pixel after the other.
    """
    spare = np.empty_like(values[0])
    for low, high in _comparisons(len(values)):
        np.minimum(values[low], values[high], out=spare)
        np.maximum(values[low], values[high], out=values[high])
        values[low] = spare
    return values


@cache
def _comparisons(count: int) -> list[tuple[int, int]]:
    """Which values to compare, one after the other, to sort so many (Batcher 1968)."""
    steps = [1 << k for k in range(max(count - 1, 0).bit_length())]
    return [
        (low, low + apart)
        for merged in steps
        for apart in steps[: steps.index(merged) + 1][::-1]
        for begin in range(apart % merged, count - apart, 2 * apart)
        for low in range(begin, min(begin + apart, count - apart))
        if low // (2 * merged) == (low + apart) // (2 * merged)
    ]

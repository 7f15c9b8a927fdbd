"""Medians and other quantiles of pictures laid upon each other, pixel by pixel."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Indices, Luma

Level = TypeVar("Level", np.uint8, np.int16)

ROWS = 64
"""Medians are taken of so many rows at a time: that bounds their memory."""
WHITE = 255


def median_picture(pictures: Sequence[Luma], hidden: Iterable[Luma] = ()) -> Luma:
    """Take the median of each pixel; of an even number the upper one of the middle two.

    Pixels that are marked by ``hidden``, picture by picture, do not count unless all are.
    """
    middle = np.empty(pictures[0].shape, np.uint8)
    packed = [np.packbits(one != 0, axis=1) for one in hidden]  # large pictures take much memory
    for top in range(0, len(middle), ROWS):
        rows = slice(top, top + ROWS)
        levels = np.array([one[rows] for one in pictures])
        rank = np.full(levels.shape[1:], len(levels) // 2)
        if packed:
            bits = np.array([one[rows] for one in packed])
            marks = np.unpackbits(bits, axis=2, count=len(middle[0])).astype(np.bool_)
            marks &= ~marks.all(axis=0)
            levels[marks] = WHITE  # the last of all
            rank = (len(levels) - marks.sum(axis=0)) // 2
        middle[rows] = of_rank(levels, rank)
    return middle


def quantile_of(pictures: Sequence[Luma], share: float) -> float:
    """Level that this share of all pixels of some pictures do not exceed."""
    count = sum(cv2.calcHist([one], [0], None, [WHITE + 1], [0, WHITE + 1]) for one in pictures)
    total = np.cumsum(count, dtype=np.float64)
    return float(np.searchsorted(total, share * total[-1]))


def of_rank(values: NDArray[Level], rank: Indices) -> NDArray[Level]:
    """Value of each pixel below which so many of its others are; ``values`` may be changed.

    Sorted by a network of comparisons of whole pictures, which takes a tenth of the time of numpy's
    sort of one pixel after the other. Shapes are (n, height, width) and (height, width).
    """
    ordered: list[NDArray[Level]] = list(values)
    spare = np.empty_like(ordered[0])
    for low, high in _comparisons(len(ordered)):
        one, other = ordered[low], ordered[high]
        np.minimum(one, other, out=spare)
        np.maximum(one, other, out=other)
        ordered[low], spare = spare, one
    if rank.min() == rank.max():
        return ordered[int(rank.max())]
    return np.asarray(np.take_along_axis(np.array(ordered), rank[None], axis=0)[0], values.dtype)


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

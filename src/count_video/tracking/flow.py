"""Pictures made ready for following small features, and one step of following them.

Features are followed by pyramidal Lucas-Kanade registration (Bouguet 2001, as in OpenCV), which
takes for granted that a point keeps its brightness. Lamps that flicker break that, so every
picture is brought to the brightness of the first one beforehand.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

Luma = NDArray[np.uint8]

WIDTH_FOR_SEARCH_PX = 900
"""Wider pictures are halved for the search; positions are measured later at full size."""
WINDOW_PX = 11
PYRAMID_LEVELS = 2
BLOCKS = (16, 9)
"""Brightness is compared over so many blocks: the median block shows the lamps, not the bodies."""
FLICKER_AT_LEAST = 0.01
"""Smaller changes of brightness are left as they are."""


def prepare(lumas: Sequence[Luma], *, close: bool = False) -> tuple[list[Luma], float]:
    """Halve wide pictures, smooth them a little and level out the flicker of lamps.

    ``close`` makes them twice as large as usual: beside a body that is no larger than the window,
    what is followed is mostly its surroundings.

    Returns
    -------
    tuple
        The pictures, and how many px of the originals one of their px holds.
    """
    scale = 1.0
    pictures = [np.ascontiguousarray(luma) for luma in lumas]
    while pictures[0].shape[1] / scale > WIDTH_FOR_SEARCH_PX:
        scale *= 2.0
    scale = scale / 2 if close else scale
    if scale != 1.0:
        size = (int(pictures[0].shape[1] / scale), int(pictures[0].shape[0] / scale))
        way = cv2.INTER_AREA if scale > 1.0 else cv2.INTER_CUBIC
        pictures = [as_bytes(cv2.resize(p, size, interpolation=way)) for p in pictures]
    smooth = [as_bytes(cv2.GaussianBlur(p, (0, 0), 0.8)) for p in pictures]
    return _levelled(smooth), scale


def _levelled(pictures: Sequence[Luma]) -> list[Luma]:
    """Bring pictures to the brightness of the first."""
    blocks = [_blocks(picture) for picture in pictures]
    gains = [float(np.median(blocks[0] / seen)) for seen in blocks]
    return [
        as_bytes(cv2.convertScaleAbs(picture, alpha=gain))
        if abs(gain - 1) > FLICKER_AT_LEAST
        else picture
        for picture, gain in zip(pictures, gains, strict=True)
    ]


def _blocks(picture: Luma) -> NDArray[np.float64]:
    """Mean brightness of coarse blocks, in grey levels above 0."""
    return np.asarray(cv2.resize(picture, BLOCKS, interpolation=cv2.INTER_AREA), float) + 1.0


def flow(
    before: Luma, after: Luma, points: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Follow points, shape (n, 1, 2), from one picture to the next; which of them were found."""
    window = (WINDOW_PX, WINDOW_PX)
    moved, found, _ = cv2.calcOpticalFlowPyrLK(
        before, after, points, np.empty(0), winSize=window, maxLevel=PYRAMID_LEVELS
    )
    return np.asarray(moved, dtype=np.float32), np.asarray(found)[:, 0] > 0


def as_bytes(picture: object) -> Luma:
    """Take what OpenCV returns for the array of bytes that it is."""
    return np.asarray(picture, dtype=np.uint8)

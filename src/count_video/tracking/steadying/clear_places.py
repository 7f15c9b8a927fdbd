"""Places to watch for motion: sharp and steady in pictures that were laid upon each other."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.flow import Luma

Plane = NDArray[np.floating]

PLACES_AT_MOST = 24
ACROSS_SHARE = 0.25
"""What slopes across the picture's rows are worth, beside those along: bodies move along."""
CLEAR_AT_LEAST = 0.1
"""Mean squared slope over variance in a window: noise alone leaves 0.04 in a mean of 16 pictures,
and 0.1 over 100 pixels tells a shift to a third of a pixel."""
NOISE_FLOOR = 1.0
"""Variance in grey levels squared that every pixel has at least."""


def clear_places(
    pictures: Sequence[Luma], shifts: Floats, window_px: float
) -> list[tuple[float, float]]:
    """Find places whose surroundings stand out and hardly change, the clearest first.

    Parameters
    ----------
    pictures
        Pictures from all over a clip.
    shifts
        How far each is displaced, shape (pictures, 2), in px.
    window_px
        Width of the surroundings; places lie at least so far apart.
    """
    mean, variance = _laid_together(pictures, shifts)
    slope_y, slope_x = np.gradient(mean)
    worth = (slope_x**2 + ACROSS_SHARE * slope_y**2) / (variance + NOISE_FLOOR)
    size = max(3, round(window_px)) | 1
    score = np.asarray(cv2.blur(worth, (size, size)), dtype=np.float32)
    best = score >= cv2.dilate(score, np.ones((2 * size + 1, 2 * size + 1), np.uint8))
    y, x = np.nonzero(best & (score > CLEAR_AT_LEAST))
    order = np.argsort(-score[y, x])[:PLACES_AT_MOST]
    return [(float(x[place]), float(y[place])) for place in order]


def _laid_together(pictures: Sequence[Luma], shifts: Floats) -> tuple[Plane, Plane]:
    """Mean and variance of pictures, each moved back by its shift."""
    total = np.zeros(pictures[0].shape, dtype=np.float32)
    rows, columns = pictures[0].shape
    squares = np.zeros_like(total)
    for picture, (x, y) in zip(pictures, shifts, strict=True):
        back = np.array([[1.0, 0.0, -x], [0.0, 1.0, -y]])
        steady = cv2.warpAffine(picture, back, (columns, rows), borderMode=cv2.BORDER_REPLICATE)
        cv2.accumulate(steady, total)
        cv2.accumulateSquare(steady, squares)
    mean = total / len(pictures)
    return mean, np.maximum(squares / len(pictures) - mean**2, 0)

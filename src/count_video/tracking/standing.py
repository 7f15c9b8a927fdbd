"""Find what stands still in a clip: windows that are sharp and steady in all pictures.

The background's rough path, from its corners, lays pictures from all over the clip upon each other;
whatever is sharp and hardly changes then stands still, and the camera's motion is measured by it.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.displacement import Shift, measure
from count_video.tracking.landmarks import WINDOW_PX, Landmarks, make_landmarks
from count_video.tracking.sequences import moved_back

Luma = NDArray[np.uint8]
Plane = NDArray[np.floating]

SMOOTHING_PX = 0.8
SEEN_SHARE = 0.7
"""In more of the pictures than this the windows are found again."""
SCATTER_AT_MOST_PX = 0.15
"""Windows of one rigid scene leave their joint shift open by some hundredths of a pixel, by a tenth
where they are faint or compressed. Where it is more, some lie on what moves by itself."""
REFINEMENTS = 3
PLACES_AT_MOST = 24
ACROSS_SHARE = 0.25
"""What slopes across the picture's rows are worth, beside those along: bodies move along."""
CLEAR_AT_LEAST = 0.1
"""Mean squared slope over variance in a window: noise alone leaves 0.04 in a mean of 16 pictures,
and 0.1 over 100 pixels tells a shift to a third of a pixel."""
NOISE_FLOOR = 1.0
"""Variance in grey levels squared that every pixel has at least."""


def landmarks_of(pictures: Sequence[Luma], shifts_px: Floats) -> Landmarks | None:
    """Learn windows that stand still from pictures all over a clip.

    Parameters
    ----------
    pictures
        Some pictures, each of shape (height, width).
    shifts_px
        How far the camera has roughly moved each, by x and y, shape (pictures, 2).

    Returns
    -------
    Landmarks or None
        None where too few are found to measure the camera's motion.
    """
    if len(pictures) < 2:
        return None
    smooth = [np.asarray(cv2.GaussianBlur(one, (0, 0), SMOOTHING_PX), np.uint8) for one in pictures]
    places = clear_places(smooth, shifts_px, WINDOW_PX)
    known = [(float(x), float(y)) for x, y in shifts_px]
    for _ in range(REFINEMENTS):
        landmarks = make_landmarks(places, pictures, known)
        if landmarks is None:
            return None
        measured = [measure(p, landmarks, s) for p, s in zip(pictures, known, strict=True)]
        seen = [(p, s.place) for p, s in zip(pictures, measured, strict=True) if s is not None]
        if len(seen) < SEEN_SHARE * len(pictures):
            return None
        pictures, known = [p for p, _ in seen], [s for _, s in seen]
    return None if _scatter(measured) > SCATTER_AT_MOST_PX else landmarks


def _scatter(shifts: Sequence[Shift | None]) -> float:
    """By how much windows usually leave the shift open, in the direction that shows less of it."""
    sigma = [(shift.sigma_x_px, shift.sigma_y_px) for shift in shifts if shift is not None]
    return float(np.median(sigma, axis=0).max())


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
    squares = np.zeros_like(total)
    for picture, shift in zip(pictures, shifts, strict=True):
        steady = moved_back(picture, shift)
        cv2.accumulate(steady, total)
        cv2.accumulateSquare(steady, squares)
    mean = total / len(pictures)
    return mean, np.maximum(squares / len(pictures) - mean**2, 0)

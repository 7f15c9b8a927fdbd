"""The camera's roll and zoom, which no shift of a picture makes up for.

A hand rolls the camera, and a lens that focuses changes the scale of its picture: corners of the
scenery that are far from each other then move differently. The similarity (Umeyama 1991) that takes
the corners of one sample to their places in another is found by the least median of squares
(Rousseeuw 1984), so that bodies among the corners do not matter. What it turns and scales is
interpolated between the samples, and taken back in every picture; what it shifts is left to
``camera``.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Luma, Pixels
from count_video.signals import interpolated
from count_video.tracking.camera import MEASURED_OF, MOVED_AT_LEAST_PX
from count_video.tracking.corners import Trajectories
from count_video.tracking.rigid import CORNERS_AT_LEAST, RIGID_PX, SCENE_SEEN

RIGID_SHARE = 0.9
"""In this share of the samples half of the corners keep their places in a rigid scene."""
PARTNERS, NEAR_MEDIANS = 3, 4.0
"""Each corner makes pairs with so many others; the scenery strays less than so many times as far as
half of all corners do."""
Turns = NDArray[np.complex128]
"""Similarities without their shifts: absolute values are scales, arguments angles in radians from
x to y."""
SHIFT_FACTOR = 2.0
"""A camera turned if a shift alone leaves corners so many times as far from their places."""


def turned_back(picture: Luma, turn: complex) -> Luma:
    """Turn and scale a picture, shape (height, width), back about its middle.

    Its border goes on.
    """
    height, width = picture.shape
    middle = complex(width - 1, height - 1) / 2
    shift = middle - turn * middle
    there = np.array([[turn.real, -turn.imag, shift.real], [turn.imag, turn.real, shift.imag]])
    flags, border = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP, cv2.BORDER_REPLICATE
    back = cv2.warpAffine(picture, there, (width, height), flags=flags, borderMode=border)
    return np.asarray(back, np.uint8)


def camera_turns(corners: Trajectories, shape: tuple[int, ...]) -> Turns | None:
    """How the camera turned and scaled each sample, shape (samples,); None where it did not.

    The scenery must be rigid but for that, and a shift alone must not describe it as well.
    ``shape`` is that of a sample.
    """
    places = corners.places_px[corners.anywhere]
    if len(places) < CORNERS_AT_LEAST:
        return None
    count = places.shape[1]
    first = places[:, count // 2]
    away = np.nanmax(np.abs(places - first[:, None]), axis=(1, 2))
    if np.median(away) < MOVED_AT_LEAST_PX:
        return None
    few = np.unique(np.linspace(0, count - 1, MEASURED_OF).astype(int))
    for samples in (few, np.arange(count)):
        found = [_similarity(first, there) for there in places[:, samples].swapaxes(0, 1)]
        turns = np.array([turn for turn, _ in found])
        measured = np.isfinite(turns)
        if measured.mean() < SCENE_SEEN:
            return None
        strays_px = np.array([strays for _, strays in found])[measured]
        by_shift, left = np.quantile(strays_px, RIGID_SHARE, axis=0)
        if left > 2 * RIGID_PX or by_shift < SHIFT_FACTOR * left:
            return None  # a few samples say so of most clips
    turns = interpolated(turns.real) + 1j * interpolated(turns.imag)
    turns /= complex(np.median(turns.real), np.median(turns.imag))
    edge_px = np.abs(turns - 1) * float(np.linalg.norm(shape)) / 2
    return turns if edge_px.max() > MOVED_AT_LEAST_PX else None


def _similarity(here: Pixels, there: Pixels) -> tuple[complex, tuple[float, float]]:
    """Turn and scale that take corners, shape (n, 2), to their places in another sample.

    With it comes how far half of the corners stray at most, in px, from where their common shift
    has them, and from where the similarity does. NaN for too few corners.
    """
    known = np.isfinite(here[:, 0]) & np.isfinite(there[:, 0])
    one, other = (part[known, 0] + 1j * part[known, 1].astype(np.float64) for part in (here, there))
    if len(one) < CORNERS_AT_LEAST:
        return complex(np.nan, np.nan), (np.nan, np.nan)
    # As complex numbers: two corners each give a turn, and the best one leaves half of all nearest.
    first = np.tile(np.arange(len(one)), PARTNERS)
    second = (first + np.repeat(np.arange(PARTNERS), len(one)) + 1) % len(one)
    turn = (other[second] - other[first]) / (one[second] - one[first])
    away, gone = (part - part[first][:, None] for part in (one, other))
    apart = np.abs(gone - turn[:, None] * away)
    middle = np.median(apart, axis=1)
    best = int(np.argmin(middle))
    scenery = apart[best] <= NEAR_MEDIANS * middle[best]
    one, other = one - one[scenery].mean(), other - other[scenery].mean()
    product = np.conj(one[scenery]) * other[scenery]
    found = complex(product.sum() / (np.abs(one[scenery]) ** 2).sum())
    moved = other - one
    moved -= complex(np.median(moved.real), np.median(moved.imag))
    return found, (float(np.median(np.abs(moved))), float(np.median(np.abs(other - found * one))))

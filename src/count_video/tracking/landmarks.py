"""What stands still in the picture: small windows around corners of the backdrop and of the wall.

All of them move by one shift when the camera moves. What bodies hide or lend their own edges to is
left out, and no window has more say than its own faults allow: noise, and what encoders and
reflections move it by.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.shape import Box
from count_video.tracking.sprite import REACH_PX, Picture, Pixels, look

WINDOW_PX = 11
SEARCH_PX = 16
"""A knock may move the picture so far from one frame to the next."""
WINDOWS_AT_LEAST = 4
SEEN_SHARE = 0.6
"""Below this share of its usual correlation a window, or the picture, does not show the scenery."""
USUAL = 0.8
"""A window is fully seen in one of five pictures at least: the quantile of its correlations."""
SHOWN_SHARE = 0.7
"""A window that fewer pictures show is hidden too often, or lies on a body that left."""
CLOSEST = 0.999
"""Beyond this correlation pictures are taken to be the same."""
FAULT_PX = 0.05
"""Besides noise, compression and creeping reflections move each window by so much by itself."""


@dataclass(frozen=True)
class Landmarks:
    """Appearance of n windows that stand still; each has p pixels."""

    left: tuple[int, ...]
    top: tuple[int, ...]
    """Top left pixels of the windows in the reference."""
    appearance: Pixels
    """Smoothed luma, mean removed, shape (n, p)."""
    agreement: float
    """Typical correlation of the pictures that it was learnt from with it."""
    slopes: Pixels
    """By x and y, free of what brightness and contrast can do, times the window's say, shape
    (n, 2, p)."""
    normal: Floats
    """What the window has to say: products of the slopes, once times the say, shape (n, 2, 2)."""
    inverse: Floats
    """Pseudo-inverses of ``normal``."""


def make_landmarks(
    corners: Sequence[tuple[float, float]],
    pictures: Sequence[Picture],
    shifts: Sequence[tuple[float, float]],
) -> Landmarks | None:
    """Learn the appearance of windows around corners from pictures with known shifts.

    Corners are places in the unshifted picture. None if too few lie clear of the picture's border
    and are shown by most pictures.
    """
    inside = _inside(corners, pictures[0].shape)
    if len(inside) < WINDOWS_AT_LEAST:
        return None
    shown = _shown(inside, pictures, shifts)
    kept = np.flatnonzero(_lasting(shown))
    if len(kept) < WINDOWS_AT_LEAST:
        return None
    shown = shown[:, kept]
    appearance = _centred(shown.mean(axis=0).reshape(len(kept), -1))
    slopes = _slopes(shown.mean(axis=0), appearance)
    normal = (slopes @ slopes.transpose(0, 2, 1)).astype(np.float64)
    say = _say(normal, _noise(shown, appearance))[:, None, None]
    weighted = np.asarray(say * normal, dtype=np.float64)
    return Landmarks(
        tuple(inside[place][0] for place in kept),
        tuple(inside[place][1] for place in kept),
        appearance.astype(np.float32),
        _usual_agreement(shown, appearance),
        (say * slopes).astype(np.float32),
        weighted,
        np.asarray(np.linalg.pinv(weighted, hermitian=True)),
    )


def _usual_agreement(shown: Pixels, appearance: Pixels) -> float:
    """Median agreement of pictures with what they show on the average."""
    return float(
        np.median(
            [agreement(correlations_of(one.reshape(appearance.shape), appearance)) for one in shown]
        )
    )


def clear_of(landmarks: Landmarks, boxes: Sequence[Box]) -> Landmarks:
    """Leave out the windows that bodies pass over, which are given as boxes that they sweep.

    All of them are kept if too few would be left to tell the camera's motion.
    """
    kept = [
        place
        for place, corner in enumerate(zip(landmarks.left, landmarks.top, strict=True))
        if not any(_overlap(corner, box) for box in boxes)
    ]
    if len(kept) < WINDOWS_AT_LEAST:
        return landmarks
    return replace(
        landmarks,
        left=tuple(landmarks.left[place] for place in kept),
        top=tuple(landmarks.top[place] for place in kept),
        appearance=landmarks.appearance[kept],
        slopes=landmarks.slopes[kept],
        normal=landmarks.normal[kept],
        inverse=landmarks.inverse[kept],
    )


def _overlap(corner: tuple[int, int], box: Box) -> bool:
    x, y = corner
    left, top, right, bottom = box
    return left < x + WINDOW_PX and x < right and top < y + WINDOW_PX and y < bottom


def agreement(correlations: Pixels) -> float:
    """Mean correlation of windows with their appearance, shape (n,).

    Every window counts alike, or a few edges along the motion would outvote those across it.
    """
    return float(correlations.mean())


def evidence(correlations: Pixels) -> float:
    """How much likelier the windows' looks are with than without the scenery, shape (n,).

    It is the mean logarithm of the likelihood ratio, per pixel, for noise of unknown strength. A
    body in front of some windows costs what these had to say and no more; a place at which all of
    them look a little alike gains little.
    """
    each = np.clip(correlations, 0.0, CLOSEST)
    return float(-np.log1p(-np.square(each)).mean()) / 2


def _inside(
    corners: Sequence[tuple[float, float]], shape: tuple[int, ...]
) -> list[tuple[int, int]]:
    """Top left pixels of the windows that stay in the picture when it moves."""
    half, border = WINDOW_PX // 2, WINDOW_PX // 2 + REACH_PX + SEARCH_PX // 2
    rows, columns = shape
    return [
        (round(x) - half, round(y) - half)
        for x, y in corners
        if border <= x < columns - border and border <= y < rows - border
    ]


def _shown(
    places: Sequence[tuple[int, int]],
    pictures: Sequence[Picture],
    shifts: Sequence[tuple[float, float]],
) -> Pixels:
    """Take the windows out of all pictures, shape (pictures, n, WINDOW_PX, WINDOW_PX)."""
    shape = (WINDOW_PX, WINDOW_PX)
    return np.array(
        [
            [look(picture, x + right, y + down, shape) for x, y in places]
            for picture, (right, down) in zip(pictures, shifts, strict=True)
        ]
    )


def _lasting(shown: Pixels) -> NDArray[np.bool_]:
    """Which windows most pictures show, shape (n,)."""
    flat = shown.reshape(*shown.shape[:2], -1)
    each = np.array([correlations_of(one, _centred(flat.mean(axis=0))) for one in flat])
    seen = each > SEEN_SHARE * np.quantile(each, USUAL, axis=0)
    return np.asarray(seen.mean(axis=0) >= SHOWN_SHARE)


def _slopes(mean: Pixels, appearance: Pixels) -> Pixels:
    """Slopes by x and y, free of what brightness and contrast can do, shape (n, 2, p)."""
    slope_y, slope_x = np.gradient(mean, axis=(1, 2))
    slopes = np.stack([slope.reshape(appearance.shape) for slope in (slope_x, slope_y)], axis=1)
    slopes -= slopes.mean(axis=2, keepdims=True)
    power = (appearance**2).sum(axis=1)[:, None, None] + 1e-6
    return np.asarray(slopes - (slopes @ appearance[:, :, None]) / power * appearance[:, None, :])


def _noise(shown: Pixels, appearance: Pixels) -> Floats:
    """Variance of each window's pixels about its appearance, shape (n,).

    It is what is left of them when brightness and contrast have been fitted: noise,
    and the bodies that hide a window for a while and thus taint its appearance.
    """
    seen = _centred(shown.reshape(len(shown), *appearance.shape))
    contrast = (seen * appearance).sum(axis=2) / ((appearance**2).sum(axis=1) + 1e-6)
    left_over = seen - contrast[:, :, None] * appearance
    return np.asarray((left_over**2).mean(axis=(0, 2)), dtype=np.float64)


def _say(normal: Floats, noise: Floats) -> Floats:
    """Weight of each window: the usual noise over its own, and over what its fault amounts to.

    Without the fault the few pixels of a sharp edge would have all the say, though they are off by
    the same hundredths of a pixel as others.
    """
    steepest = np.linalg.eigvalsh(normal)[:, -1]
    return np.asarray(np.median(noise) / (noise + FAULT_PX**2 * steepest + 1e-6))


def correlations_of(seen: Pixels, appearance: Pixels) -> Pixels:
    """Correlation of each window with its appearance; shapes (n, p), the second centred."""
    centred = _centred(seen)
    power = np.einsum("ij,ij->i", centred, centred) * np.einsum("ij,ij->i", appearance, appearance)
    shared = np.einsum("ij,ij->i", centred, appearance)
    return np.asarray(shared / np.sqrt(power + 1e-6))


def _centred(flat: Pixels) -> Pixels:
    return np.asarray(flat - flat.mean(axis=-1, keepdims=True))

"""Find a sprite in a picture when nothing is known of its place, or only roughly.

Normalised cross-correlation of the sprite's box with the picture, at reduced size: a place right
to a few pixels is all that the registration needs.
"""

from __future__ import annotations

import cv2
import numpy as np

from count_video.tracking.peak import peak_of
from count_video.tracking.sprite import Picture, Pixels, Sprite

COARSE_HEIGHT_PX = 28
"""The sprite is reduced until it is about this high."""
FOUND_AT_LEAST = 0.45
"""Correlation below which nothing is said to be found."""
ROWS_OF_SLACK = 0.25
"""The band searched is this much higher than the sprite on either side, as a share of it."""


def search(
    picture: Picture,
    sprite: Sprite,
    near: tuple[float, float],
    slope: float,
    reach_px: float | None = None,
) -> tuple[float, float] | None:
    """Find the sprite along the line of motion; None where nothing like it is there.

    Parameters
    ----------
    picture
        Luma, shape (height, width).
    sprite
        What to look for.
    near
        A place (x, y) where the sprite's top left pixel once was, in px.
    slope
        Rise of the line of motion: change of y by x.
    reach_px
        How far from ``near`` to look along x; None for the whole width.

    Returns
    -------
    tuple of float or None
        Place (x, y) of the sprite's top left pixel, right to a few px.
    """
    height, width = sprite.shape
    reach = float(picture.shape[1]) if reach_px is None else reach_px
    left = int(max(0, near[0] - reach))
    right = int(min(picture.shape[1], near[0] + width + reach))
    rise = abs(slope) * min(reach, picture.shape[1])
    slack = ROWS_OF_SLACK * height + (rise if reach_px is not None else rise / 2)
    top = int(max(0, near[1] - slack))
    bottom = int(min(picture.shape[0], near[1] + height + slack))
    if right - left < width or bottom - top < height:
        return None
    scale = max(1.0, min(height, width) / COARSE_HEIGHT_PX)
    scene = _reduce(picture[top:bottom, left:right], scale)
    pattern = _reduce(sprite.appearance, scale)
    scores: Pixels = np.asarray(
        cv2.matchTemplate(scene, pattern, cv2.TM_CCOEFF_NORMED), dtype=np.float32
    )
    _, best, _, (column, row) = cv2.minMaxLoc(scores)
    if best < FOUND_AT_LEAST:
        return None
    x, y = peak_of(scores[row], column), peak_of(scores[:, column], row)
    return left + x * scale, top + y * scale


def _reduce(picture: Picture | Pixels, scale: float) -> Pixels:
    if scale <= 1.0:
        return picture.astype(np.float32)
    size = (max(1, int(picture.shape[1] / scale)), max(1, int(picture.shape[0] / scale)))
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.float32)

"""What stands out from the scenery in one frame: connected patches with their places and sizes."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.tracking.scenery import Luma, Scenery, difference

AREA_AT_LEAST_PX = 12
"""Smaller patches are noise."""
AREA_SHARE_AT_LEAST = 1e-4
"""Or smaller than this share of the picture."""
BLOBS_AT_MOST = 32
"""Where more stand out, the smaller ones are left out: such a clip shows no body alone."""
BRIDGED_SHARE = 0.012
"""Pieces of one body lie nearer to each other than this share of the picture's width."""


@dataclass(frozen=True)
class Blob:
    """One patch, in px of the shrunk picture."""

    x_px: float
    y_px: float
    """Centre of its area."""
    left_px: float
    top_px: float
    """Corner of the box around it."""
    width_px: float
    height_px: float
    area_px: float
    contrast: float
    """Mean difference from the scenery in grey levels, without its sign."""
    at_border: bool
    """Whether it reaches the picture's border, so that a part of it is not seen."""


@dataclass(frozen=True)
class Sight:
    """All that one frame shows before the scenery."""

    frame: int
    blobs: tuple[Blob, ...]
    covered: float
    """Share of the picture that differs from the scenery."""


def see(frame: int, luma: Luma, scenery: Scenery, levels_at_least: float = 0.0) -> Sight:
    """Find the patches of one shrunk picture, which differ by so many grey levels at least."""
    change = difference(luma, scenery)
    mask = (np.abs(change) > np.maximum(scenery.threshold, levels_at_least)).astype(np.uint8)
    mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, _disc(3)), dtype=np.uint8)
    reach = 2 * max(1, round(BRIDGED_SHARE * mask.shape[1] / 2)) + 1
    closed = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, _disc(reach))
    number, found, stats, centres = cv2.connectedComponentsWithStats(np.asarray(closed))
    labels = np.asarray(found, dtype=np.int32)
    least = max(AREA_AT_LEAST_PX, AREA_SHARE_AT_LEAST * mask.size)
    largest = sorted(range(1, number), key=lambda label: -stats[label][cv2.CC_STAT_AREA])
    blobs = tuple(
        _blob(
            change,
            labels,
            stats[label],
            (label, float(centres[label][0]), float(centres[label][1])),
        )
        for label in largest[:BLOBS_AT_MOST]
        if stats[label][cv2.CC_STAT_AREA] >= least
    )
    return Sight(frame, blobs, float(mask.mean()))


def _disc(size: int) -> NDArray[np.uint8]:
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)), dtype=np.uint8)


def _blob(
    change: NDArray[np.float32],
    labels: NDArray[np.int32],
    stats: NDArray[np.int32],
    place: tuple[int, float, float],
) -> Blob:
    label, x, y = place
    left, top, width, height, area = (int(number) for number in stats[:5])
    rows, columns = labels.shape
    inside = labels[top : top + height, left : left + width] == label
    piece = change[top : top + height, left : left + width]
    return Blob(
        x_px=x,
        y_px=y,
        left_px=float(left),
        top_px=float(top),
        width_px=float(width),
        height_px=float(height),
        area_px=float(area),
        contrast=float(np.abs(piece[inside]).mean()),
        at_border=left <= 1 or top <= 1 or left + width >= columns - 1 or top + height >= rows - 1,
    )

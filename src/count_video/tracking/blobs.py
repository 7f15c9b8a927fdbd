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
RIM_PX = 1
COVERED_SHARE = 0.5
"""Pixels so far within and outside of a patch's outline are covered in part, and wholly from this
share of the patch's contrast on."""


@dataclass(frozen=True)
class Blob:
    """One patch, in px of the shrunk picture."""

    x_px: float
    y_px: float
    """Centre of its area, where each pixel counts by how much of it the body covers."""
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
    parted: bool = False
    """Whether it is told apart from another that it touches, by its end of the patch of both."""


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
    number, found, stats, _ = cv2.connectedComponentsWithStats(np.asarray(closed))
    labels = np.asarray(found, dtype=np.int32)
    least = max(AREA_AT_LEAST_PX, AREA_SHARE_AT_LEAST * mask.size)
    largest = sorted(range(1, number), key=lambda label: -stats[label][cv2.CC_STAT_AREA])
    blobs = tuple(
        _blob(
            change,
            labels,
            stats[label],
            label,
        )
        for label in largest[:BLOBS_AT_MOST]
        if stats[label][cv2.CC_STAT_AREA] >= least
    )
    return Sight(frame, blobs, float(mask.mean()))


def _disc(size: int) -> NDArray[np.uint8]:
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)), dtype=np.uint8)


def _blob(
    change: NDArray[np.float32], labels: NDArray[np.int32], stats: NDArray[np.int32], label: int
) -> Blob:
    left, top, width, height, area = (int(number) for number in stats[:5])
    rows, columns = labels.shape
    box = (
        slice(max(0, top - RIM_PX), top + height + RIM_PX),
        slice(max(0, left - RIM_PX), left + width + RIM_PX),
    )
    inside = labels[box] == label
    piece = np.abs(change[box])
    contrast = float(piece[inside].mean())
    across, down = _centre(piece, inside, contrast)
    return Blob(
        x_px=box[1].start + across,
        y_px=box[0].start + down,
        left_px=float(left),
        top_px=float(top),
        width_px=float(width),
        height_px=float(height),
        area_px=float(area),
        contrast=contrast,
        at_border=left <= 1 or top <= 1 or left + width >= columns - 1 or top + height >= rows - 1,
    )


def _centre(
    piece: NDArray[np.float32], inside: NDArray[np.bool_], contrast: float
) -> tuple[float, float]:
    """Centre along x and y; at the rim a pixel counts in part, within the patch as a whole.

    A pixel that stands out by half of what the patch does is taken for all body, so that what is
    printed on it counts little.
    """
    rim = np.asarray(cv2.dilate(inside.astype(np.uint8), _disc(2 * RIM_PX + 1))) > 0
    core = np.asarray(cv2.erode(inside.astype(np.uint8), _disc(2 * RIM_PX + 1))) > 0
    weight = np.where(core, 1.0, np.clip(piece / (COVERED_SHARE * contrast), 0.0, 1.0)) * rim
    across, down = weight.sum(axis=0), weight.sum(axis=1)
    whole = float(across.sum())
    return (
        float(across @ np.arange(len(across))) / whole,
        float(down @ np.arange(len(down))) / whole,
    )

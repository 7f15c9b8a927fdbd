"""What stands out from the scenery in one frame: connected patches with their places and sizes."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.tracking.patches.scenery import Luma, Scenery, difference

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
class Moments:
    """How the cover of a patch is spread: each pixel counts by how much it stands out."""

    area_px: float
    x_px: float
    y_px: float
    """Centre."""
    xx_px2: float
    xy_px2: float
    yy_px2: float
    """Variances and covariance."""


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
    moments: Moments
    """Of its cover, for patches that two bodies make up together."""


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
    mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, disc(3)), dtype=np.uint8)
    reach = 2 * max(1, round(BRIDGED_SHARE * mask.shape[1] / 2)) + 1
    closed = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, disc(reach))
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


def disc(size: int) -> NDArray[np.uint8]:
    """Return a disc of so many px across, to open and close masks with."""
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
    cover = _cover(piece, inside, contrast)
    core = np.asarray(cv2.erode(inside.astype(np.uint8), disc(2 * RIM_PX + 1))) > 0
    # What is printed on the body may turn with it: only the rim tells the centre.
    whole = _moments(np.where(core, 1.0, cover), (box[1].start, box[0].start))
    return Blob(
        x_px=whole.x_px,
        y_px=whole.y_px,
        left_px=float(left),
        top_px=float(top),
        width_px=float(width),
        height_px=float(height),
        area_px=float(area),
        contrast=contrast,
        at_border=left <= 1 or top <= 1 or left + width >= columns - 1 or top + height >= rows - 1,
        moments=_moments(cover, (box[1].start, box[0].start)),
    )


def _cover(
    piece: NDArray[np.float32], inside: NDArray[np.bool_], contrast: float
) -> NDArray[np.float64]:
    """How much of each pixel a body covers, at the rim of its patch and within."""
    rim = np.asarray(cv2.dilate(inside.astype(np.uint8), disc(2 * RIM_PX + 1))) > 0
    return np.asarray(np.clip(piece / (COVERED_SHARE * contrast), 0.0, 1.0) * rim, dtype=np.float64)


def _moments(cover: NDArray[np.float64], corner: tuple[int, int]) -> Moments:
    across, down = cover.sum(axis=0), cover.sum(axis=1)
    area = float(across.sum())
    x, y = (np.arange(len(sums), dtype=np.float64) for sums in (across, down))
    x -= float(across @ x) / area
    y -= float(down @ y) / area
    return Moments(
        area_px=area,
        x_px=corner[0] - float(x[0]),
        y_px=corner[1] - float(y[0]),
        xx_px2=float(across @ x**2) / area,
        xy_px2=float(y @ cover @ x) / area,
        yy_px2=float(down @ y**2) / area,
    )

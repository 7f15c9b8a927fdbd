"""Moving regions: what differs from the background, linked from sample to sample.

A plain or spinning body has no corners that could be followed, but it hides what lies behind it.
The background is the median of the samples; where a sample differs from it by more than noise,
something moves. Connected regions of like size are linked to paths of the nearest; where two bodies
touch, their regions merge and the paths end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats, Luma
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.medians import quantile_of
from count_video.tracking.rigid import RigidGroup
from count_video.tracking.samples import differences
from count_video.tracking.shape import Part
from count_video.video.pictures import reduced, scale_to

WIDTH_PX = 480
"""Regions are found in pictures no wider than this, and no larger than a square of this side."""
NOISE_OF = 16
"""Noise is measured in so many samples."""
NOISE_SIGMAS, NOISE_LEVELS = 5.0, 3.0
"""A pixel differs from the background by so many standard deviations and grey levels."""
OPENING_PX, CLOSING_PX = 3, 5
"""Fine threads and single pixels are narrower than the first, gaps in a region than the second."""
NARROW_SHARE = 0.3
"""Rows above and below a body in which less of it shows than this share of its widest row are those
of thick threads, on which it hangs; a ball has hardly any."""
AREA_SHARE = 1e-4, 0.25
"""Smallest and largest area of a region as a share of the picture's."""
REGIONS_AT_MOST = 12
SIZE_RATIO = 1.6
"""Width and height of one body change by less than this factor from sample to sample."""
REACH_SIZES = 1.5
"""A region moves by less than this share of its size from sample to sample."""
SAMPLES_AT_LEAST = 6
TRAVEL_SIZES = 0.15
"""A path shorter than this share of the region's size is no motion."""


@dataclass(frozen=True)
class _Path:
    """A region followed from sample to sample."""

    first: int
    regions: list[Floats]
    """Left, top, width, height in px, from the first sample on."""

    def expected(self) -> Floats:
        """Region to expect in the next sample, by the last two."""
        last, before = self.regions[-1], self.regions[-2:][0]
        return np.concatenate([2 * last[:2] - before[:2], last[2:]])


@dataclass(frozen=True)
class Regions:
    """What moves in each sample, in px of the samples."""

    boxes: list[Floats]
    """Left, top, width and height of n regions, sample by sample, shape (n, 4)."""
    changes: list[Luma]
    """Differences from the background, sample by sample, 0 where they are noise."""
    scale: int
    """How many px of the samples one of theirs holds."""

    @property
    def all_change(self) -> float:
        """Sum of the differences, mean over all samples, in grey levels times px."""
        return float(np.mean([cv2.sumElems(one)[0] for one in self.changes]))

    def change(self, path_px: Floats, box_px: Sequence[float]) -> float:
        """Sum of the differences in a box along a path, mean over all samples."""
        total = 0.0
        for place, one in zip(path_px, self.changes, strict=True):
            if np.isfinite(place[0]):
                ends = (np.array(box_px).reshape(2, 2) + place) / self.scale
                left, top, right, bottom = np.rint(ends).astype(int).clip(0).ravel()
                total += cv2.sumElems(one[top:bottom, left:right])[0]
        return total / max(1, len(path_px))


def reduced_for_regions(pictures: list[Luma]) -> tuple[list[Luma], int]:
    """Reduce samples as far as regions allow; they are taken out of the list.

    Together they may be large. Returns them with how many of their px one of the new ones holds.
    """
    height, width = pictures[0].shape
    scale, small = scale_to(max(width, math.isqrt(height * width)), WIDTH_PX), []
    while pictures:
        small.append(reduced(pictures.pop(0), scale))
    return small, scale


def find_regions(
    pictures: Sequence[Luma], scale: int = 1, known: Sequence[Sequence[Part]] = ()
) -> Regions:
    """Find what differs from the median of samples of one brightness, reduced by a scale.

    Parts of each that show what is ``known`` are left out.
    """
    away = differences(pictures, known)
    spread = quantile_of(away[:: max(1, len(away) // NOISE_OF)], 0.5)
    least = max(NOISE_SIGMAS * MEDIAN_TO_SIGMA * spread, NOISE_LEVELS)
    for one in away:
        cv2.threshold(one, least, 0, cv2.THRESH_TOZERO, dst=one)
    for one, parts in zip(away, known, strict=False):
        for part in parts:
            one[part] = 0
    boxes = [_boxes(_mask(one)) * scale for one in away]
    return Regions(boxes, away, scale)


def moving_regions(regions: Regions) -> list[RigidGroup]:
    """Link regions from sample to sample.

    Paths are those of the regions' centres; the corners of the groups are the corners of the
    regions' usual boxes.
    """
    paths: list[_Path] = []
    for sample, boxes in enumerate(regions.boxes):
        going = [path for path in paths if path.first + len(path.regions) == sample]
        paths += [_Path(sample, [box]) for box in _linked(going, boxes)]
    followed = [path for path in paths if len(path.regions) >= SAMPLES_AT_LEAST]
    groups = [_group(path, len(regions.boxes)) for path in followed]
    return [group for group in groups if group is not None]


def _mask(changes: Luma) -> Luma:
    """Mark what differs from the background, without threads and gaps."""
    mask = (changes > 0).astype(np.uint8)
    opening, closing = (np.ones((px, px), np.uint8) for px in (OPENING_PX, CLOSING_PX))
    whole = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, closing)
    return np.asarray(cv2.morphologyEx(whole, cv2.MORPH_OPEN, opening), np.uint8)


def _boxes(mask: Luma) -> Floats:
    """Boxes of n connected regions, the largest first: left, top, width and height, shape (n, 4).

    Their outer borders give them, many times faster than labels of all pixels. Pick's theorem: a
    border through b pixels that encloses an area A holds A + b / 2 + 1 of them, holes included.
    """
    borders, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    area = np.array([cv2.contourArea(one) + len(one) / 2 + 1 for one in borders]) / mask.size
    good = np.flatnonzero((area > AREA_SHARE[0]) & (area < AREA_SHARE[1]))
    largest = good[np.argsort(-area[good], kind="stable")][:REGIONS_AT_MOST]
    boxes = [_without_threads(mask, cv2.boundingRect(borders[place])) for place in largest]
    return np.array(boxes, np.float64).reshape(-1, 4)


def _without_threads(mask: Luma, box: Sequence[int]) -> tuple[int, int, int, int]:
    """Take the rows of threads off a box, and then the columns that show nothing else."""
    left, top, width, height = box
    part = mask[top : top + height, left : left + width]
    shown = part.sum(axis=1, dtype=np.int32)
    rows = np.flatnonzero(shown >= NARROW_SHARE * shown.max())
    first, end = int(rows[0]), int(rows[-1]) + 1
    if end - first == height:
        return left, top, width, height
    columns = np.flatnonzero(part[first:end].any(axis=0))
    begin, stop = int(columns[0]), int(columns[-1]) + 1
    return left + begin, top + first, stop - begin, end - first


def _linked(paths: Sequence[_Path], found: Floats) -> Floats:
    """Let each path go on to the nearest region of like size within reach; returns the others."""
    if not paths or not len(found):
        return found
    expected = np.array([path.expected() for path in paths])[:, None]
    size = expected[:, :, 2:]
    away = np.abs(found[:, :2] - expected[:, :, :2]) + np.abs(found[:, 2:] - size) / 2
    distance = (away / (REACH_SIZES * size)).max(axis=2)
    distance[np.abs(np.log(found[:, 2:] / size)).max(axis=2) > np.log(SIZE_RATIO)] = np.inf
    free = np.ones(len(found), np.bool_)
    for path, row in zip(paths, distance, strict=True):
        best = int(np.argmin(np.where(free, row, np.inf)))
        if free[best] and row[best] < 1.0:
            path.regions.append(found[best])
            free[best] = False
    return found[free]


def _group(path: _Path, count: int) -> RigidGroup | None:
    """Turn what a region does in so many samples into a group; None if it hardly moves."""
    corners, sizes = np.split(np.array(path.regions), 2, axis=1)
    size = np.median(sizes, axis=0)
    centres = np.full((count, 2), np.nan)
    centres[path.first : path.first + len(sizes)] = corners + (sizes - 1) / 2
    if not (np.nanmax(centres, axis=0) - np.nanmin(centres, axis=0) > TRAVEL_SIZES * size).any():
        return None
    signs = np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]])
    return RigidGroup(centres, signs * size / 2, blurred=True)

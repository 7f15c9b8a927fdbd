"""Corner features and their trajectories through sampled pictures of a clip.

Corners (Shi and Tomasi 1994) of a few reference pictures are followed to all other samples, forward
and backward, by pyramidal Lucas-Kanade registration (Bouguet 2001, as in OpenCV). A step counts
only if the way back stays where it began; a corner that fails once is lost from there on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Luma, Mask, Pixels
from count_video.tracking.samples import references
from count_video.tracking.shape import Part

CORNERS = 120
"""Corners of one reference picture."""
QUALITY = 0.0005
"""Corners at least so strong as a share of the strongest: one body may be much fainter than the
other. Those that are noise are lost at once."""
SPACING_PX = 3.0, 12.0
"""Corners lie so far apart: as far as so many fill what moves, for those of a faint body to come in
beside the many of a patterned one."""
BLOCK_PX = 5
SCENE_CORNERS, SCENE_QUALITY, SCENE_ACROSS = 60, 0.002, 25
"""Corners of the whole picture by which a camera's motion shows: so many, at least so strong as a
share of the strongest, and so many of them side by side at most."""
WINDOW_PX = 13
PYRAMID_LEVELS = 3
RETURN_ERROR_PX = 0.4
KNOWN_SHARE = 0.5
"""A corner belongs to a known body if that is where this share of its sightings lie."""


@dataclass(frozen=True)
class Trajectories:
    """Places of n corners in s samples."""

    places_px: Pixels
    """Image x and y, shape (n, s, 2); NaN where a corner was not followed."""
    anywhere: Mask
    """Which corners were taken from the whole picture, moving or not, shape (n,)."""

    @property
    def seen(self) -> Mask:
        """Where a corner was followed, shape (n, s)."""
        return np.asarray(np.isfinite(self.places_px[:, :, 0]))

    def turned_back(self, turns: NDArray[np.complex128], middle: complex) -> Trajectories:
        """Turn and scale each sample back about a point, given as x + iy, by a factor each."""
        apart = self.places_px[:, :, 0] + 1j * self.places_px[:, :, 1] - middle
        places = middle + apart / turns
        both = np.stack([places.real, places.imag], axis=2)
        return Trajectories(both.astype(np.float32), self.anywhere)

    def beside(self, known: Sequence[Sequence[Part]], scale: int) -> Trajectories:
        """Leave out corners that lie mostly in parts of the samples that show what is known.

        ``known`` has them sample by sample, in pictures reduced by a scale.
        """
        count = np.zeros(len(self.places_px))
        for places, parts in zip((self.places_px / scale).transpose(1, 2, 0), known, strict=True):
            held = np.zeros(len(count), np.bool_)
            for rows, columns in parts:
                x, y = places
                inside = (x >= columns.start) & (x < columns.stop)
                held |= inside & (y >= rows.start) & (y < rows.stop)
            count += held
        free = count <= KNOWN_SHARE * self.seen.sum(axis=1)
        return Trajectories(self.places_px[free], self.anywhere[free])


def follow_corners(pictures: Sequence[Luma], moved: Mask) -> Trajectories:
    """Follow corners through samples in which everything moves by a few px from one to the next.

    ``moved`` is where the ``references`` among them show anything that moves, at any size, shape
    (references, rows, columns).
    """
    count = len(pictures)
    begun = references(count)
    corners = [_moving_corners(pictures[k], one) for k, one in zip(begun, moved, strict=True)]
    middle = count // 2
    spacing = pictures[middle].shape[1] / SCENE_ACROSS
    scene = _corners(pictures[middle], SCENE_CORNERS, SCENE_QUALITY, spacing)
    first = np.repeat([*begun, middle], [len(found) for found in (*corners, scene)])
    places = np.full((len(first), count, 2), np.nan, dtype=np.float32)
    places[np.arange(len(first)), first] = np.concatenate([*corners, scene])
    for sample in range(count - 1):
        _step(pictures, places, sample, sample + 1, first <= sample)
    for sample in range(count - 1, 0, -1):
        _step(pictures, places, sample, sample - 1, first >= sample)
    return Trajectories(places, np.arange(len(first)) >= len(first) - len(scene))


def _moving_corners(picture: Luma, moved: Mask) -> Pixels:
    size = picture.shape[1], picture.shape[0]
    mask = cv2.resize(moved.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
    mask = cv2.dilate(mask, np.ones((WINDOW_PX, WINDOW_PX), np.uint8))
    spacing = float(np.clip(np.sqrt(cv2.countNonZero(mask) / CORNERS), *SPACING_PX))
    return _corners(picture, CORNERS, QUALITY, spacing, np.asarray(mask, np.uint8))


def _corners(
    picture: Luma, count: int, quality: float, spacing: float, mask: Luma | None = None
) -> Pixels:
    """Find the strongest corners, or those in a mask, shape (n, 2)."""
    found = cv2.goodFeaturesToTrack(picture, count, quality, spacing, mask=mask, blockSize=BLOCK_PX)
    return np.empty((0, 2), np.float32) if found is None else np.asarray(found, np.float32)[:, 0]


def _step(pictures: Sequence[Luma], places: Pixels, here: int, there: int, meant: Mask) -> None:
    """Follow the corners that are meant and known here to the next picture, in place."""
    known = np.flatnonzero(meant & np.isfinite(places[:, here, 0]))
    if len(known) == 0:
        return
    start = np.ascontiguousarray(places[known, here])
    end, found = _flow(pictures[here], pictures[there], start, start, PYRAMID_LEVELS)
    # Begun where it should lead, the way back needs no coarser pictures.
    back, returned = _flow(pictures[there], pictures[here], end, start, 0)
    good = found & returned & (np.abs(back - start).max(axis=1) < RETURN_ERROR_PX)
    places[known[good], there] = end[good]


def _flow(
    before: Luma, after: Luma, points: Pixels, guess: Pixels, levels: int
) -> tuple[Pixels, Mask]:
    """Places of points, shape (n, 2), in the next picture, and which of them were found."""
    points, guess = (one[:, None].copy() for one in (points, guess))
    size, flags = (WINDOW_PX, WINDOW_PX), cv2.OPTFLOW_USE_INITIAL_FLOW
    end, found, _ = cv2.calcOpticalFlowPyrLK(
        before, after, points, guess, winSize=size, maxLevel=levels, flags=flags
    )
    return np.asarray(end, np.float32)[:, 0], np.asarray(found)[:, 0] > 0

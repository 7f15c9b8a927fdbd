"""Pictures as the stages of following want them: read one by one, or made alike for corners."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Indices, Luma, Mask
from count_video.tracking.medians import quantile_of
from count_video.tracking.samples import Samples
from count_video.video.pictures import reduced, scale_to

Depth = TypeVar("Depth", np.uint8, np.float32)

CORNERS_SIDE_PX = 960
"""Corners are followed in pictures whose longer side is no longer than this."""
SMOOTHING_PX = 0.8
BRIGHT_SHARE, BRIGHTEST_LEVEL, STRETCH_AT_MOST = 0.995, 200.0, 8.0
"""All but few pixels of dark pictures are made as bright as this level, by so much at most."""
BRIGHTNESS_OF = 4
"""It is measured in so many samples."""


@dataclass(frozen=True)
class Cut:
    """How samples are cut out of the pictures of a clip, and reduced."""

    scale: int
    """How many px of the clip's pictures one of theirs holds."""
    corner_px: tuple[int, int]
    """Where they begin in the clip's pictures, by image x and y."""


@dataclass(frozen=True)
class Prepared:
    """Samples cut to where anything moves, small and of one brightness."""

    pictures: list[Luma]
    """Each of shape (height, width)."""
    moved: Mask
    """Where the references differ from the median of all, at any size, shape (references, rows,
    columns)."""
    cut: Cut


class Lumas(Protocol):
    """Pictures of one size, each read when it is asked for: together they may be large."""

    def __getitem__(self, place: int, /) -> Luma:
        """Read a picture, shape (height, width)."""


@dataclass(frozen=True)
class Chosen:
    """Some of the pictures of a clip."""

    pictures: Lumas
    rows: Indices
    """Which, shape (n,)."""

    def __getitem__(self, place: int, /) -> Luma:
        return self.pictures[int(self.rows[place])]


@dataclass(frozen=True)
class Turned:
    """Pictures whose x and y are swapped."""

    pictures: Lumas

    def __getitem__(self, place: int, /) -> Luma:
        return self.pictures[place].T


@dataclass(frozen=True)
class Reduced:
    """Pictures reduced by a scale; they are kept."""

    pictures: Lumas
    scale: int
    kept: dict[int, Luma] = field(default_factory=dict)

    def __getitem__(self, place: int, /) -> Luma:
        if place not in self.kept:
            self.kept[place] = reduced(self.pictures[place], self.scale)
        return self.kept[place]


def prepared(pictures: Sequence[Luma], samples: Samples) -> Prepared:
    """Cut the part of interest out of samples; make them small, and use all levels of a byte."""
    whole, thumbnail = pictures[0].shape, scale_to(pictures[0].shape[1])
    rows, columns = (
        slice(thumbnail * part.start, part.stop and thumbnail * part.stop) for part in samples.part
    )
    scale = scale_to(max(pictures[0][rows, columns].shape), CORNERS_SIDE_PX)

    def cut(place: int) -> Luma:
        return reduced(pictures[place][rows, columns], scale)

    chosen, size = samples.chosen.tolist(), [side / scale for side in whole]
    some = chosen[:: len(chosen) // BRIGHTNESS_OF + 1]
    brightest = max(quantile_of([cut(k)], BRIGHT_SHARE) for k in some)
    stretch = float(np.clip(BRIGHTEST_LEVEL / max(brightest, 1.0), 1.0, STRETCH_AT_MOST))
    corner, small = (columns.start / scale, rows.start / scale), []
    for k, light in zip(chosen, samples.lights, strict=True):
        # Smoothed after it, so that the levels between those of a dark picture are not lost.
        bright = light.unless_faint().levelled(cut(k), stretch, corner, size)
        small.append(np.asarray(cv2.GaussianBlur(bright, (0, 0), SMOOTHING_PX), np.uint8))
    moved = samples.moved[:, samples.part[0], samples.part[1]]
    return Prepared(small, moved, Cut(scale, (columns.start, rows.start)))


def moved_back(picture: NDArray[Depth], shift_px: Sequence[float] | Floats) -> NDArray[Depth]:
    """Move a picture back by the camera's shift along x and y; its border goes on."""
    matrix = np.array([[1.0, 0.0, -shift_px[0]], [0.0, 1.0, -shift_px[1]]])
    size = picture.shape[1], picture.shape[0]
    moved = cv2.warpAffine(
        np.ascontiguousarray(picture), matrix, size, borderMode=cv2.BORDER_REPLICATE
    )
    return np.asarray(moved, picture.dtype)

"""Pictures as the stages of following want them: read one by one, or made alike for corners."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Indices, Luma
from count_video.tracking.medians import quantile_of
from count_video.tracking.samples import Samples
from count_video.video.pictures import Depth, reduced, scale_to

CORNERS_SIDE_PX = 960
"""Corners are followed in pictures whose longer side is no longer than this."""
SMOOTHING_PX = 0.8
BRIGHT_SHARE, BRIGHTEST_LEVEL, STRETCH_AT_MOST = 0.995, 200.0, 8.0
"""All but few pixels of dark pictures are made as bright as this level, by so much at most."""
BRIGHTNESS_OF = 4
"""It is measured in so many samples."""


@dataclass(frozen=True)
class Prepared:
    """Samples cut to where anything moves, small and of one brightness."""

    pictures: list[Luma]
    """Each of shape (height, width)."""
    scale: int
    """How many px of the clip's pictures one of theirs holds."""
    corner_px: tuple[int, int]
    """Where they begin in the clip's pictures, by image x and y."""


class Lumas(Protocol):
    """Pictures of one size, each read when it is asked for: together they may be large."""

    def __getitem__(self, place: int, /) -> Luma:
        """Read a picture, shape (height, width)."""


@dataclass(frozen=True)
class Made:
    """Pictures that are made of others when they are asked for."""

    one: Callable[[int], Luma]

    def __getitem__(self, place: int, /) -> Luma:
        return self.one(place)


def chosen(pictures: Lumas, rows: Indices) -> Made:
    """Take some of the pictures of a clip, by their rows, shape (n,)."""
    return Made(lambda place: pictures[int(rows[place])])


def prepared(pictures: Sequence[Luma], samples: Samples) -> Prepared:
    """Cut the part of interest out of samples; make them small, and use all levels of a byte."""
    whole, thumbnail = pictures[0].shape, scale_to(pictures[0].shape[1])
    rows, columns = (
        slice(thumbnail * part.start, part.stop and thumbnail * part.stop) for part in samples.part
    )
    scale = scale_to(max(pictures[0][rows, columns].shape), CORNERS_SIDE_PX)

    def cut(place: int) -> Luma:
        return reduced(pictures[place][rows, columns], scale)

    taken, size = samples.chosen.tolist(), [side / scale for side in whole]
    some = taken[:: len(taken) // BRIGHTNESS_OF + 1]
    brightest = max(quantile_of([cut(k)], BRIGHT_SHARE) for k in some)
    stretch = float(np.clip(BRIGHTEST_LEVEL / max(brightest, 1.0), 1.0, STRETCH_AT_MOST))
    corner, small = (columns.start / scale, rows.start / scale), []
    for k, light in zip(taken, samples.lights, strict=True):
        # Smoothed after it, so that the levels between those of a dark picture are not lost.
        bright = light.unless_faint().levelled(cut(k), stretch, corner, size)
        small.append(np.asarray(cv2.GaussianBlur(bright, (0, 0), SMOOTHING_PX), np.uint8))
    return Prepared(small, scale, (columns.start, rows.start))


def moved_back(picture: NDArray[Depth], shift_px: Sequence[float] | Floats) -> NDArray[Depth]:
    """Move a picture back by the camera's shift along x and y; its border goes on."""
    if not np.any(shift_px):
        return picture
    matrix = np.array([[1.0, 0.0, -shift_px[0]], [0.0, 1.0, -shift_px[1]]])
    size = picture.shape[1], picture.shape[0]
    moved = cv2.warpAffine(
        np.ascontiguousarray(picture), matrix, size, borderMode=cv2.BORDER_REPLICATE
    )
    return np.asarray(moved, picture.dtype)

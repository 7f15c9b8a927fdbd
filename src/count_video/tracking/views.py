"""Pictures as the stages of following want them: turned, chosen, or made alike for corners."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import overload

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.tracking.samples import Samples

Luma = NDArray[np.uint8]

CORNERS_WIDTH_PX = 960
"""Corners are followed in pictures no wider than this."""
SMOOTHING_PX = 0.8
FLICKER_AT_LEAST = 0.01
"""Smaller changes of brightness are left as they are."""
BRIGHT_SHARE, BRIGHTEST_LEVEL, STRETCH_AT_MOST = 0.995, 200.0, 8.0
"""All but few pixels of dark pictures are made as bright as this level, by so much at most."""
BRIGHTNESS_OF = 4
"""It is measured in so many samples."""


class Turned(Sequence[Luma]):
    """Pictures with x and y swapped."""

    def __init__(self, pictures: Sequence[Luma]) -> None:
        self._pictures = pictures

    def __len__(self) -> int:
        return len(self._pictures)

    @overload
    def __getitem__(self, place: int) -> Luma: ...
    @overload
    def __getitem__(self, place: slice) -> list[Luma]: ...
    def __getitem__(self, place: int | slice) -> Luma | list[Luma]:
        if isinstance(place, slice):
            return [picture.T for picture in self._pictures[place]]
        return self._pictures[place].T


class Chosen(Sequence[Luma]):
    """Some pictures of many."""

    def __init__(self, pictures: Sequence[Luma], chosen: NDArray[np.intp]) -> None:
        self._pictures, self._chosen = pictures, chosen

    def __len__(self) -> int:
        return len(self._chosen)

    @overload
    def __getitem__(self, place: int) -> Luma: ...
    @overload
    def __getitem__(self, place: slice) -> list[Luma]: ...
    def __getitem__(self, place: int | slice) -> Luma | list[Luma]:
        if isinstance(place, slice):
            return [self._pictures[int(k)] for k in self._chosen[place]]
        return self._pictures[int(self._chosen[place])]


class ByFrame(Mapping[int, Luma]):
    """Samples by their frame index, read when they are asked for: together they may be large."""

    def __init__(self, pictures: Sequence[Luma], rows: Mapping[int, int]) -> None:
        self._pictures, self._rows = pictures, rows

    def __getitem__(self, frame: int) -> Luma:
        return self._pictures[self._rows[frame]]

    def __iter__(self) -> Iterator[int]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)


def levelled(pictures: Sequence[Luma], samples: Samples) -> tuple[list[Luma], int]:
    """Bring samples to one width, and to a brightness that uses all levels of a byte.

    Returns how many px of the pictures one of theirs holds as well.
    """
    scale = max(1, -(-pictures[0].shape[1] // CORNERS_WIDTH_PX))
    reduced = [_reduced(pictures[k], scale) for k in samples.chosen]
    some = reduced[:: len(reduced) // BRIGHTNESS_OF + 1]
    brightest = max(float(np.quantile(one, BRIGHT_SHARE)) for one in some)
    stretch = float(np.clip(BRIGHTEST_LEVEL / max(brightest, 1.0), 1.0, STRETCH_AT_MOST))
    level = []
    for one, gain in zip(reduced, samples.gains, strict=True):
        lamp = stretch * (gain if abs(gain - 1) > FLICKER_AT_LEAST else 1.0)
        # Smoothed after it, so that the levels between those of a dark picture are not lost.
        bright = cv2.convertScaleAbs(one, alpha=lamp) if lamp != 1.0 else one
        level.append(np.asarray(cv2.GaussianBlur(bright, (0, 0), SMOOTHING_PX), np.uint8))
    return level, scale


def _reduced(picture: Luma, scale: int) -> Luma:
    if scale == 1:
        return picture
    size = picture.shape[1] // scale, picture.shape[0] // scale
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)

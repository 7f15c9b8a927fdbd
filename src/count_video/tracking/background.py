"""What stands still behind the bodies: the median of some samples, without what bodies hide of it.

A body that rests for most of a clip is in the median as well, until it is known and left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.tracking.samples import median_picture
from count_video.tracking.shape import Place, Shape, hidden
from count_video.tracking.sprite import Pixels, look

Luma = NDArray[np.uint8]

HIDDEN = 256
"""Stands, in the sorting of bytes, for a pixel that is hidden: above all others."""


@dataclass(frozen=True)
class Background:
    """What stands still behind the bodies."""

    luma: Luma
    """Of the mean brightness, freed of the camera's motion, shape (height, width)."""
    shift_px: Mapping[int, Place]
    """Frame index -> how far the camera has moved the picture, by x and y."""
    gains: Mapping[int, float]
    """Frame index -> factor by which lamps that flicker brighten the picture."""

    def behind(self, frame: int, place: Place, shape: tuple[int, int]) -> Pixels:
        """Cut out what lies behind a piece of a picture."""
        x, y = self.shift_px.get(frame, (0.0, 0.0))
        return look(self.luma, place[0] - x, place[1] - y, shape)

    def levelled(self, picture: Luma, frame: int, place: Place, shape: tuple[int, int]) -> Pixels:
        """Cut out a piece of a picture and bring it to the background's brightness."""
        return look(picture, *place, shape) / np.float32(self.gains.get(frame, 1.0))


def background_of(
    pictures: Mapping[int, Luma],
    shift_px: Mapping[int, Place],
    gains: Mapping[int, float],
    known: Sequence[Shape] = (),
) -> Background:
    """Take the median of pictures of one scene.

    Parameters
    ----------
    pictures
        Frame index -> luma, shape (height, width).
    shift_px, gains
        As those of the background, by frame index.
    known
        What hides it in some pictures.
    """
    level = {
        frame: _moved_back(picture, 1 / gains[frame], shift_px[frame])
        for frame, picture in pictures.items()
    }
    plain = median_picture(list(level.values()))
    if known:
        size = plain.shape[0], plain.shape[1]
        marked = {
            frame: _moved_back(hidden(known, frame, (0.0, 0.0), size), 1.0, shift_px[frame]) > 0
            for frame in level
        }
        some = np.logical_or.reduce(list(marked.values()))
        seen = np.array([level[frame][some] for frame in level]).astype(np.int16)
        covered = np.array([marked[frame][some] for frame in level])
        seen[covered] = HIDDEN
        count = len(seen) - covered.sum(axis=0)
        ordered = np.sort(seen, axis=0)
        middle = np.take_along_axis(ordered, np.minimum(count // 2, len(seen) - 1)[None], axis=0)[0]
        plain[some] = np.where(count > 0, middle, plain[some]).astype(np.uint8)
    return Background(plain, shift_px, gains)


def _moved_back(picture: Luma, gain: float, shift_px: Place) -> Luma:
    """Bring a picture to another brightness and to where the camera was; its border goes on."""
    level = cv2.convertScaleAbs(picture, alpha=gain) if gain != 1.0 else picture
    if shift_px == (0.0, 0.0):
        return np.asarray(level, np.uint8)
    matrix = np.array([[1.0, 0.0, -shift_px[0]], [0.0, 1.0, -shift_px[1]]])
    size = picture.shape[1], picture.shape[0]
    moved = cv2.warpAffine(
        np.ascontiguousarray(level), matrix, size, borderMode=cv2.BORDER_REPLICATE
    )
    return np.asarray(moved, np.uint8)

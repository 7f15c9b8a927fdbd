"""What stands still behind the bodies: the median of some samples, without what bodies hide of it.

A body that rests for most of a clip is in the median as well, until it is known and left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.samples import THUMBNAIL_PX, median_picture
from count_video.tracking.shape import Place, Shape, hidden
from count_video.tracking.sprite import Pixels, look

Luma = NDArray[np.uint8]

MOTION_OF, SMOOTHING_PX = 31, 1.5
"""Whether the camera moved is decided by so many reduced pictures, smoothed against their noise."""
NOISE_SIGMAS, ROUNDING = 6.0, 0.5
"""Differences beyond so many standard deviations of the noise, and grey levels of rounding, count
alike: bodies differ from what they hide however the camera moved."""
WHOLLY_SHOWN = 0.999
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


def camera_moved(pictures: Sequence[Luma], shift_px: Floats) -> bool:
    """Whether pictures agree better with their median if they are moved back along a path.

    Of all samples those count that the path moves furthest. The pixels that both explanations show
    are compared, by the mean of their differences, which are limited to what noise makes.

    Parameters
    ----------
    pictures
        Samples of one brightness, n of them, each of shape (height, width).
    shift_px
        How far the camera may have moved each, by x and y, shape (n, 2).
    """
    scale = max(1, -(-pictures[0].shape[1] // THUMBNAIL_PX))
    away = np.hypot(*(shift_px - np.median(shift_px, axis=0)).T)
    most = np.argsort(-away, kind="stable")[:MOTION_OF]
    even = np.linspace(0, len(pictures) - 1, min(MOTION_OF, len(pictures))).astype(int)
    stands, moves = (
        _differences(pictures, (even, most), path / scale)
        for path in (np.zeros_like(shift_px), shift_px)
    )
    limit = NOISE_SIGMAS * (1.4826 * float(np.nanmedian(stands)) + ROUNDING)
    shown = np.isfinite(moves)
    means = [np.minimum(one[shown], limit).mean() for one in (stands, moves)]
    return bool(means[1] < means[0])


def _differences(
    pictures: Sequence[Luma],
    chosen: tuple[NDArray[np.intp], NDArray[np.intp]],
    shift_px: Floats,
) -> Pixels:
    """Differences of the second from the median of the first of two choices of pictures.

    All are reduced and moved back, by ``shift_px`` of their px; NaN where one shows nothing.
    """
    size = np.array(pictures[0].shape[::-1]) // max(1, -(-pictures[0].shape[1] // THUMBNAIL_PX))
    back: dict[int, Pixels] = {}
    shown: dict[int, NDArray[np.bool_]] = {}
    for k in np.union1d(*chosen).tolist():
        reduced = cv2.resize(pictures[k], size, interpolation=cv2.INTER_AREA).astype(np.float32)
        smooth = cv2.GaussianBlur(reduced, (0, 0), SMOOTHING_PX)
        matrix = np.array([[1.0, 0.0, -shift_px[k, 0]], [0.0, 1.0, -shift_px[k, 1]]])
        moved = cv2.warpAffine(smooth, matrix, size, borderMode=cv2.BORDER_REPLICATE)
        back[k] = np.asarray(moved, np.float32)
        shown[k] = cv2.warpAffine(np.ones_like(smooth), matrix, size) > WHOLLY_SHOWN
    median = np.median(np.array([back[k] for k in chosen[0].tolist()]), axis=0)
    away = [np.where(shown[k], np.abs(back[k] - median), np.nan) for k in chosen[1].tolist()]
    return np.array(away, np.float32)


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

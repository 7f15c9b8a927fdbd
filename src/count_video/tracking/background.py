"""What stands still behind the bodies: the median of some samples, without what bodies hide of it.

A body that rests for most of a clip is in the median as well, until it is known and left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats, Luma, Pixels
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.light import Light
from count_video.tracking.medians import median_picture
from count_video.tracking.sequences import Lumas, moved_back
from count_video.tracking.shape import Place, Shape, hidden
from count_video.tracking.template import piece_at
from count_video.video.pictures import reduced, scale_to

BACKGROUND_OF = 15
"""The background is the median of so many samples."""
MOTION_OF = 31
"""Whether the camera moved is decided by so many reduced pictures."""
NOISE_SIGMAS, ROUNDING = 6.0, 0.5
"""Differences beyond so many standard deviations of the noise, and grey levels of rounding, count
alike: bodies differ from what they hide however the camera moved."""


@dataclass(frozen=True)
class Background:
    """What stands still behind the bodies."""

    luma: Luma
    """Of the mean brightness, freed of the camera's motion, shape (height, width)."""
    shift_px: Floats
    """How far the camera has moved each sample, by x and y, shape (samples, 2)."""
    lights: Sequence[Light]
    """How lamps that flicker and soft shadows change each sample."""

    def reduced(self, scale: int) -> Background:
        """Reduce it, for pictures that are reduced alike."""
        return Background(reduced(self.luma, scale), self.shift_px / scale, self.lights)

    def as_it_stands(self, picture: Luma, sample: int) -> Luma:
        """Bring a whole picture to the background's brightness and place."""
        return _moved_back(self.lights[sample].levelled(picture), self.shift_px[sample])

    def behind(self, sample: int, place: Place, shape: tuple[int, int]) -> Pixels:
        """Cut out what lies behind a piece of a picture."""
        x, y = self.shift_px[sample].tolist()
        return piece_at(self.luma, place[0] - x, place[1] - y, shape)

    def levelled(self, picture: Luma, sample: int, place: Place, shape: tuple[int, int]) -> Pixels:
        """Cut out a piece of a picture and bring it to the background's brightness."""
        light = self.lights[sample].over(place, shape, picture.shape)
        return piece_at(picture, *place, shape) / light


def background_of(
    pictures: Lumas, shift_px: Floats, lights: Sequence[Light], known: Sequence[Shape] = ()
) -> Background:
    """Take the median of some pictures of one scene, evenly spread.

    Parameters
    ----------
    pictures
        Samples, each of shape (height, width).
    shift_px, lights
        As those of the background.
    known
        What hides it in some of them.
    """
    levelled, marks = [], []
    some = np.unique(np.linspace(0, len(lights) - 1, BACKGROUND_OF).astype(int))
    for sample in some.tolist():
        level, shift = lights[sample].levelled(pictures[sample]), shift_px[sample]
        levelled.append(_moved_back(level, shift))
        if known:
            marks.append(_moved_back(hidden(known, sample, (0.0, 0.0), level.shape), shift))
    return Background(median_picture(levelled, marks), shift_px, lights)


def camera_moved(pictures: Sequence[Luma], shift_px: Floats) -> bool:
    """Whether pictures agree better with their median if they are moved back along a path.

    Of all samples those count that the path moves furthest. They are compared by the mean of their
    differences, which are limited to what noise makes. Their mean must be the sharper one, too:
    where a plain background shows a few edges, a body that moves may change more pixels than these
    do. What a picture that is moved back does not show is the last that it does.

    Parameters
    ----------
    pictures
        Samples of one brightness, n of them, each of shape (height, width).
    shift_px
        How far the camera may have moved each, by x and y, shape (n, 2).
    """
    scale = scale_to(pictures[0].shape[1])
    away = np.hypot(*(shift_px - np.median(shift_px, axis=0)).T)
    most = np.argsort(-away, kind="stable")[:MOTION_OF]
    even = np.linspace(0, len(pictures) - 1, min(MOTION_OF, len(pictures))).astype(int)
    both = np.concatenate([even, most])
    small = [reduced(pictures[k], scale) for k in both.tolist()]
    return _agree_better(small, np.zeros_like(shift_px[both]), small, shift_px[both] / scale)


def agree_better(
    pictures: Sequence[Luma], shift_px: Floats, others: Sequence[Luma], their_shift_px: Floats
) -> bool:
    """Whether other pictures of the same samples agree better with their median than these do.

    Both are moved back along paths of the camera, shape (n, 2).
    """
    some = np.linspace(0, len(pictures) - 1, min(MOTION_OF, len(pictures))).astype(int)
    both = np.concatenate([some, some])
    one, other = ([these[k] for k in both.tolist()] for these in (pictures, others))
    return _agree_better(one, shift_px[both], other, their_shift_px[both])


def _agree_better(
    pictures: Sequence[Luma], shift_px: Floats, others: Sequence[Luma], their_shift_px: Floats
) -> bool:
    """Compare the second halves of two lists of pictures with the medians of the first ones."""
    left_over, sharpness, half = [], [], min(MOTION_OF, len(pictures) // 2)
    for these, shifts in ((pictures, shift_px), (others, their_shift_px)):
        some = [_moved_back(*one) for one in zip(these, shifts, strict=True)]
        middle = median_picture(some[:half])
        left_over.append(np.array([cv2.absdiff(one, middle) for one in some[half:]]))
        sharpness.append(np.abs(np.gradient(np.mean(some[half:], axis=0))).sum())
    limit = NOISE_SIGMAS * (MEDIAN_TO_SIGMA * float(np.median(left_over[0])) + ROUNDING)
    stands, moves = (np.minimum(one, limit).mean() for one in left_over)
    return bool(moves < stands and sharpness[1] > sharpness[0])


def _moved_back(picture: Luma, shift_px: Floats) -> Luma:
    return moved_back(picture, shift_px) if shift_px.any() else picture

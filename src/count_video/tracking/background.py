"""What stands still behind the bodies: the median of some samples, without what bodies hide of it.

A body that rests for most of a clip is in the median as well, until it is known and left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats, Luma, Pixels, Point
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.light import Light
from count_video.tracking.medians import median_picture, quantile_of
from count_video.tracking.sequences import Lumas, moved_back
from count_video.tracking.shape import Shape, hidden
from count_video.tracking.template import piece_at
from count_video.video.pictures import reduced

BACKGROUND_OF = 15
"""The background is the median of so many samples."""
MOTION_OF = 31
"""Whether the camera moved is decided by so many pictures."""
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
        return moved_back(self.lights[sample].levelled(picture), self.shift_px[sample])

    def behind(self, sample: int, place: Point, shape: tuple[int, int]) -> Pixels:
        """Cut out what lies behind a piece of a picture."""
        x, y = self.shift_px[sample].tolist()
        return piece_at(self.luma, place[0] - x, place[1] - y, shape)

    def levelled(self, picture: Luma, sample: int, place: Point, shape: tuple[int, int]) -> Pixels:
        """Cut out a piece of a picture and bring it to the background's brightness."""
        light = self.lights[sample].over(place, shape, picture.shape)
        return piece_at(picture, *place, shape) / light


def background_of(
    pictures: Lumas, shift_px: Floats, lights: Sequence[Light], known: Sequence[Shape] = ()
) -> Background:
    """Take the median of some samples of one scene, evenly spread, but for what hides it in some.

    Shifts and lights are those of the background.
    """
    some = np.unique(np.linspace(0, len(lights) - 1, BACKGROUND_OF).astype(int)).tolist()
    levelled = [moved_back(lights[k].levelled(pictures[k]), shift_px[k]) for k in some]
    shape = levelled[0].shape
    marks = (moved_back(hidden(known, k, (0.0, 0.0), shape), shift_px[k]) for k in some if known)
    return Background(median_picture(levelled, marks), shift_px, lights)


def agree_better(
    pictures: Sequence[Luma], shift_px: Floats, others: Sequence[Luma], their_shift_px: Floats
) -> bool:
    """Whether other pictures of the same samples agree better with their median than these do.

    Both are moved back along paths of the camera, shape (n, 2), and smoothed alike. Those count
    that their path moves furthest, by the mean of their differences, which are limited to what
    noise makes. The mean of these and some others must be the sharper one, too: where a plain
    background shows a few edges, a body that moves may change more pixels than these do. What a
    picture that is moved back does not show is the last that it does.
    """
    even = np.linspace(0, len(pictures) - 1, min(MOTION_OF, len(pictures))).astype(int)
    away = np.hypot(*(their_shift_px - np.median(their_shift_px, axis=0)).T)
    most = np.argsort(-away, kind="stable")[:MOTION_OF] if away.any() else even
    left_over, sharpness = [], []
    both = (pictures, shift_px, their_shift_px), (others, their_shift_px, shift_px)
    for these, shifts, other in both:
        middle, counted = (
            [moved_back(_smoothed_as(these[k], other[k]), shifts[k]) for k in some.tolist()]
            for some in (even, most)
        )
        typical = median_picture(middle)
        left_over.append([np.asarray(cv2.absdiff(one, typical), np.uint8) for one in counted])
        sharpness.append(np.abs(np.gradient(np.mean([*middle, *counted], axis=0))).sum())
    limit = NOISE_SIGMAS * (MEDIAN_TO_SIGMA * quantile_of(left_over[0], 0.5) + ROUNDING)
    stands, moves = (sum(np.minimum(one, limit).mean() for one in each) for each in left_over)
    return bool(moves < stands and sharpness[1] > sharpness[0])


def _smoothed_as(picture: Luma, shift_px: Floats) -> Luma:
    """Smooth a picture as much as it is by linear interpolation when it is moved so far."""
    between = shift_px % 1.0
    share = between * (1.0 - between)
    if not share.any():
        return picture
    x, y = (np.array([one / 2, 1.0 - one, one / 2]) for one in share)
    smooth = cv2.sepFilter2D(picture, -1, x, y, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(smooth, np.uint8)

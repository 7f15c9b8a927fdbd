"""What stands still in a clip, and what each frame shows in front of it.

The scenery is found pixel by pixel, from pictures spread over the clip, as the value about which
most of them crowd (the shorth of robust statistics, for a share of the values). Whatever moves
shows a pixel many values and the scenery one, so that a body may cover a pixel more than half of
the time. The width of the crowd tells the pixel's noise, which is more along sharp edges, where
compression and a trembling camera show.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.tracking.patches.surroundings import (
    filled_in,
    steepness,
    where_outlines_vanish,
    without_resting,
)

Luma = NDArray[np.uint8]
Mask = NDArray[np.uint8]

WIDTH_FOR_BLOBS_PX = 720
"""Wider pictures are shrunk by a whole factor until they are no wider."""
PICTURES = 60
"""So many pictures tell what stands still, and its noise."""
DENSE_SHARE = 0.35
"""The scenery is a pixel's value in the narrowest span that holds this share of the pictures."""
SHOWN_AT_LEAST = 3
"""A pixel's value is known when so many pictures show it without a body."""
NORMAL_WIDTH = 1.10
"""Standard deviation of normal noise over the width of that span: its central 35 % lies within
0.454 of them on either side."""
NOISE_FACTOR = 5.0
"""A pixel is foreground when it strays this many times as far as noise does."""
LEVELS_AT_LEAST = 5.0
"""And at least so many grey levels: banding of compressed, plain walls stays below."""
SMOOTHING_PX = 1.0
NOISE_WINDOW_PX = 5
GHOST_FACTOR = 1.5
LIGHT_STEP = 4
LIGHT_WINDOW_SHARE = 0.25
"""The light changes alike over windows of this share of the picture's width; bodies are smaller.
Every fourth row and column tells it."""


@dataclass(frozen=True)
class Scenery:
    """The picture without what moves, shrunk by ``scale``."""

    luma: NDArray[np.float32]
    """Shape (height, width)."""
    threshold: NDArray[np.float32]
    """Grey levels from which on a difference is no noise, same shape."""
    scale: int
    """Pixels of the footage for one of these, in either direction."""


def shrink_factor(width_px: int) -> int:
    """Whole factor by which pictures are shrunk for the search."""
    return -(-width_px // WIDTH_FOR_BLOBS_PX)


def shrunk(luma: Luma, scale: int) -> Luma:
    """Shrink a picture by a whole factor, by the mean of each square of pixels."""
    if scale == 1:
        return luma
    rows, columns = luma.shape[0] // scale * scale, luma.shape[1] // scale * scale
    size = (columns // scale, rows // scale)
    small = cv2.resize(luma[:rows, :columns], size, interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


def learn_scenery(pictures: Sequence[Luma], scale: int) -> Scenery:
    """Learn what stands still from pictures, each shrunk already and shape (height, width)."""
    stack = evenly_lit(pictures)
    luma, width = _densest(stack)
    return _settled(stack, luma, width * NORMAL_WIDTH, scale)


def learn_again(pictures: Sequence[Luma], hidden: Sequence[Mask], first: Scenery) -> Scenery:
    """Learn it from where no body is known to be: ``hidden`` is nonzero where one is.

    Pixels that are always hidden keep the value that they have in the ``first`` scenery, or are
    filled in from around where that is a body's.
    """
    stack = evenly_lit(pictures)
    stack[np.array(hidden) > 0] = np.nan
    shown = np.isfinite(stack).sum(axis=0) >= SHOWN_AT_LEAST
    middle = _median(stack)
    spread = 1.4826 * _median(np.abs(stack - middle))
    usual = float(np.median(spread[shown])) if shown.any() else 0.0
    luma = np.where(shown, middle, first.luma)
    threshold = float(np.median(first.threshold))
    luma = where_outlines_vanish(luma, filled_in(luma, ~shown, threshold), threshold)
    return _settled(stack, luma, np.where(shown, spread, usual), first.scale)


def _settled(
    stack: NDArray[np.float32], luma: NDArray[np.float32], noise: NDArray[np.float32], scale: int
) -> Scenery:
    """Make a scenery of what most pictures show, without the bodies that rest in most of them."""
    scenery = scenery_of(luma, noise, scale)
    usual = float(np.median(scenery.threshold))
    settled = without_resting(stack, scenery.luma, usual)
    # What a body does that comes or goes is no noise.
    other = np.abs(settled - scenery.luma) > usual
    if not other.any():
        return scenery
    return scenery_of(settled, np.where(other, np.median(noise), noise), scale)


def without_ghost(scenery: Scenery, patch: Mask, picture: Luma) -> Scenery:
    """Take a body out of the scenery that rested for most of the clip, if one is there.

    Where it is not, a patch stands out that never moves, and the outline of the patch is an edge of
    the scenery, not of the picture. ``patch`` is nonzero within it.
    """
    smooth = _smooth(picture)
    smooth = smooth - _light(smooth - scenery.luma)
    ring = cv2.morphologyEx(patch, cv2.MORPH_GRADIENT, np.ones((5, 5), np.uint8)) > 0
    if steepness(scenery.luma)[ring].mean() < GHOST_FACTOR * steepness(smooth)[ring].mean():
        return scenery
    within = np.asarray(cv2.dilate(patch, np.ones((7, 7), np.uint8))) > 0
    return replace(scenery, luma=np.where(within, smooth, scenery.luma).astype(np.float32))


def _median(stack: NDArray[np.float32]) -> NDArray[np.float32]:
    """Median of each pixel's values without NaN; meaningless where there are none.

    Sorting puts NaN last; this is many times as fast as ``np.nanmedian``.
    """
    ordered = np.sort(stack, axis=0)
    middle = np.maximum(np.isfinite(stack).sum(axis=0) - 1, 0) // 2
    return np.asarray(np.take_along_axis(ordered, middle[None], axis=0)[0])


def evenly_lit(pictures: Sequence[Luma]) -> NDArray[np.float32]:
    """Smooth pictures and take changes of the light out of them; shape (n, height, width)."""
    stack = np.array([_smooth(picture) for picture in pictures])
    middle = np.median(stack, axis=0)
    return np.array([picture - _light(picture - middle) for picture in stack])


def scenery_of(luma: NDArray[np.float32], noise: NDArray[np.float32], scale: int) -> Scenery:
    """Complete a scenery from its luma and the noise of each pixel, in grey levels."""
    window = (NOISE_WINDOW_PX, NOISE_WINDOW_PX)
    around = np.asarray(cv2.blur(noise.astype(np.float32), window))
    threshold = np.maximum(NOISE_FACTOR * around, LEVELS_AT_LEAST)
    return Scenery(luma.astype(np.float32), threshold.astype(np.float32), scale)


def _densest(stack: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Middle and width of the narrowest span that holds a share of each pixel's values."""
    stack = np.sort(stack, axis=0)
    held = max(2, round(DENSE_SHARE * len(stack)))
    width = stack[held - 1 :] - stack[: len(stack) - held + 1]
    place = np.argmin(width, axis=0)[None]
    low = np.take_along_axis(stack, place, axis=0)[0]
    narrowest = np.take_along_axis(width, place, axis=0)[0]
    return low + narrowest / 2, narrowest


def difference(luma: Luma, scenery: Scenery) -> NDArray[np.float32]:
    """How a shrunk picture differs from the scenery in grey levels, changes of the light apart."""
    change = _smooth(luma) - scenery.luma
    return np.asarray(change - _light(change), dtype=np.float32)


def _light(change: NDArray[np.float32]) -> NDArray[np.float32]:
    """How the light changed, of lamps and of soft shadows: medians over wide windows."""
    coarse = np.clip(change[::LIGHT_STEP, ::LIGHT_STEP] + 128.0, 0, 255).astype(np.uint8)
    window = 2 * round(LIGHT_WINDOW_SHARE * coarse.shape[1] / 2) + 1
    usual = cv2.medianBlur(np.ascontiguousarray(coarse), window).astype(np.float32) - 128.0
    light = cv2.blur(usual, (5, 5))
    size = (change.shape[1], change.shape[0])
    return np.asarray(cv2.resize(light, size, interpolation=cv2.INTER_LINEAR), dtype=np.float32)


def _smooth(luma: Luma) -> NDArray[np.float32]:
    picture = np.ascontiguousarray(luma).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), SMOOTHING_PX), dtype=np.float32)

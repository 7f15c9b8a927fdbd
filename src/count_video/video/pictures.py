"""Decoded pictures as numpy luma and chroma, without a copy where the layout allows; reduced."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TypeVar

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Chroma, Luma

Depth = TypeVar("Depth", np.uint8, np.float32)

THUMBNAIL_PX = 256
"""Width of thumbnails at most."""


@lru_cache(maxsize=64)
def luma_shift(pixel_format: str) -> int | None:
    """How many bits stored luma has below the 8 that are kept, in FFmpeg's ``pixel_format``.

    Luma without such bits is stored in bytes, other luma in two bytes, the low one first. None if
    luma has no plane of its own.
    """
    if re.fullmatch(r"yuva?j?4[0-4][0-4]p|gray8?|nv(12|21|16|24|42)", pixel_format):
        return 0
    if re.fullmatch(r"p[024]1[026]le", pixel_format):
        return 8
    deeper = re.fullmatch(r"(?:yuva?4[0-4][0-4]p|gray)(9|10|12|14|16)le", pixel_format)
    return int(deeper[1]) - 8 if deeper else None


def luma_of(frame: av.VideoFrame) -> Luma:
    """Return the luma of a decoded picture as stored (not turned), shape (height, width).

    8-bit planar layouts give a view of the Y plane that keeps the picture alive; deeper ones are
    rounded down to 8 bits; RGB, palettes and packed layouts are converted.
    """
    shift = luma_shift(frame.format.name)
    if shift is None or frame.planes[0].line_size < 0:
        return np.ascontiguousarray(frame.to_ndarray(format="gray"), np.uint8)
    return _values(frame.planes[0], frame.width, shift)


def chroma_of(frame: av.VideoFrame) -> Chroma | None:
    """Return the chroma of a decoded picture at half its size, not turned; None if it has none.

    Rounded up, shape (2, rows, columns). Grey pictures have none, nor have layouts in which it has
    no planes of its own.
    """
    shift, planes = luma_shift(frame.format.name), frame.planes[1:3]
    if shift is None or not planes or planes[0].line_size < 0:
        return None
    if len(planes) == 1:  # the values of both follow each other
        pairs = _values(planes[0], 2 * planes[0].width, shift)
        both = [pairs[:, 0::2], pairs[:, 1::2]]
    else:
        both = [_values(plane, plane.width, shift) for plane in planes]
    rows, columns = (frame.height + 1) // 2, (frame.width + 1) // 2
    chroma = np.empty((2, rows, columns), np.uint8)
    for half, one in zip(chroma, both, strict=True):
        if one.shape == half.shape:
            half[...] = one
        else:
            half[...] = cv2.resize(one, (columns, rows), interpolation=cv2.INTER_AREA)
    return chroma


def _values(plane: av.video.plane.VideoPlane, columns: int, shift: int) -> Luma:
    """Return what a plane stores, in 8 bits, shape (rows, columns)."""
    # Lines are padded for the decoder's sake: a row of the buffer is wider than the picture.
    rows = np.frombuffer(memoryview(plane), np.uint8).reshape(plane.height, plane.line_size)
    if shift == 0:
        return rows[:, :columns]
    if shift == 8:  # the value is in the upper byte, and a view is enough
        return rows[:, 1 : 2 * columns : 2]
    eight_bits = np.empty((plane.height, columns), np.uint8)
    np.right_shift(rows.view("<u2")[:, :columns], shift, out=eight_bits, casting="unsafe")
    return eight_bits


def scale_to(width_px: int, at_most_px: int = THUMBNAIL_PX) -> int:
    """How many px one px of a reduced picture holds, for it to be no wider than that.

    The number is whole: OpenCV then takes plain means, which are fast.
    """
    return max(1, -(-width_px // at_most_px))


def reduced(picture: NDArray[Depth], scale: int) -> NDArray[Depth]:
    """Reduce a picture so that one px holds ``scale`` of its; what is left at the end is cut."""
    height, width = (max(1, size // scale) for size in picture.shape)
    small = picture[: height * scale, : width * scale]
    while scale > 1:
        step = next(step for step in (2, 3, 5, scale) if scale % step == 0)
        small = _means(small, step)
        scale //= step
    return small


def _means(picture: NDArray[Depth], step: int) -> NDArray[Depth]:
    """Take means of ``step`` x ``step`` px; both sides are multiples of it.

    OpenCV reduces to half very fast, but not otherwise: there a moving mean of 3 or 5 px, of which
    most is thrown away, takes half the time.
    """
    if step in (3, 5):
        centres, means = slice(step // 2, None, step), cv2.blur(picture, (step, step))
        return np.ascontiguousarray(means[centres, centres], picture.dtype)
    size = picture.shape[1] // step, picture.shape[0] // step
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return np.asarray(small, picture.dtype)

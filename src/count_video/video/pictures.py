"""Decoded pictures as numpy luma: without a copy where the layout allows, or reduced."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TypeVar

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Luma

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
    plane = frame.planes[0]
    if shift is None or plane.line_size < 0:
        return np.ascontiguousarray(frame.to_ndarray(format="gray"), np.uint8)
    # Lines are padded for the decoder's sake: a row of the buffer is wider than the picture.
    rows = np.frombuffer(memoryview(plane), np.uint8).reshape(frame.height, plane.line_size)
    if shift == 0:
        return rows[:, : frame.width]
    if shift == 8:  # the value is in the upper byte, and a view is enough
        return rows[:, 1 : 2 * frame.width : 2]
    eight_bits = np.empty((frame.height, frame.width), np.uint8)
    np.right_shift(rows.view("<u2")[:, : frame.width], shift, out=eight_bits, casting="unsafe")
    return eight_bits


def scale_to(width_px: int, at_most_px: int = THUMBNAIL_PX) -> int:
    """How many px one px of a reduced picture holds, for it to be no wider than that.

    The number is whole: OpenCV then takes plain means, which are fast.
    """
    return max(1, -(-width_px // at_most_px))


def reduced(picture: NDArray[Depth], scale: int) -> NDArray[Depth]:
    """Reduce a picture so that one px holds ``scale`` of its; what is left at the end is cut."""
    if scale == 1:
        return picture
    height, width = (max(1, size // scale) for size in picture.shape)
    whole = picture[: height * scale, : width * scale]
    small = cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA)
    return np.asarray(small, picture.dtype)

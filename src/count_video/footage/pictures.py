"""Decoded pictures as numpy luma: without a copy where the layout allows, upright, or reduced."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import av
import cv2
import numpy as np
from numpy.typing import NDArray

Luma = NDArray[np.uint8]
Depth = TypeVar("Depth", np.uint8, np.float32)

THUMBNAIL_PX = 256
"""Width of thumbnails at most."""

_EIGHT_BITS = re.compile(r"yuva?j?4[0-4][0-4]p|gray8?|nv(12|21|16|24|42)")
_LOW_BITS = re.compile(r"(?:yuva?4[0-4][0-4]p|gray)(9|10|12|14|16)le")
_HIGH_BITS = re.compile(r"p[024]1[026]le")


@dataclass(frozen=True)
class LumaLayout:
    """Where the luma values of a pixel layout lie in its first plane."""

    dtype: np.dtype[np.uint8] | np.dtype[np.uint16]
    """Type of one stored value."""
    shift: int
    """How many bits the stored value has below the 8 that are kept."""


@lru_cache(maxsize=64)
def luma_layout(pixel_format: str) -> LumaLayout | None:
    """Return the layout of FFmpeg's ``pixel_format``, None if luma has no plane of its own."""
    if _EIGHT_BITS.fullmatch(pixel_format):
        return LumaLayout(np.dtype(np.uint8), 0)
    if low := _LOW_BITS.fullmatch(pixel_format):
        return LumaLayout(np.dtype("<u2"), int(low[1]) - 8)
    if _HIGH_BITS.fullmatch(pixel_format):
        return LumaLayout(np.dtype("<u2"), 8)
    return None


def luma_of(frame: av.VideoFrame) -> Luma:
    """Return the luma of a decoded picture as stored (not turned), shape (height, width).

    8-bit planar layouts give a view of the Y plane that keeps the picture alive; deeper ones are
    rounded down to 8 bits; RGB, palettes and packed layouts are converted.
    """
    layout = luma_layout(frame.format.name)
    if layout is None or frame.planes[0].line_size < 0:
        return np.ascontiguousarray(frame.to_ndarray(format="gray"), np.uint8)
    plane = frame.planes[0]
    # Lines are padded for the decoder's sake: a row of the buffer is wider than the picture.
    if layout.shift == 8:
        # Values in the top bits: every other byte is the picture, and a view is enough.
        pairs = np.frombuffer(memoryview(plane), np.uint8).reshape(
            frame.height, plane.line_size // 2, 2
        )
        return pairs[:, : frame.width, 1]
    stored = np.frombuffer(memoryview(plane), layout.dtype).reshape(frame.height, -1)[
        :, : frame.width
    ]
    if layout.shift == 0:
        return stored.view(np.uint8)
    eight_bits = np.empty(stored.shape, np.uint8)
    np.right_shift(stored, layout.shift, out=eight_bits, casting="unsafe")
    return eight_bits


def quarter_turns(frame: av.VideoFrame) -> int:
    """Return how many counter-clockwise quarter turns make the picture upright, 0 to 3."""
    return round(frame.rotation / 90) % 4


def upright(luma: Luma, turns: int) -> Luma:
    """Turn a picture counter-clockwise by quarter turns; a view."""
    return np.rot90(luma, turns) if turns else luma


def thumbnail(luma: Luma) -> Luma:
    """Reduce a picture to at most ``THUMBNAIL_PX`` columns."""
    return reduced(luma, scale_to(luma.shape[1]))


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

"""Text on the pictures of a clip, set once and pasted as often as it is needed."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from count_video.reports.drawing import drawable, font_path

Pixels = NDArray[np.uint8]
Colour = tuple[int, int, int]


def write(canvas: Pixels, text: str, at: tuple[int, int], size_px: int, colour: Colour) -> int:
    """Write a line of text with its left top corner at (x, y); what sticks out is cut off.

    Returns the x at which the text ends.
    """
    cover = _cover(drawable(text), size_px)
    x, y = at
    end = x + cover.shape[1]
    left, top = max(0, -x), max(0, -y)
    height = min(cover.shape[0], canvas.shape[0] - y)
    width = min(cover.shape[1], canvas.shape[1] - x)
    if height > top and width > left:
        piece = cover[top:height, left:width, None]
        under = canvas[y + top : y + height, x + left : x + width]
        under[...] = (under * (1 - piece) + piece * np.array(colour)).astype(np.uint8)
    return int(end)


def text_width(text: str, size_px: int) -> int:
    """Width of a line of text in px."""
    return int(_cover(drawable(text), size_px).shape[1])


@lru_cache(maxsize=512)
def _cover(text: str, size_px: int) -> NDArray[np.float32]:
    """How much of each pixel the text covers, 0 to 1, shape (height, width)."""
    font = ImageFont.truetype(font_path(), size_px)
    width = max(1, round(font.getlength(text)))
    image = Image.new("L", (width, round(1.3 * size_px)))
    ImageDraw.Draw(image).text((0, 0), text, fill=255, font=font)
    return np.asarray(image, np.float32) / np.float32(255)

"""The clip for a talk: full HD, wide or upright, with a counter that the last row can read."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator

import cv2
import numpy as np
from PIL import Image

from count_video.records import Floats, WallSide
from count_video.reports.clip import STRIP_PX, ClipLayout, Letters, Pixels
from count_video.settings import Shape

SIZES: dict[Shape, tuple[int, int]] = {"wide": (1920, 1080), "upright": (1080, 1920)}
"""Width and height of the clip in px."""
COUNTER_PX: dict[Shape, int] = {"wide": 280, "upright": 600}
DIGIT_WIDTH = 0.64
"""Width of a digit over the size of the type."""
WORDS_PX = 44
MARGIN_PX = 40
SHADED_PX = 720
"""Width of the ground that is darkened behind the counter on footage."""
GIF_WIDTH_PX = 480
GIF_FRAMES = 160
"""Largest number of pictures: more make a file that no slide takes."""
GIF_COLOURS = 64


def presenter_layout(
    shape: Shape, width_px: int, height_px: int, wall: WallSide, most: int
) -> ClipLayout:
    """Fit footage into the clip, above the time line and, if upright, below the counter.

    The count, up to ``most``, stands in the corner that is farthest from the ball: away from the
    wall.
    """
    (width, height), upright = SIZES[shape], shape == "upright"
    fits = (width - 2 * MARGIN_PX) / (DIGIT_WIDTH * len(str(most)))
    size = min(COUNTER_PX[shape], int(fits))
    below = round(1.2 * size) + WORDS_PX // 2
    above = below + 3 * WORDS_PX // 2
    left_over = height - (above + STRIP_PX if upright else 0) - 2 * MARGIN_PX
    scale = min(width / width_px, left_over / height_px)
    footage_width, footage_height = round(scale * width_px), round(scale * height_px)
    spare = left_over - footage_height
    top = above + spare // 2 if upright else spare
    near, far, anchors, inward = MARGIN_PX, width - MARGIN_PX, ("la", "ra"), -1
    shaded = (width - SHADED_PX, 0, width, above)
    if wall == "right":
        near, far, anchors, inward = far, near, ("ra", "la"), 1
        shaded = (0, 0, SHADED_PX, above)
    letters: dict[str, Letters] = {
        "count": ((far, 0), size, anchors[1]),
        "sign": ((far, below), WORDS_PX, anchors[1]),
        "last": ((far + inward * 54, below), WORDS_PX, anchors[1]),
        "pace": ((near, MARGIN_PX), WORDS_PX, anchors[0]),
    }
    return ClipLayout(
        scale=scale,
        width_px=width,
        height_px=height,
        footage_width_px=footage_width,
        footage_height_px=footage_height,
        left_px=(width - footage_width) // 2,
        top_px=top,
        time_line_px=(MARGIN_PX, width - MARGIN_PX, height - MARGIN_PX),
        letters=letters,
        with_strip=upright,
        shaded_px=(0, 0, 0, 0) if upright else shaded,
        mark_px=22.0,
    )


class Gif:
    """Keeps some pictures of a clip while they stream by."""

    def __init__(self, shown_s: Floats) -> None:
        """``shown_s`` says when each picture of the clip is shown, in seconds, shape (n,)."""
        times = np.linspace(0.0, shown_s[-1], min(GIF_FRAMES, len(shown_s)))
        self._rows = np.unique(np.searchsorted(shown_s, times, side="right") - 1)
        self._shown_s = shown_s
        self._kept: list[Image.Image] = []

    def keeping(self, pictures: Iterable[Pixels]) -> Iterator[Pixels]:
        """Yield the pictures, RGB, shape (height, width, 3)."""
        wanted = set(self._rows.tolist())
        for row, picture in enumerate(pictures):
            if row in wanted:
                height = round(GIF_WIDTH_PX * picture.shape[0] / picture.shape[1])
                small = cv2.resize(picture, (GIF_WIDTH_PX, height), interpolation=cv2.INTER_AREA)
                self._kept.append(Image.fromarray(small).quantize(GIF_COLOURS))
            yield picture

    def data(self) -> bytes:
        """Put the pictures kept so far together; it plays for ever, as long as the clip."""
        shown_s = self._shown_s[self._rows[: len(self._kept)]]
        lasts_ms = np.diff(shown_s, append=shown_s[-1:] + 1.5) * 1000.0
        duration = np.maximum(20, lasts_ms.round()).astype(int).tolist()
        target = io.BytesIO()
        first, *others = self._kept
        first.save(target, "GIF", save_all=True, append_images=others, duration=duration, loop=0)
        return target.getvalue()

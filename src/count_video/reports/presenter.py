"""The clip for a talk: full HD, wide or upright, with a counter that the last row can read."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator

import cv2
import numpy as np
from PIL import Image

from count_video.records import Floats, Frame, Track, TrialResult
from count_video.reports.clip import (
    STRIP_PX,
    AnnotatedClip,
    ClipLayout,
    Letters,
    Pixels,
    marked,
    width_px,
)
from count_video.reports.drawing import MARKS
from count_video.settings import Shape

SIZES: dict[Shape, tuple[int, int]] = {"wide": (1920, 1080), "upright": (1080, 1920)}
"""Width and height of the clip in px."""
COUNTER_PX: dict[Shape, int] = {"wide": 280, "upright": 600}
WORDS_PX = 44
MARGIN_PX = 40
MARK_PX = 22.0
SHADE = 0.45
"""The footage is darkened to this share behind the counter."""
GIF_WIDTH_PX = 480
GIF_FRAMES = 160
"""Largest number of pictures: more make a file that no slide takes."""
GIF_COLOURS = 64


class PresenterClip(AnnotatedClip):
    """Draws the clip, and keeps some of its pictures for the GIF."""

    def __init__(
        self,
        result: TrialResult,
        track: Track,
        footage: tuple[int, int],
        shown_s: Floats,
        shape: Shape,
    ) -> None:
        """``footage`` is its (height, width); the rest is as for the annotated clip."""
        super().__init__(result, track, footage, shown_s)
        self._counter_px = COUNTER_PX[shape]
        self.layout = _layout(shape, footage[1], footage[0])
        times = np.linspace(0.0, shown_s[-1], min(GIF_FRAMES, len(shown_s)))
        self._gif_rows = np.unique(np.searchsorted(shown_s, times, side="right") - 1)
        self._gif: list[Image.Image] = []

    def pictures(self, frames: Iterable[Frame]) -> Iterator[Pixels]:
        """Draw one picture for each frame of the track, RGB, shape (height, width, 3)."""
        wanted = set(self._gif_rows.tolist())
        for row, picture in enumerate(super().pictures(frames)):
            if row in wanted:
                height = round(GIF_WIDTH_PX * picture.shape[0] / picture.shape[1])
                small = cv2.resize(picture, (GIF_WIDTH_PX, height), interpolation=cv2.INTER_AREA)
                self._gif.append(Image.fromarray(small).quantize(GIF_COLOURS))
            yield picture

    def gif(self) -> bytes:
        """Put the pictures kept so far together; it plays for ever, as long as the clip."""
        shown_s = self.shown_s[self._gif_rows[: len(self._gif)]]
        lasts_ms = np.diff(shown_s, append=shown_s[-1:] + 1.5) * 1000.0
        target = io.BytesIO()
        first, *others = self._gif
        duration = np.maximum(20, lasts_ms.round()).astype(int).tolist()
        more = {"append_images": others, "duration": duration}
        first.save(target, "GIF", save_all=True, loop=0, **more)
        return target.getvalue()

    def _draw_header(self, canvas: Pixels, index: int, row: int) -> Iterator[Letters]:
        """Write the count into the corner that is farthest from the ball: away from the wall."""
        past, count = self._happened(index)
        size, below = self._counter_px, round(1.2 * self._counter_px) + WORDS_PX // 2
        words = MARKS[past[-1].kind].words if past else ""
        wide = max(width_px(str(count), size), width_px(f"■ {words}", WORDS_PX)) + 2 * MARGIN_PX
        left, right, ends = MARGIN_PX, canvas.shape[1] - MARGIN_PX, ("la", "ra")
        corner, (x, other) = slice(-wide, None), (right, left)
        if self.track.wall_side == "right":
            corner, (x, other), ends = slice(wide), (left, right), ("ra", "la")
        if not self.layout.with_strip:
            shaded = canvas[: below + 3 * WORDS_PX // 2, corner]
            shaded[...] = (shaded * SHADE).astype(np.uint8)
        yield Letters(str(count), (x, 0), size, anchor=ends[1])
        if past:
            yield from marked(past[-1], words, (x, below), WORDS_PX, ends[1])
        yield Letters(self._pace(row), (other, MARGIN_PX), WORDS_PX, anchor=ends[0])
        self._draw_time_line(canvas, row, (left, right, canvas.shape[0] - MARGIN_PX))


def _layout(shape: Shape, width_px: int, height_px: int) -> ClipLayout:
    """Fit footage into the clip, above the time line and, if upright, below the counter."""
    width, height = SIZES[shape]
    upright = shape == "upright"
    above = round(1.2 * COUNTER_PX[shape]) + 2 * WORDS_PX if upright else 0
    left_over = height - above - (STRIP_PX if upright else 0) - 2 * MARGIN_PX
    scale = min(width / width_px, left_over / height_px)
    footage_width, footage_height = round(scale * width_px), round(scale * height_px)
    spare = left_over - footage_height
    top = above + (spare // 2 if upright else spare)
    places = (footage_width, footage_height, (width - footage_width) // 2, top)
    return ClipLayout(scale, width, height, *places, with_strip=upright, mark_px=MARK_PX)

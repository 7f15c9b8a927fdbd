"""The clip for a talk: full HD, wide or upright, with a counter that the last row can read."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator

import cv2
import numpy as np
from PIL import Image

from count_video.records import Floats, Frame, Track, TrialResult
from count_video.reports.annotated_clip import STRIP_PX, AnnotatedClip, ClipLayout
from count_video.reports.drawing import MARKS, Pixels, mark, text_width, write
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
        self._shape: Shape = shape
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
        first.save(
            target,
            "GIF",
            save_all=True,
            append_images=others,
            duration=[max(20, round(float(ms))) for ms in lasts_ms],
            loop=0,
        )
        return target.getvalue()

    def _picture(self, frame: Frame, row: int) -> Pixels:
        layout = self.layout
        canvas = np.zeros((layout.height_px, layout.width_px, 3), np.uint8)
        footage = layout.put(canvas, frame.luma)
        self._draw_bodies(footage, row)
        self._draw_contacts(footage, frame.index, row, MARK_PX)
        if self._shape == "upright":
            below = layout.top_px + layout.footage_height_px
            self._draw_strip(canvas[below : below + STRIP_PX], row)
        self._draw_counter(canvas, frame.index)
        pace = self._pace(row)
        right = self.track.wall_side == "left"
        x = MARGIN_PX if right else layout.width_px - MARGIN_PX - text_width(pace, WORDS_PX)
        write(canvas, pace, (x, MARGIN_PX), WORDS_PX, (255, 255, 255))
        ends = (MARGIN_PX, layout.width_px - MARGIN_PX, layout.height_px - MARGIN_PX)
        self._draw_time_line(canvas, row, ends)
        return canvas

    def _draw_counter(self, canvas: Pixels, index: int) -> None:
        """Write the count into the corner that is farthest from the ball: away from the wall."""
        past, count = self._happened(index)
        size = COUNTER_PX[self._shape]
        digits, words = str(count), MARKS[past[-1].kind].words if past else ""
        height, right = round(1.2 * size), self.track.wall_side == "left"
        wide = max(text_width(digits, size), text_width(words, WORDS_PX) + 64)
        corner = canvas.shape[1] - wide - MARGIN_PX if right else MARGIN_PX
        if self._shape == "wide":
            box = canvas[: height + 2 * WORDS_PX, max(0, corner - MARGIN_PX // 2) :]
            box = box if right else canvas[: height + 2 * WORDS_PX, : wide + 3 * MARGIN_PX // 2]
            box[...] = (box * SHADE).astype(np.uint8)
        x = canvas.shape[1] - MARGIN_PX - text_width(digits, size) if right else corner
        write(canvas, digits, (x, 0), size, (255, 255, 255))
        if past:
            y = height + WORDS_PX // 2
            at = (corner + MARK_PX, y + 0.6 * WORDS_PX)
            mark(canvas, past[-1].kind, at, MARK_PX, seen=past[-1].seen)
            write(canvas, words, (corner + 64, y), WORDS_PX, (220, 220, 220))


def _layout(shape: Shape, width_px: int, height_px: int) -> ClipLayout:
    """Fit footage into the clip, above the time line and, if upright, below the counter."""
    width, height = SIZES[shape]
    above = round(1.2 * COUNTER_PX[shape]) + 2 * WORDS_PX if shape == "upright" else 0
    strip = STRIP_PX if shape == "upright" else 0
    left_over = height - above - strip - 2 * MARGIN_PX
    scale = min(width / width_px, left_over / height_px)
    footage_width, footage_height = round(scale * width_px), round(scale * height_px)
    spare = left_over - footage_height
    top = above + (spare // 2 if shape == "upright" else spare)
    left = (width - footage_width) // 2
    return ClipLayout(scale, width, height, footage_width, footage_height, left, top)

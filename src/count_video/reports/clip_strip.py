"""The strip below the footage: the space-time image, scrolling down, newest row on top."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Collision, Floats, Track
from count_video.reports.lettering import write
from count_video.reports.material import ball_edges_px, contact_px
from count_video.reports.overlay import mark, path
from count_video.reports.palette import BALL, HEAVY, rgb

Pixels = NDArray[np.uint8]
ROW_PX = 3
"""Height of one frame: a contact every 2.5 frames still has a mark of its own."""
ROWS = 72
MARK_PX = 7.0
NUMBER_PX = 15


class Strip:
    """Draws the last frames as rows below each other."""

    def __init__(self, track: Track, collisions: Sequence[Collision]) -> None:
        self.height_px = ROW_PX * ROWS
        self._frame = track.frame
        self._collisions = collisions
        self._contacts = [contact_px(collision, track) for collision in collisions]
        heavy = () if track.heavy is None else (track.heavy.position_px,)
        low, high = ball_edges_px(track)
        self._lines: list[tuple[Floats, str]] = [(low, BALL), (high, BALL)]
        self._lines += [(line, HEAVY) for line in heavy]

    def draw(self, canvas: Pixels, rows: Sequence[Pixels], newest: int) -> None:
        """Draw into the strip's part of a picture, shape (height_px, width, 3)."""
        oldest = max(0, newest + 1 - ROWS)
        image = np.array(rows[oldest : newest + 1])[::-1]
        size = (canvas.shape[1], ROW_PX * len(image))
        shown = cv2.resize(image, size, interpolation=cv2.INTER_NEAREST)
        cv2.cvtColor(shown, cv2.COLOR_GRAY2RGB, dst=canvas[: size[1]])
        scale = canvas.shape[1] / image.shape[1]
        for line, colour in self._lines:
            self._draw_line(canvas, line[oldest : newest + 1], scale, colour)
        self._draw_marks(canvas, (oldest, newest), scale)

    def _draw_line(self, canvas: Pixels, line: Floats, scale: float, colour: str) -> None:
        x = (line + 0.5) * scale - 0.5
        y = [_height(back) for back in reversed(range(len(line)))]
        seen = np.isfinite(x)
        # Unseen stretches part the line.
        for piece in np.split(np.arange(len(x)), np.flatnonzero(~seen)):
            points = [(float(x[i]), y[i]) for i in piece if seen[i]]
            if len(points) > 1:
                path(canvas, points, rgb(colour))

    def _draw_marks(self, canvas: Pixels, rows: tuple[int, int], scale: float) -> None:
        oldest, newest = (float(self._frame[row]) for row in rows)
        for collision, contact in zip(self._collisions, self._contacts, strict=True):
            if not oldest <= collision.frame < newest + 0.5:
                continue
            row = float(np.interp(collision.frame, self._frame, np.arange(len(self._frame))))
            below = max(MARK_PX + 1, _height(rows[1] - row))  # whole from the first moment
            at = ((contact + 0.5) * scale - 0.5, below)
            mark(canvas, collision.kind, at, MARK_PX, seen=collision.seen)
            corner = (round(at[0] + MARK_PX + 4), round(at[1] - 0.6 * NUMBER_PX))
            write(canvas, str(collision.number), corner, NUMBER_PX, (255, 255, 255))


def _height(rows_back: float) -> float:
    """Distance of a row's middle from the strip's top, by how many rows back it lies."""
    return ROW_PX * (rows_back + 0.5) - 0.5

"""Where and when the annotated clip shows what.

It plays slower where collisions follow each other fast, and faster where nothing happens.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from count_video.records import Floats
from count_video.reports.material import Point

HEADER_PX = 72
ROW_PX = 3
"""Height of one frame in the strip: a contact every 2.5 frames still has a mark of its own."""
STRIP_PX = 72 * ROW_PX


@dataclass(frozen=True)
class ClipLayout:
    """A picture of the clip: a header, the footage below it, and below that the strip."""

    scale: float
    """Pixels of the picture a pixel of the footage."""
    width_px: int
    """Even, as is the next."""
    footage_height_px: int

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the picture."""
        return self.width_px, HEADER_PX + self.footage_height_px + STRIP_PX

    def place(self, point: Point) -> Point:
        """Place of an image point of the footage; an integer is the centre of a pixel in both."""
        x, y = ((v + 0.5) * self.scale - 0.5 for v in point)
        return x, y + HEADER_PX


def layout_of(width_px: int, height_px: int) -> ClipLayout:
    """Scale footage so that lettering is readable (640 px) and no clip is huge (1280 px)."""
    scale = min(1.0, 1280 / max(width_px, height_px))
    if width_px * scale < 640:
        scale = 640 / width_px
    width = 2 * round(width_px * scale / 2)
    return ClipLayout(width / width_px, width, 2 * round(height_px * width / width_px / 2))


# ---- time ----------------------------------------------------------------------------------------

FASTEST_FPS = 30.0
"""Clips that play faster (their container has the capture rate) are slowed to this."""
BETWEEN_COLLISIONS_S = 0.7
"""Shortest time shown from one collision to the next: about what it takes to say a number."""
UNHURRIED_S = 0.8
"""Time before and after a collision in which the clip plays at its own rate."""
FORWARD_FPS = 180.0
"""Rate in the middle of empty stretches, as fast as browsers show frame by frame."""


def frame_times_s(
    frame: Floats, collision_frames: Sequence[float], playing_fps: float | None
) -> Floats:
    """Seconds from the clip's start at which each frame is shown, shape (n,), the first 0.

    ``frame`` are the frame coordinates of those shown, shape (n,), ``collision_frames`` increase,
    and ``playing_fps`` is the rate of the clip itself, None if it does not say. No frame stands
    still for more than 0.2 s, and stretches without a collision that would take more than 3 s are
    played fast in their middle.
    """
    rate = min(playing_fps or FASTEST_FPS, FASTEST_FPS)
    lasts, near = np.full(len(frame), 1.0 / rate), UNHURRIED_S * rate
    ends = [-np.inf, *collision_frames, np.inf] if len(collision_frames) else []
    for before, after in pairwise(ends):
        between = (frame >= before) & (frame < after)
        if np.isfinite(after - before):
            slower = min(BETWEEN_COLLISIONS_S / max(1, int(between.sum())), 0.2)
            lasts[between] = np.maximum(lasts[between], slower)
        if between.sum() > 3.0 * rate:
            lasts[(frame > before + near) & (frame < after - near)] = 1.0 / FORWARD_FPS
    return np.concatenate([[0.0], np.cumsum(lasts[:-1])])


def pace_words(shown_s: Floats) -> list[str]:
    """Say of each frame how fast the clip plays there, beside its own rate; empty if at that.

    ``shown_s`` says when each frame is shown, in seconds, shape (n,).
    """
    lasts_s = np.diff(shown_s, append=shown_s[-1:] + 1.0 / FASTEST_FPS)
    usual_s = lasts_s[lasts_s > 1.5 / FORWARD_FPS].min(initial=1.0 / FASTEST_FPS)
    words = []
    for slower in lasts_s / usual_s:
        faster = f"▶▶ {1 / slower:.0f}× faster" if slower < 0.67 else ""
        words.append(f"{slower:.0f}× slower" if slower > 1.5 else faster)
    return words

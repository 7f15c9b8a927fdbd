"""Where and when the annotated clip, and that for a talk, show what.

A clip for a talk is full HD, wide or upright, with a counter that the last row can read. Both play
slower where collisions follow each other fast, and faster where nothing happens.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from count_video.records import Floats, WallSide
from count_video.reports.material import Point
from count_video.settings import Shape

HEADER_PX = 72
ROW_PX = 3
"""Height of one frame in the strip: a contact every 2.5 frames still has a mark of its own."""
STRIP_PX = 72 * ROW_PX
SIZES: dict[Shape, tuple[int, int]] = {"wide": (1920, 1080), "upright": (1080, 1920)}
"""Width and height of a clip for a talk in px."""
COUNTER_PX: dict[Shape, int] = {"wide": 280, "upright": 600}
"""Size of its counter, unless the count is too long for that."""
MARGIN_PX = 40
"""Left free along its edges."""

Letters = tuple[Point, int, str]
"""Where a text begins or ends, the size of its type in px, and which of both: ``la`` if its left
top corner is at that place, ``ra`` if its right one is."""


@dataclass(frozen=True)
class ClipLayout:
    """Places of footage, strip and letters in a picture of the clip."""

    scale: float
    """Pixels of the picture a pixel of the footage."""
    size_px: tuple[int, int]
    """Width and height of the picture, which are even."""
    footage_px: tuple[int, int, int, int]
    """Left, top, width and height of the footage in it."""
    time_line_px: tuple[int, int, int]
    """Left and right end of the line of time, and its height in the picture."""
    letters: Mapping[str, Letters]
    """How the count, the noun, the last collision and its sign, the time and the pace are written,
    by these names."""
    with_strip: bool = True
    """Whether the strip lies below the footage."""
    shaded_px: tuple[int, int, int, int] = (0, 0, 0, 0)
    """Left, top, right and bottom of a ground that is darkened behind letters."""
    mark_px: float = 11.0
    """Half the width of a mark on the footage."""

    def place(self, point: Point) -> Point:
        """Place of an image point of the footage; an integer is the centre of a pixel in both."""
        x, y = ((v + 0.5) * self.scale - 0.5 for v in point)
        return x + self.footage_px[0], y + self.footage_px[1]


def layout_of(width_px: int, height_px: int) -> ClipLayout:
    """Scale footage so that lettering is readable (640 px) and no clip is huge (1280 px)."""
    scale = min(1.0, 1280 / max(width_px, height_px))
    if width_px * scale < 640:
        scale = 640 / width_px
    width = 2 * round(width_px * scale / 2)
    footage = 2 * round(height_px * width / width_px / 2)
    left, right = 112, width - 16  # the count has three digits at the most, with few exceptions
    letters: dict[str, Letters] = {
        "count": ((16, 6), 46, "la"),
        "noun": ((left, 8), 20, "la"),
        "sign": ((left, 36), 20, "la"),
        "last": ((left + 24, 36), 20, "la"),
        "time": ((right, 8), 20, "ra"),
        "pace": ((right, 36), 20, "ra"),
    }
    return ClipLayout(
        scale=width / width_px,
        size_px=(width, HEADER_PX + footage + STRIP_PX),
        footage_px=(0, HEADER_PX, width, footage),
        time_line_px=(left, right, HEADER_PX - 5),
        letters=letters,
    )


def presenter_layout(
    shape: Shape, width_px: int, height_px: int, wall: WallSide, most: int
) -> ClipLayout:
    """Fit footage into a clip for a talk, above the time line and, if upright, below the counter.

    The count, up to ``most``, stands in the corner that is farthest from the ball: away from the
    wall.
    """
    (width, height), upright, words = SIZES[shape], shape == "upright", 44
    digits = 0.64 * len(str(most))  # their width over the size of the type
    size = min(COUNTER_PX[shape], int((width - 2 * MARGIN_PX) / digits))
    below = round(1.2 * size) + words // 2
    above = below + 3 * words // 2
    left_over = height - (above + STRIP_PX if upright else 0) - 2 * MARGIN_PX
    scale = min(width / width_px, left_over / height_px)
    footage = round(scale * width_px), round(scale * height_px)
    spare = left_over - footage[1]
    edges = [(MARGIN_PX, "la"), (width - MARGIN_PX, "ra")]
    (near, beside_wall), (far, away) = edges if wall == "left" else edges[::-1]
    letters: dict[str, Letters] = {
        "count": ((far, 0), size, away),
        "sign": ((far, below), words, away),
        "last": ((far + (54 if far < near else -54), below), words, away),
        "pace": ((near, MARGIN_PX), words, beside_wall),
    }
    shaded = (width - 720, 0, width, above) if wall == "left" else (0, 0, 720, above)
    top = above + spare // 2 if upright else spare
    return ClipLayout(
        scale=scale,
        size_px=(width, height),
        footage_px=((width - footage[0]) // 2, top, *footage),
        time_line_px=(MARGIN_PX, width - MARGIN_PX, height - MARGIN_PX),
        letters=letters,
        with_strip=upright,
        shaded_px=(0, 0, 0, 0) if upright else shaded,
        mark_px=22.0,
    )


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

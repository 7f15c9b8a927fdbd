"""How fast the annotated clip plays: slower where collisions crowd, so that each can be seen."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from count_video.records import Floats

FASTEST_FPS = 30.0
"""Clips that play faster (their container tells the capture rate) are slowed to this."""
BETWEEN_COLLISIONS_S = 0.7
"""From one collision to the next at least this long; about what it takes to say a number."""
LONGEST_FRAME_S = 0.2
"""No frame stands still longer, however few there are between two collisions."""


def frame_times_s(
    frame: Floats, collision_frames: Sequence[float], playing_fps: float | None
) -> Floats:
    """Time at which each frame of the annotated clip is shown.

    Parameters
    ----------
    frame
        Frame coordinates of the frames shown, shape (n,).
    collision_frames
        Frame coordinates of the collisions, increasing.
    playing_fps
        Rate of the clip itself; None if it does not say.

    Returns
    -------
    Floats
        Seconds from the clip's start, shape (n,), the first 0.
    """
    rate = min(playing_fps or FASTEST_FPS, FASTEST_FPS)
    lasts = np.full(len(frame), 1.0 / rate)
    for before, after in pairwise(collision_frames):
        between = (frame >= before) & (frame < after)
        shown = max(1, int(between.sum()))
        slower = min(BETWEEN_COLLISIONS_S / shown, LONGEST_FRAME_S)
        lasts[between] = np.maximum(lasts[between], slower)
    return np.concatenate([[0.0], np.cumsum(lasts[:-1])])

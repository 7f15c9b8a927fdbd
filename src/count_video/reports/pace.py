"""How fast the annotated clip plays: slower where collisions follow each other fast."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from count_video.records import Floats

FASTEST_FPS = 30.0
"""Clips that play faster (their container has the capture rate) are slowed to this."""
BETWEEN_COLLISIONS_S = 0.7
"""Shortest time shown from one collision to the next: about what it takes to say a number."""
LONGEST_FRAME_S = 0.2
"""No frame stands still longer, however few there are between two collisions."""
PATIENCE_S = 3.0
"""Stretches without a collision that would take longer are played fast in their middle."""
UNHURRIED_S = 0.8
"""Time before and after a collision in which the clip plays at its own rate."""
FORWARD_FPS = 180.0
"""Rate in the middle of empty stretches, as fast as browsers show frame by frame."""


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
    lasts, near = np.full(len(frame), 1.0 / rate), UNHURRIED_S * rate
    ends = [-np.inf, *collision_frames, np.inf] if len(collision_frames) else []
    for before, after in pairwise(ends):
        between = (frame >= before) & (frame < after)
        if np.isfinite(after - before):
            slower = min(BETWEEN_COLLISIONS_S / max(1, int(between.sum())), LONGEST_FRAME_S)
            lasts[between] = np.maximum(lasts[between], slower)
        if between.sum() > PATIENCE_S * rate:
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

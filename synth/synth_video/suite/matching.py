"""Which collision found is which of the truth.

Both are places on the axis of frames. A pair may be matched when it lies within the window of the
true collision::

    truth       |        |            |
    window    [---]    [---]       [--+--]
    found      x     x   x x
               1         2              3     1 and 2 matched, 3 missed, two found are invented

As many as possible are matched, each at most once, and among such matchings the one with the
smallest sum of squared distances. Squares keep the order of time: two pairs that cross cost more
than the same four uncrossed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from count_video.records import Floats

LEAST_WINDOW_FRAMES = 1.25
"""Half of the 2.5 frames by which resolved collisions are apart at least."""
MOST_WINDOW_FRAMES = 6.0
"""A collision that lies far from all others is still not found this far off: bodies that creep
together at a hundredth of a pixel a frame meet within a few frames, no more."""


def windows(true_frames: Sequence[float]) -> Floats:
    """Reach of each true collision: half the way to its nearest neighbour, within the limits."""
    frames = np.asarray(true_frames, dtype=float)
    gaps = np.concatenate([[np.inf], np.diff(frames), [np.inf]])
    half = np.minimum(gaps[:-1], gaps[1:]) / 2
    return np.asarray(np.clip(half[: len(frames)], LEAST_WINDOW_FRAMES, MOST_WINDOW_FRAMES))


def match(true_frames: Sequence[float], found_frames: Sequence[float]) -> list[tuple[int, int]]:
    """Pair true and found collisions.

    Parameters
    ----------
    true_frames, found_frames
        Frame coordinates, each in order of time.

    Returns
    -------
    list of (int, int)
        Places in the two sequences, in order of time.
    """
    if not (len(true_frames) and len(found_frames)):
        return []
    true, found = np.asarray(true_frames, dtype=float), np.asarray(found_frames, dtype=float)
    apart = np.abs(true[:, None] - found)
    possible = apart <= windows(true_frames)[:, None]
    # A pair beyond the window costs more than all others together, so none is taken needlessly.
    forbidden = (len(true) + 1) * MOST_WINDOW_FRAMES**2
    rows, columns = linear_sum_assignment(np.where(possible, apart**2, forbidden))
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return [(row, column) for row, column in pairs if possible[row, column]]

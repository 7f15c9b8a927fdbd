"""The collisions that the frames show, by the times of the pictures that explain the track best.

Where neither the heavy body's path nor anything else speaks against even frames, they are even.
Whether the collisions leave doubts has no say in which times explain the track better: the count
must not choose its own times.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from count_video.motion.changing_rates import Timed, likeliest_change, scatter_of
from count_video.motion.seen import (
    NOTHING_SEEN,
    RESOLVED_FRAMES,
    SeenCollisions,
    seen_collisions,
    shows_motion,
)
from count_video.motion.time_base import TimeBase, even
from count_video.motion.time_hypotheses import FACTOR_AT_LEAST, with_copies
from count_video.records import Track


def seen_by_time_base(track: Track) -> tuple[TimeBase, SeenCollisions]:
    """Find the collisions by the times that the pictures were taken at, which come with them."""
    if not shows_motion(track):
        return even(track.frame), NOTHING_SEEN
    base = with_copies(track) or even(track.frame)
    found = seen_collisions(base.evened(track))
    # At the two ends of the least change of a rate, a collision keeps too little speed or too much.
    least = np.log(FACTOR_AT_LEAST) * np.sqrt(2 / max(found.burst, 2))
    if found.path_fits and found.is_whole and scatter_of(found) < least:
        return base, found
    other = likeliest_change(track, Timed(base, found))
    return (other.base, other.found) if other and _is_sure(other) else (base, found)


def _is_sure(by: Timed) -> bool:
    """Whether a changing rate leaves nothing open, and the heavy body keeps to its path."""
    found = by.found
    fits = found.swing is not None and found.swing.fits
    return fits and not found.doubts and found.fit_may_settle and resolves(by)


def resolves(by: Timed) -> bool:
    """Whether there are pictures enough between collisions also where they are rarer."""
    return all(b.frame - a.frame >= RESOLVED_FRAMES for a, b in pairwise(by.burst))

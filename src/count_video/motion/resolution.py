"""Judge whether the frames show every collision, or some may lie between them.

Neighbouring collisions must be of different kinds: the ball cannot strike the same thing twice
without striking the other, unless it turned round visibly by itself. And they must be far enough
apart for the frames to show each. Where a pair is missed all the same, the fit of the whole burst
does not describe the track, or by another count.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from count_video.motion.gaps import Gaps
from count_video.motion.reasons import Cause, Reason
from count_video.records import Collision
from count_video.signals import sigma_of

RESOLVED_FRAMES = 2.5
"""From this interval on every flight of the ball holds at least one frame clear of corners."""
TURN_FRAMES = 12
"""A ball that turns round by itself between two collisions of a kind is seen for so long, ..."""
TURN_CLEAR_SHARE = 0.2
"""... and keeps this share of its largest distance from what it did not strike: nearer to it, a
blurred zigzag looks like a turn."""


def unresolved(candidates: Sequence[Collision], gaps: Gaps, pace: float) -> list[Reason]:
    """Say which collisions may be missing; empty if the pictures show them all.

    Collisions and gaps count in pictures, of which each takes ``pace`` frames.
    """
    found = []
    for before, after in pairwise(candidates):
        if before.kind == after.kind and not _turned(before, after, gaps):
            cause = Cause.BODY_MISSED if before.kind == "wall" else Cause.WALL_MISSED
            found.append(Reason(cause, (before.frame * pace, after.frame * pace)))
    shortest = shortest_interval(candidates)
    if shortest < RESOLVED_FRAMES:
        found.append(Reason(Cause.UNRESOLVED, (shortest, RESOLVED_FRAMES)))
    return found


def shortest_interval(candidates: Sequence[Collision]) -> float:
    """Shortest time between neighbouring collisions in frames; inf for fewer than two."""
    return min((b.frame - a.frame for a, b in pairwise(candidates)), default=float("inf"))


def _turned(before: Collision, after: Collision, gaps: Gaps) -> bool:
    """Whether the gap opened and closed again smoothly, over many frames."""
    signal = gaps.closing(before.kind)
    inside = (gaps.frame > before.frame + 1) & (gaps.frame < after.frame - 1)
    inside &= np.isfinite(signal)
    if inside.sum() < TURN_FRAMES:
        return False
    other = gaps.closing("bodies" if before.kind == "wall" else "wall")
    clear = other[inside & np.isfinite(other)] - np.nanmin(other)
    if len(clear) == 0 or clear.min() < TURN_CLEAR_SHARE * clear.max():
        return False
    frame, values = gaps.frame[inside], signal[inside]
    smooth = np.polynomial.Polynomial.fit(frame, values, 4)
    left_over = float(np.sqrt(np.mean((values - smooth(frame)) ** 2)))
    return left_over < 4 * sigma_of(signal)

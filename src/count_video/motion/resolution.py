"""Judge whether the frames show every collision, or some may lie between them.

Neighbouring collisions must be of different kinds, and far enough apart for the frames to show
each. Where a pair is missed all the same, the fit of the whole burst does not describe the track,
or by another count.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from count_video.reasons import Cause, Reason
from count_video.records import Collision

RESOLVED_FRAMES = 2.5
"""From this interval on every flight of the ball holds at least one frame clear of corners."""


def unresolved(candidates: Sequence[Collision], pace: float) -> list[Reason]:
    """Say which collisions may be missing; empty if the pictures show them all.

    Collisions count in pictures, of which each takes ``pace`` frames.
    """
    found = []
    for before, after in pairwise(candidates):
        if before.kind == after.kind:
            cause = Cause.BODY_MISSED if before.kind == "wall" else Cause.WALL_MISSED
            found.append(Reason(cause, (before.frame * pace, after.frame * pace)))
    shortest = shortest_interval(candidates)
    if shortest < RESOLVED_FRAMES:
        found.append(Reason(Cause.UNRESOLVED, (shortest, RESOLVED_FRAMES)))
    return found


def shortest_interval(candidates: Sequence[Collision]) -> float:
    """Shortest time between neighbouring collisions in frames; inf for fewer than two."""
    return min((b.frame - a.frame for a, b in pairwise(candidates)), default=float("inf"))

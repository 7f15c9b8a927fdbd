"""Judge whether the frames show every collision, or some may lie between them.

Three checks on neighbouring collisions. They must be of different kinds: the ball cannot strike
the same thing twice without striking the other, unless it turned round visibly by itself. They
must be far enough apart for the frames to show each. And the time from one to the next must fall
to the middle of the burst and rise after it, as the room that the ball has does: where two are
missed, what is left is three times as long as its neighbours.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from count_video.motion.burst import Burst
from count_video.motion.gaps import Gaps
from count_video.motion.reasons import Cause, Reason
from count_video.records import Collision
from count_video.signals import sigma_of

RESOLVED_FRAMES = 2.5
"""From this interval on every flight of the ball holds at least one frame clear of corners."""
LONG_FLIGHT = 1.5
LONG_FLIGHT_FRAMES = 1.0
"""A flight longer than both a flight before it and one after it, by this factor and so many frames,
hides two collisions. In simulated bursts, with threads, losses and their scatter drawn at random,
no flight is longer by 5 %."""
UNEXPLAINED_SIGMAS = 10.0
"""Jumps of the velocity by so much are no accidents of noise."""
TURN_FRAMES = 12
"""A ball that turns round by itself between two collisions of a kind is seen for so long, ..."""
TURN_CLEAR_SHARE = 0.2
"""... and keeps this share of its largest distance from what it did not strike: nearer to it, a
blurred zigzag looks like a turn."""


def unexplained(
    elsewhere: Sequence[tuple[float, float]],
    inside: Sequence[Collision],
    burst: Burst,
    pace: float,
) -> list[Reason]:
    """Say where, within the burst, the ball clearly turns without a contact.

    A body that is not followed rightly (it spins, or something was taken for it) may strike
    something where its place says that there is nothing. ``elsewhere`` are the frames at which it
    jumps without a contact, and by how many standard uncertainties; ``inside`` is the burst.
    """
    first = inside[0].frame if inside else np.inf
    clear = sorted(
        frame * pace
        for frame, clarity in elsewhere
        if first < frame < burst.end_frame and clarity > UNEXPLAINED_SIGMAS
    )
    return [Reason(Cause.JUMPS_ELSEWHERE, tuple(clear))] if clear else []


def unresolved(candidates: Sequence[Collision], gaps: Gaps, pace: float) -> list[Reason]:
    """Say which collisions may be missing; empty if the pictures show them all.

    Collisions and gaps count in pictures, of which each takes ``pace`` frames.
    """
    found = []
    for before, after in pairwise(candidates):
        if before.kind == after.kind and not _turned(before, after, gaps):
            cause = Cause.BODY_MISSED if before.kind == "wall" else Cause.WALL_MISSED
            found.append(Reason(cause, (before.frame * pace, after.frame * pace)))
    for before, after in long_flights(candidates):
        found.append(Reason(Cause.PAIR_MISSED, (before.frame * pace, after.frame * pace)))
    shortest = shortest_interval(candidates)
    if shortest < RESOLVED_FRAMES:
        found.append(Reason(Cause.UNRESOLVED, (shortest, RESOLVED_FRAMES)))
    return found


def long_flights(candidates: Sequence[Collision]) -> list[tuple[Collision, Collision]]:
    """Pairs of neighbours between which the ball took longer than both before and after."""
    flights = np.diff([candidate.frame for candidate in candidates])
    if len(flights) < 3:
        return []
    before = np.minimum.accumulate(flights)[:-2]
    after = np.minimum.accumulate(flights[::-1])[::-1][2:]
    allowed = LONG_FLIGHT * np.maximum(before, after) + LONG_FLIGHT_FRAMES
    places = (np.flatnonzero(flights[1:-1] > allowed) + 1).tolist()
    return [(candidates[place], candidates[place + 1]) for place in places]


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

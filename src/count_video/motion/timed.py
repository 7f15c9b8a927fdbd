"""The collisions that the frames show, by the times of the pictures that explain the track best.

Where neither the heavy body's path nor anything else speaks against even frames, they are even.
Copies show in the steps of the bodies, frames left out in steps of the heavy body's place. By times
whose rate changes the heavy body must stray much less from its path, for they have two more
parameters to choose; whether the collisions leave doubts has no say: the count must not choose its
own times.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from count_video.motion.copies import with_copies
from count_video.motion.left_out import LeftOut, left_out
from count_video.motion.ramps import Ramp, ramps_of, sharpened, stray_px
from count_video.motion.resolution import RESOLVED_FRAMES
from count_video.motion.seen import (
    NOTHING_SEEN,
    SeenCollisions,
    seen_collisions,
    shows_motion,
)
from count_video.motion.time_base import TimeBase, even
from count_video.reasons import LEFT_TO_THE_FIT, Cause, Reason
from count_video.records import Track

STRAYS_LESS = 0.6
"""A changing rate has two more parameters to choose. What the path leaves over hangs together over
some ten pictures: of a hundred that is worth ten numbers, and by chance, at three standard
deviations, two parameters take up to two thirds of their squares."""
SHARPENED_AT_MOST = 3
"""So many ramps are fitted closely, those by which the heavy body strays least: first by the
collisions that even frames show, then by their own."""
STEP_FRAMES = 3.0
"""A change of the rate this near to a step of the places is that step: a rate makes none."""


def seen_by_time_base(track: Track) -> tuple[TimeBase, SeenCollisions, LeftOut | None]:
    """Find the collisions by the times that the pictures were taken at.

    Returns the times, what the track shows by them, and the frames left out that they allow for.
    """
    if not shows_motion(track):
        return even(track.frame), NOTHING_SEEN, None
    copies = with_copies(track)
    base = copies or even(track.frame)
    found = seen_collisions(base.evened(track))
    gap = None if copies else left_out(track, found.collisions, found.burst)
    if gap is None and found.path_fits and found.is_whole:
        return base, found, None
    whole = gap.time_base(track.frame) if gap else base
    without = seen_collisions(whole.evened(track)) if gap else found
    ramp = _likeliest_ramp(track, base, found)
    if ramp is not None:
        steady = ramp.time_base(track.frame)
        other = seen_collisions(steady.evened(track), pace=1.0)
        likelier = gap is None or (
            min(abs(change - gap.after) for change in ramp.changes) > STEP_FRAMES
            and _stray_px(steady, track, other) < _stray_px(whole, track, without)
        )
        if likelier and _is_sure(other) and resolves(steady, other):
            return steady, other, None
    # In frames left out there may have been collisions.
    lacks = (Reason(Cause.LEFT_OUT, (gap.after, gap.frames)),) if gap else ()
    return whole, replace(without, doubts=(*without.doubts, *lacks)), gap


def _is_sure(found: SeenCollisions) -> bool:
    ahead = all(reason.cause in LEFT_TO_THE_FIT for reason in found.shortcomings)
    return found.path_fits and not found.doubts and ahead


def resolves(base: TimeBase, found: SeenCollisions) -> bool:
    """Whether there are pictures enough between collisions also where they are rarer."""
    frames = [base.shown(collision).frame for collision in found.collisions[: found.burst]]
    return all(b - a >= RESOLVED_FRAMES for a, b in pairwise(frames))


def _stray_px(base: TimeBase, track: Track, found: SeenCollisions) -> float:
    """By how much the heavy body strays from its path through the burst."""
    return base.stray_px(track, found.collisions[: found.burst])


def _likeliest_ramp(track: Track, base: TimeBase, found: SeenCollisions) -> Ramp | None:
    """Find the changing rate by which the heavy body strays least; None if the ``base`` does.

    ``found`` is what the clip shows by the base.
    """
    shown = found.collisions[: found.burst]
    nearest = sorted(ramps_of(track, shown), key=lambda ramps: stray_px(ramps[0], track, shown))
    tried = []
    for ramps in nearest[:SHARPENED_AT_MOST]:
        steady = ramps[0].time_base(track.frame)
        seen = seen_collisions(steady.evened(track), pace=1.0)
        own = [steady.shown(collision) for collision in seen.collisions[: seen.burst]]
        slow = [ramp for ramp in ramps if ramp.slows([one.frame for one in own])]
        tried += [(stray_px(ramp, track, own), ramp, own) for ramp in slow]
    best = sorted(tried, key=lambda one: one[0])[:SHARPENED_AT_MOST]
    sharp = [sharpened(ramp, track, own) for _, ramp, own in best]
    stray, ramp = min(sharp, key=lambda one: one[0], default=(float("inf"), None))
    return ramp if stray < STRAYS_LESS * _stray_px(base, track, found) else None

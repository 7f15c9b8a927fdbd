"""The collisions that the frames show, by the times of the pictures that explain the track best.

Where neither the heavy body's path nor anything else speaks against even frames, they are even. By
times whose rate changes the heavy body must stray much less from its path, for they have two more
parameters to choose; whether the collisions leave doubts has no say: the count must not choose its
own times.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

from count_video.motion.gaps import gaps_of
from count_video.motion.seen import (
    NOTHING_SEEN,
    RESOLVED_FRAMES,
    SeenCollisions,
    seen_collisions,
    shows_motion,
)
from count_video.motion.swing import fit_swing
from count_video.motion.time_base import Ramp, TimeBase, even
from count_video.motion.time_hypotheses import ramps_of, with_copies
from count_video.records import Collision, Track

STRAYS_LESS = 0.6
"""A changing rate has two more parameters to choose. What the path leaves over hangs together over
some ten pictures: of a hundred that is worth ten numbers, and by chance, at three standard
deviations, two parameters take up to two thirds of their squares."""


def seen_by_time_base(track: Track) -> tuple[TimeBase, SeenCollisions]:
    """Find the collisions by the times that the pictures were taken at, which come with them."""
    if not shows_motion(track):
        return even(track.frame), NOTHING_SEEN
    base = with_copies(track) or even(track.frame)
    found = seen_collisions(base.evened(track))
    if found.path_fits and found.is_whole:
        return base, found
    ramp = _likeliest_ramp(track, base, found)
    if ramp is not None:
        steady = ramp.time_base(track.frame)
        other = seen_collisions(steady.evened(track), pace=1.0)
        if _is_sure(other) and resolves(steady, other):
            return steady, other
    return base, found


def stray_px(base: TimeBase, track: Track, shown: Iterable[Collision]) -> float:
    """By how much the heavy body strays from its path by a time base; inf if it is not known.

    ``shown`` are the collisions of the clip, in frames.
    """
    swing = fit_swing(gaps_of(base.evened(track)), [base.timed(one) for one in shown])
    return float("inf") if swing is None else swing.stray_px


def _burst(base: TimeBase, found: SeenCollisions) -> list[Collision]:
    """List the collisions of a burst in frames."""
    return [base.shown(collision) for collision in found.collisions[: found.burst]]


def _is_sure(found: SeenCollisions) -> bool:
    return found.path_fits and not found.doubts and found.fit_may_settle


def resolves(base: TimeBase, found: SeenCollisions) -> bool:
    """Whether there are pictures enough between collisions also where they are rarer."""
    return all(b.frame - a.frame >= RESOLVED_FRAMES for a, b in pairwise(_burst(base, found)))


def _likeliest_ramp(track: Track, base: TimeBase, found: SeenCollisions) -> Ramp | None:
    """Find the changing rate by which the heavy body strays least; None if the ``base`` does.

    ``found`` is what the clip shows by the base.
    """
    shown = _burst(base, found)
    frames = [one.frame for one in shown]
    strays = {
        ramp: stray_px(ramp.time_base(track.frame), track, shown)
        for ramp in ramps_of(track, shown)
        if ramp.slows(frames)
    }
    nearest = min(strays, key=strays.__getitem__, default=None)
    most = STRAYS_LESS * stray_px(base, track, shown)
    return nearest if nearest is not None and strays[nearest] < most else None

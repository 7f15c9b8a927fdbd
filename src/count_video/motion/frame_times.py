"""The clock that a clip was made by, and the collisions by it.

Frames are usually as even as the camera took them. Converters put copies between them, and
slow-motion exports leave pictures out in a part of the clip; what is then found by an even clock
has to be placed among the frames that show it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from count_video.motion.cadence import Cadence, cadence_of
from count_video.motion.gaps import gaps_of
from count_video.motion.left_out import LeftOut, left_out
from count_video.motion.ramps import Ramp, ramps_of, sharpened, stray_px
from count_video.motion.seen import (
    NOTHING_SEEN,
    SeenCollisions,
    seen_collisions,
    shows_motion,
)
from count_video.motion.swing import fit_path, path_fits
from count_video.reasons import ENDS_EARLY, Cause, Reason
from count_video.records import Collision, Track

STRAYS_LESS = 0.6
"""A clock of changing rate has two more parameters to choose. What the path leaves over hangs
together over some ten pictures: of a hundred that is worth ten numbers, and by chance, at three
standard deviations, two parameters take up to two thirds of their squares."""
SHARPENED_AT_MOST = 3
"""So many clocks are fitted closely, those by which the cylinder strays least: first by the
collisions that an even clock shows, then by their own."""

STEP_FRAMES = 3.0
"""A change of the rate this near to a step of the places is that step: a rate makes none."""

Clock = Cadence | Ramp | LeftOut


def seen_by_clock(track: Track) -> tuple[Clock | None, Track, SeenCollisions]:
    """Find the collisions by the clock that the clip was made by.

    Returns the clock (None where the frames are even), the track by that clock, and what it shows.
    """
    if not shows_motion(track):
        return None, track, NOTHING_SEEN
    cadence = cadence_of(track)
    even = cadence.evened(track) if cadence else track
    found = seen_collisions(even)
    gap = left_out(even, found.collisions, found.burst) if cadence is None else None
    if gap is None and found.path_fits and not found.doubts and not found.shortcomings:
        return cadence, even, found
    whole = gap.evened(even) if gap else even
    without = seen_collisions(whole) if gap else found
    ramp = likeliest_ramp(track, found)
    if ramp is not None:
        steady = ramp.evened(track)
        other = _judged_by_burst(seen_collisions(steady, pace=1.0), steady)
        ahead = all(reason.cause in ENDS_EARLY for reason in other.shortcomings)
        sure = other.path_fits and not other.doubts and ahead
        likelier = gap is None or (
            not gap.flown
            and min(abs(change - gap.after) for change in ramp.changes) > STEP_FRAMES
            and _stray_px(steady, other) < _stray_px(whole, without)
        )
        if sure and likelier and ramp.resolves(other.collisions[: other.burst]):
            return ramp, steady, other
    if gap is not None:
        return gap, whole, replace(without, doubts=(*without.doubts, *gap.doubts))
    return cadence, even, found


def _stray_px(track: Track, found: SeenCollisions) -> float:
    """By how much the cylinder strays from its path through the burst; inf where none is known."""
    path = fit_path(gaps_of(track), found.collisions[: found.burst])
    return float("inf") if path is None else path.stray_px


def _judged_by_burst(found: SeenCollisions, track: Track) -> SeenCollisions:
    """Let the cylinder's path confirm the burst alone.

    A clip that leaves pictures out after it may not show each collision that follows.
    """
    gaps = gaps_of(track)
    if not path_fits(fit_path(gaps, found.collisions[: found.burst]), gaps):
        return found
    others = tuple(one for one in found.shortcomings if one.cause is not Cause.STRAYS)
    return replace(found, path_fits=True, shortcomings=others)


def likeliest_ramp(track: Track, found: SeenCollisions) -> Ramp | None:
    """Find the clock by which the cylinder strays least from its path; None if it is even.

    ``found`` is what the clip shows by an even clock. Whether the collisions by the clock leave
    doubts has no say: the count must not choose its own clock.
    """
    even = found.collisions[: found.burst]
    nearest = sorted(ramps_of(track, even), key=lambda ramps: stray_px(ramps[0], track, even))
    tried = []
    for ramps in nearest[:SHARPENED_AT_MOST]:
        seen = seen_collisions(ramps[0].evened(track), pace=1.0)
        shown = [ramps[0].shown(collision) for collision in seen.collisions[: seen.burst]]
        slow = [ramp for ramp in ramps if ramp.slows(shown)]
        tried += [(stray_px(ramp, track, shown), ramp, shown) for ramp in slow]
    best = sorted(tried, key=lambda one: one[0])[:SHARPENED_AT_MOST]
    sharp = [sharpened(ramp, track, shown) for _, ramp, shown in best]
    stray, ramp = min(sharp, key=lambda one: one[0], default=(np.inf, None))
    return ramp if stray < STRAYS_LESS * _stray_px(track, found) else None


def as_shown(collisions: Sequence[Collision], clock: Clock | None) -> tuple[Collision, ...]:
    """Place collisions among the frames that show them, where these were not taken evenly."""
    return tuple(collisions if clock is None else map(clock.shown, collisions))


def notes_of(clock: Clock | None, more: LeftOut | None = None) -> tuple[Reason, ...]:
    """Say what is unusual about a clip's times; ``more`` frames are left out besides."""
    unusual = clock
    if more is not None:
        unusual = more.joined(clock if isinstance(clock, LeftOut) else None)
    return () if unusual is None or isinstance(unusual, Cadence) else (unusual.note,)

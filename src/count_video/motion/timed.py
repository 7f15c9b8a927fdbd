"""The collisions that the frames show, by the times of the pictures that explain the track best.

Where neither the heavy body's path nor anything else speaks against even frames, they are even. By
times whose rate changes the heavy body must stray much less from its path, for they have two more
parameters to choose; whether the collisions leave doubts has no say: the count must not choose its
own times.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise
from operator import itemgetter

import numpy as np

from count_video.motion.gaps import gaps_of
from count_video.motion.seen import (
    NOTHING_SEEN,
    RESOLVED_FRAMES,
    SeenCollisions,
    seen_collisions,
    shows_motion,
)
from count_video.motion.swing import CORRELATED_FRAMES, fit_swing
from count_video.motion.time_base import Ramp, TimeBase, even
from count_video.motion.time_hypotheses import FACTOR_SHARE, ramps_of, with_copies
from count_video.records import Collision, Floats, Track

STRAYS_LESS = 0.6
"""A changing rate has two more parameters to choose. What the path leaves over hangs together over
some ten pictures: of a hundred that is worth ten numbers, and by chance, at three standard
deviations, two parameters take up to two thirds of their squares."""
STEP_FRAMES = 2.0
"""First steps of the places of a change: so unsure are the places that the speeds show."""
PLACE_FRAMES = 0.02
"""Tolerance of these places, far below what the collisions' times hang on."""
BY_TURNS = 2
"""So often the places of a change and the collisions are found, each from the other."""


def seen_by_time_base(track: Track) -> tuple[TimeBase, SeenCollisions]:
    """Find the collisions by the times that the pictures were taken at, which come with them."""
    if not shows_motion(track):
        return even(track.frame), NOTHING_SEEN
    base = with_copies(track) or even(track.frame)
    found = seen_collisions(base.evened(track))
    if found.path_fits and found.is_whole:
        return base, found
    likely = _likeliest_change(track, base, found)
    if likely is None:
        return base, found
    steady, other = base, found
    for _ in range(BY_TURNS):
        steady = _fitted(*likely, track, _burst(steady, other)).time_base(track.frame)
        other = seen_collisions(steady.evened(track), pace=1.0)
    return (steady, other) if _is_sure(other) and resolves(steady, other) else (base, found)


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
    fits = found.swing is not None and found.swing.fits
    return fits and not found.doubts and found.fit_may_settle


def resolves(base: TimeBase, found: SeenCollisions) -> bool:
    """Whether there are pictures enough between collisions also where they are rarer."""
    return all(b.frame - a.frame >= RESOLVED_FRAMES for a, b in pairwise(_burst(base, found)))


def _likeliest_change(
    track: Track, base: TimeBase, found: SeenCollisions
) -> tuple[Ramp, float] | None:
    """Find the changing rate by which the heavy body strays least; None if the ``base`` does.

    ``found`` is what the clip shows by the base. With the rate comes the factor that speeds show.
    """
    shown = _burst(base, found)
    frames = [one.frame for one in shown]
    strays = {
        (ramp, factor): stray_px(ramp.time_base(track.frame), track, shown)
        for ramp, factor in ramps_of(track, shown)
        if ramp.slows(frames)
    }
    nearest = min(strays, key=strays.__getitem__, default=None)
    most = STRAYS_LESS * stray_px(base, track, shown)
    return nearest if nearest is not None and strays[nearest] < most else None


def _fitted(ramp: Ramp, factor: float, track: Track, shown: list[Collision]) -> Ramp:
    """Find the places and the factor of a changing rate that explain the heavy body's path best.

    The speeds of few pictures give the ``factor`` about, and the places to a picture or two. The
    ``shown`` collisions are placed by them too, so that both are found by turns.
    """
    fits = []
    for whole in range(max(2, ramp.factor - 1), ramp.factor + 2):
        other, stray = _placed(replace(ramp, factor=whole), track, shown)
        # Half the squares in standard deviations of the path, and of the factor at each change.
        off = np.log(whole / factor) / np.log1p(FACTOR_SHARE)
        path = len(track.frame) / CORRELATED_FRAMES * np.log(stray)
        fits.append((path + len(ramp.changes) * off**2 / 2, other))
    return min(fits, key=itemgetter(0))[1]


def _placed(ramp: Ramp, track: Track, shown: list[Collision]) -> tuple[Ramp, float]:
    """Place the changes of a rate where the heavy body strays least, which comes with them."""
    from scipy.optimize import minimize  # noqa: PLC0415

    def stray(changes: Floats) -> float:
        moved = replace(ramp, changes=tuple(changes.tolist()))
        return stray_px(moved.time_base(track.frame), track, shown)

    start = np.array(ramp.changes, dtype=np.float64)
    corners = np.vstack([start, start + STEP_FRAMES * np.eye(len(start))])
    best = minimize(
        stray,
        start,
        method="Nelder-Mead",
        options={"initial_simplex": corners, "xatol": PLACE_FRAMES},
    )
    return replace(ramp, changes=tuple(best.x.tolist())), float(best.fun)

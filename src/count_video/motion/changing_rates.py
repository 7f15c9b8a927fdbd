"""Where the rate of a clip changes, and by which factor, from all that the track shows.

The speeds of few pictures give the places of changes to a picture or two, and the factor to a third
(see ``time_hypotheses``). By the times that follow, collisions are found; with these the heavy body
follows its path (see ``swing``), whose places give both more sharply, and by these the collisions
are found anew.

By wrong times the heavy body strays from its path, and the restitution seems to scatter. Standard
deviations s of k independent residuals that are normal, of which s is not known, have the
likelihood s^-k.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from count_video.motion.gaps import gaps_of
from count_video.motion.priors import SCATTERS
from count_video.motion.seen import (
    RESOLVED_FRAMES,
    SeenCollisions,
    seen_collisions,
    shows_motion,
)
from count_video.motion.swing import CORRELATED_FRAMES, fit_swing
from count_video.motion.time_base import Ramp, TimeBase, even
from count_video.motion.time_hypotheses import (
    FACTOR_AT_LEAST,
    FACTOR_SHARE,
    ramps_of,
    usual_times,
)
from count_video.records import Collision, Floats, Track

STRAYS_LESS = 0.6
"""A changing rate has two more parameters to choose. What the path leaves over hangs together over
some ten pictures: of a hundred that is worth ten numbers, and by chance, at three standard
deviations, two parameters take up to two thirds of their squares."""
STEP_FRAMES = 2.0
"""First steps of the places of a change: so unsure are the places that the speeds show."""
PLACE_FRAMES = 0.02
"""Tolerance of these places, far below what the collisions' times hang on."""
UNKNOWN_PX = 1e6
"""Stray of a heavy body that shows no path."""


class Timed(NamedTuple):
    """Collisions of a track by one hypothesis about the times of its pictures."""

    base: TimeBase
    found: SeenCollisions

    @property
    def burst(self) -> list[Collision]:
        """The burst among the frames of the clip."""
        return [self.base.shown(one) for one in self.found.collisions[: self.found.burst]]


def _timed_by(ramp: Ramp, track: Track) -> Timed:
    """Find the collisions of a track by a changing rate."""
    base = ramp.time_base(track.frame)
    return Timed(base, seen_collisions(base.evened(track), pace=1.0))


def seen_by_time_bases(track: Track) -> list[Timed]:
    """Find the collisions by the times of the pictures that may explain a track, likeliest first.

    Where neither the heavy body's path nor anything else speaks against even frames, they are even.
    Whether the collisions leave doubts has no say in that: the count must not choose its own times.
    """
    if not shows_motion(track):
        return [Timed(even(track.frame), SeenCollisions((), 0))]
    base = usual_times(track)
    steady = Timed(base, seen_collisions(base.evened(track)))
    found = steady.found
    # At the two ends of the least change of a rate, a collision keeps too little speed or too much.
    least = np.log(FACTOR_AT_LEAST) * np.sqrt(2 / max(found.burst, 2))
    if found.path_fits and found.is_whole and scatter_of(found) < least:
        return [steady]
    # What the pictures are too rare for by even times they are too rare for by any.
    changing = likeliest_change(track, steady) if resolves(steady) else None
    return [changing, steady] if changing and _is_sure(changing) else [steady]


def _is_sure(by: Timed) -> bool:
    """Whether a changing rate leaves nothing open, and the heavy body keeps to its path."""
    found = by.found
    return found.path_fits and not found.doubts and found.fit_may_settle and resolves(by)


def resolves(by: Timed) -> bool:
    """Whether there are pictures enough between collisions also where they are rarer."""
    return all(b.frame - a.frame >= RESOLVED_FRAMES for a, b in pairwise(by.burst))


def likeliest_change(track: Track, steady: Timed) -> Timed | None:
    """Fit the change of the rate that explains a track best; None if an even one does.

    ``steady`` is what the clip shows by an even rate.
    """
    begun: dict[int, list[tuple[float, Ramp, float]]] = {1: [], 2: []}
    # By no times do the restitutions scatter by less.
    steadier = steady.found.burst * np.log(scatter_of(steady.found) / SCATTERS[-1])
    for ramp, factor in ramps_of(track, steady.burst):
        gain = _gain_of_path(track, ramp, ramp.time_base(track.frame), steady.burst, steady)
        if gain + steadier > 0:
            begun[len(ramp.changes)].append((gain, ramp, factor))
    fits = []
    for some in filter(None, begun.values()):
        _, ramp, factor = max(some, key=itemgetter(0))
        by = _timed_by(ramp, track)
        if _gain(track, ramp, by, steady) > 0 and ramp.slows([one.frame for one in by.burst]):
            ramp = _fitted(ramp, factor, track, by.burst)
            by = _timed_by(ramp, track)
            fits.append((_gain(track, ramp, by, steady), by))
    best, likeliest = max(fits, key=itemgetter(0), default=(0.0, None))
    return likeliest if best > 0 else None


def _gain(track: Track, ramp: Ramp, by: Timed, steady: Timed) -> float:
    """Logarithm of the ratio of the likelihoods of a changing rate and an even one."""
    count = min(by.found.burst, steady.found.burst)
    steadier = count * np.log(scatter_of(steady.found) / scatter_of(by.found))
    return _gain_of_path(track, ramp, by.base, by.burst, steady) + float(steadier)


def _gain_of_path(
    track: Track, ramp: Ramp, base: TimeBase, burst: Sequence[Collision], steady: Timed
) -> float:
    """Logarithm of the ratio of the likelihoods of the heavy body's path by two time bases.

    Of ``STRAYS_LESS`` as much is taken off; -inf where it shows no path. ``burst`` are collisions
    among the frames.
    """
    even_px, _ = _path(track, steady.base, steady.burst, ramp)
    stray_px, weight = _path(track, base, burst, ramp)
    if max(even_px, stray_px) >= UNKNOWN_PX:
        return -np.inf
    return float(weight * np.log(STRAYS_LESS * even_px / stray_px))


def scatter_of(found: SeenCollisions) -> float:
    """Scatter of the restitution over a burst: standard deviation of its logarithm, of each kind.

    It holds what restitutions scatter by at most.
    """
    off = [0.0]
    for kind in ("bodies", "wall"):
        kept = [_kept(one) for one in found.collisions[: found.burst] if one.kind == kind]
        shown = np.log([share for share in kept if share > 0])
        off += (shown - np.median(shown)).tolist() if len(shown) else []
    return float(np.hypot(np.std(off), SCATTERS[-1]))


def _kept(one: Collision) -> float:
    """Share of the relative velocity that a collision keeps; NaN where it is not shown."""
    before, after = one.velocity_before, one.velocity_after
    closing, leaving = before.ball_px_frame, -after.ball_px_frame
    if one.kind == "bodies":
        closing, leaving = closing - before.heavy_px_frame, leaving + after.heavy_px_frame
    return leaving / closing if closing else np.nan


def _path(
    track: Track, base: TimeBase, burst: Sequence[Collision], ramp: Ramp
) -> tuple[float, float]:
    """By how much the heavy body strays from its path by a time base, and the weight of that.

    ``burst`` are collisions among the frames. The path reaches to the changes of a rate. The weight
    is the number of independent places.
    """
    reach = np.interp(ramp.changes, base.frame, base.time).tolist()
    swing = fit_swing(gaps_of(base.evened(track)), [base.timed(one) for one in burst], reach)
    return (
        (UNKNOWN_PX, 1.0) if swing is None else (swing.stray_px, swing.places / CORRELATED_FRAMES)
    )


def _fitted(ramp: Ramp, factor: float, track: Track, burst: Sequence[Collision]) -> Ramp:
    """Find the places and the factor of a changing rate by which the heavy body strays least.

    The speeds show the ``factor`` about.
    """
    fits = []
    for whole in range(max(2, ramp.factor - 1), ramp.factor + 2):
        other = _placed(replace(ramp, factor=whole), track, burst)
        stray_px, weight = _path(track, other.time_base(track.frame), burst, other)
        # Half the squares in standard deviations of the path, and of the factor at each change.
        off = np.log(whole / factor) / np.log1p(FACTOR_SHARE)
        fits.append((weight * np.log(stray_px) + len(ramp.changes) * off**2 / 2, other))
    return min(fits, key=itemgetter(0))[1]


def _placed(ramp: Ramp, track: Track, burst: Sequence[Collision]) -> Ramp:
    """Place the changes of a rate where the heavy body strays least from its path."""
    from scipy.optimize import minimize  # noqa: PLC0415

    def stray(changes: Floats) -> float:
        moved = replace(ramp, changes=tuple(changes.tolist()))
        return _path(track, moved.time_base(track.frame), burst, ramp)[0]

    start = np.array(ramp.changes, dtype=np.float64)
    corners = np.vstack([start, start + STEP_FRAMES * np.eye(len(start))])
    best = minimize(
        stray,
        start,
        method="Nelder-Mead",
        options={"initial_simplex": corners, "xatol": PLACE_FRAMES},
    )
    return replace(ramp, changes=tuple(best.x.tolist()))

r"""Clocks of slow-motion exports: pictures left out in parts of the clip, by one whole factor.

    time                                   .
                                         .'      many pictures are left out,
                                      _.'
                               __..--'           none is,
                        __..--'
                      .'
                    .'                           many are
                  .'
                 +----|-------------|----> frame

Where the rate changes, all speeds change at once by one factor. No collision does that: the energy
of both bodies together is the same after it, but for what each restitution takes. So changes of its
root are the places in question.

Which of them are changes of the rate is decided by the heavy body's whole path: it follows from its
swing and its collisions with the ball, and runs on before and after, so that a change that is put a
part of a picture off shows over all the rest of the clip.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from count_video.motion.gaps import Gaps, gaps_of
from count_video.motion.time_base import TimeBase, even
from count_video.reasons import Cause, Reason
from count_video.records import Collision, Floats, Track
from count_video.signals import sigma_of

SIDE_STEPS = 4
"""So many steps on either side give the energy: farther away the threads have changed it."""
FACTOR_AT_LEAST = 1.4
"""Exports play at half the rate or less; smaller changes are left to the bodies."""
CLEAR_SIGMAS = 6.0
"""A speed changes by so many standard uncertainties: of 10 000 none does so by noise."""
STANDS_OUT = 2.0
"""It changes by so much more than it goes on changing by itself: threads speed bodies up and slow
them down from step to step."""
FACTOR_SHARE = 0.3
"""Few pictures give a factor to about this share."""
FACTOR_AT_MOST = 16
CHANGES_AT_MOST = 3
"""So many changes of each sort are tried, the greatest first."""
MOVED_AT_MOST_FRAMES = 1.5
"""Changes are moved to where the path fits best, but no farther than that: the steps show on which
side of it a picture was taken."""
SHARP_FRAMES = 0.05
"""And to this part of a picture."""
NO_PATH_PX = 1e9
"""Stray of a clock that is out of the question."""


@dataclass(frozen=True)
class RateChange:
    """A place in a clip from which on a picture spans another time."""

    frame: float
    """Frame coordinate of the change."""
    factor: float
    """Time from one picture to the next after the change over that before."""

    @property
    def size(self) -> float:
        """Factor of the change, above 1 whichever way it goes."""
        return max(self.factor, 1 / self.factor)


def rate_changes(gaps: Gaps, collisions: Sequence[Collision]) -> list[RateChange]:
    """Find places at which the rate may change, in order of time.

    The mean velocity of the heavy body and the median speed of the ball over some steps, of which a
    collision spoils one, give the energy; ``collisions`` give the ratio of the masses.
    """
    frame, share = gaps.frame, _mass_share(collisions)
    ball, heavy = (_steps(frame, signal) for signal in (gaps.ball_px, gaps.heavy_px))
    if len(ball) <= 4 * SIDE_STEPS:
        return []
    sides = sliding_window_view(np.stack([heavy, np.abs(ball)]), SIDE_STEPS, axis=1)
    speed = np.hypot(sides[0].mean(axis=-1), np.sqrt(share) * np.median(sides[1], axis=-1))
    noise = np.hypot(sigma_of(gaps.heavy_px), np.sqrt(share) * sigma_of(gaps.ball_px))
    far = SIDE_STEPS + 1
    before, after = speed[:-far], speed[far:]
    jump = np.log(np.maximum(after, 1e-9) / np.maximum(before, 1e-9))
    bend = np.pad(np.abs(jump), far, mode="edge")
    by_itself = np.maximum(bend[: -2 * far], bend[2 * far :])
    clear = np.abs(jump) > np.maximum(np.log(FACTOR_AT_LEAST), STANDS_OUT * by_itself)
    clear &= np.abs(after - before) > CLEAR_SIGMAS * 2 * noise / SIDE_STEPS
    size = np.where(clear, np.abs(jump), 0.0)
    found = []
    for place in np.flatnonzero(size):
        if size[place] == size[max(0, place - SIDE_STEPS) : place + far].max():
            middle = frame[place + SIDE_STEPS : place + far + 1].mean()
            found.append(RateChange(float(middle), float(np.exp(jump[place]))))
    return found


def _steps(frame: Floats, signal: Floats) -> Floats:
    """Velocities from picture to picture, shape (n - 1,), across pictures that do not show it."""
    seen = np.isfinite(signal)
    return np.asarray(np.diff(np.interp(frame, frame[seen], signal[seen])) / np.diff(frame))


def _mass_share(collisions: Sequence[Collision]) -> float:
    """Light mass over heavy mass, from what the bodies give each other; 0 where none is shown."""
    shares = []
    for one in collisions:
        gained = one.velocity_after.ball_px_frame - one.velocity_before.ball_px_frame
        given = one.velocity_before.heavy_px_frame - one.velocity_after.heavy_px_frame
        if one.kind == "bodies" and np.isfinite([given, gained]).all() and gained:
            shares.append(given / gained)
    return float(np.clip(np.median(shares), 0.0, 1.0)) if shares else 0.0


@dataclass(frozen=True)
class Ramp:
    """Changes of a clip's rate."""

    changes: tuple[float, ...]
    """Frame coordinates at which the rate changes, increasing."""
    sparse_first: bool
    """Whether pictures are left out before the first of them; from then on by turns."""
    factor: int
    """Time from picture to picture where some are left out over that where none are."""

    def time_base(self, frame: Floats) -> TimeBase:
        """Time pictures in these frames, shape (n,), in the shortest of their steps."""
        ends = np.concatenate([frame[:1], self.changes, frame[-1:]])
        number = np.arange(len(ends) - 1)
        pace = np.where((number % 2 == 0) == self.sparse_first, self.factor, 1)
        times = np.concatenate([[0.0], np.cumsum(np.diff(ends) * pace)])
        note = Reason(Cause.RATE_CHANGES, (self.factor, *self.changes))
        time = np.interp(frame, ends, times)
        return replace(even(frame), time=time, keeps_rate=False, notes=(note,))

    def slows(self, frames: Sequence[float]) -> bool:
        """Whether a collision, of which the frames are given, lies where no pictures are left out.

        Where none does, no count hangs on the change, and it may be none: bodies that are let go
        speed up as well.
        """
        stretches = np.searchsorted(self.changes, frames)
        return bool(((stretches % 2 == 0) != self.sparse_first).any())


def ramps_of(track: Track, collisions: Sequence[Collision]) -> Iterator[list[Ramp]]:
    """Yield changes of the rate that the clip may have; none where nothing shows any.

    The rate rises where collisions are close and falls again later, by the same factor; or the clip
    shows one of both changes. Exports leave out pictures, so the factor is a whole number. Those
    at the same places, by the factors that come into question, come together, the likeliest first.
    """
    changes = sorted(rate_changes(gaps_of(track), collisions), key=lambda change: -change.size)
    rises = [change for change in changes if change.factor < 1][:CHANGES_AT_MOST]
    falls = [change for change in changes if change.factor > 1][:CHANGES_AT_MOST]
    both = [(r, f) for r in rises for f in falls if r.frame < f.frame]
    for some in (*both, *((change,) for change in (*rises, *falls))):
        at, sparse_first = tuple(one.frame for one in some), some[0].factor < 1
        factors = _factors(some)
        if factors:
            yield [Ramp(at, sparse_first, factor) for factor in factors]


def _factors(changes: Sequence[RateChange]) -> list[int]:
    """Whole factors that agree with all changes, the likeliest first."""
    sizes = [change.size for change in changes]
    low, high = max(sizes) / (1 + FACTOR_SHARE), min(sizes) * (1 + FACTOR_SHARE)
    wholes = range(max(2, int(np.ceil(low))), min(FACTOR_AT_MOST, int(high)) + 1)
    return sorted(wholes, key=lambda whole: abs(whole - float(np.sqrt(low * high))))


def stray_px(ramp: Ramp, track: Track, collisions: Sequence[Collision]) -> float:
    """By how much the heavy body strays from its path by a ramp; inf if the path is not known.

    ``collisions`` are those that the clip shows, in frames.
    """
    base = ramp.time_base(track.frame)
    return base.stray_px(track, tuple(map(base.timed, collisions)))


def sharpened(ramp: Ramp, track: Track, collisions: Sequence[Collision]) -> tuple[float, Ramp]:
    """Move the changes to where the heavy body strays least; returns the stray with the ramp."""
    from scipy.optimize import fmin  # noqa: PLC0415 - few clips have such a rate

    def at(changes: Floats) -> Ramp:
        return replace(ramp, changes=tuple(changes.tolist()))

    def stray(changes: Floats) -> float:
        far = np.abs(changes - ramp.changes).max() > MOVED_AT_MOST_FRAMES
        unordered = np.any(np.diff([track.frame[0], *changes, track.frame[-1]]) <= 0)
        if far or unordered:
            return NO_PATH_PX
        return min(stray_px(at(changes), track, collisions), NO_PATH_PX)

    first = np.array(ramp.changes)
    simplex = np.vstack([first, first + np.eye(len(first))])
    best = at(fmin(stray, first, xtol=SHARP_FRAMES, initial_simplex=simplex, disp=False))
    return stray_px(best, track, collisions), best

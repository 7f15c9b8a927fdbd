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

What the steps of both bodies tell of the changes is sharpened by the heavy body's whole path: it
follows from its swing and the ball's strokes, and runs on before and after, so that a change that
is put a part of a picture off shows over all the rest of the clip.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from count_video.motion.cadence import in_frames
from count_video.motion.gaps import gaps_of
from count_video.motion.rate_changes import RateChange, rate_changes
from count_video.motion.resolution import RESOLVED_FRAMES
from count_video.motion.swing import fit_path
from count_video.records import Collision, Floats, Track

FACTOR_SHARE = 0.3
FACTOR_SIGMAS = 3.0
"""Few pictures tell a factor to about this share and so many standard uncertainties."""
FACTOR_AT_MOST = 16
CHANGES_AT_MOST = 3
"""So many changes of each sort are tried, the greatest first."""
SHARPENING_FRAMES = (1.0, 0.5, 0.25, 0.1)
"""Steps by which changes are moved: the clearest are known to a tenth of a picture from the start,
others may have been put beside their picture."""
MOVED_AT_MOST_FRAMES = 1.5
"""But no farther than that: the steps tell on which side of it a picture was taken."""


@dataclass(frozen=True)
class Ramp:
    """The clock of a clip with changes of its rate."""

    frame: Floats
    """Frame coordinates of the pictures, shape (n,)."""
    changes: tuple[float, ...]
    """Frame coordinates at which the rate changes, increasing."""
    sparse_first: bool
    """Whether pictures are left out before the first of them; from then on by turns."""
    factor: int
    """Time from picture to picture where some are left out over that where none are."""

    @property
    def steady(self) -> Floats:
        """Times of the pictures in the shortest of their steps, shape (n,)."""
        return self.time_of(self.frame)

    def time_of(self, frame: Floats) -> Floats:
        """Steady times of frame coordinates, shape (n,)."""
        ends = np.concatenate([self.frame[:1], self.changes, self.frame[-1:]])
        number = np.arange(len(ends) - 1)
        pace = np.where((number % 2 == 0) == self.sparse_first, self.factor, 1)
        times = np.concatenate([[0.0], np.cumsum(np.diff(ends) * pace)])
        return np.asarray(np.interp(frame, ends, times))

    @property
    def warning(self) -> str:
        """What is unusual about the clip, for the user."""
        where = " and ".join(f"{change:.0f}" for change in self.changes)
        return f"the rate of the footage changes at frame {where}, by a factor of {self.factor}"

    def evened(self, track: Track) -> Track:
        """Time the pictures of a track by the steady clock."""
        return replace(track, frame=self.steady)

    def shown(self, collision: Collision) -> Collision:
        """Tell a collision that was found by the steady clock in frames."""
        frame = float(np.interp(collision.frame, self.steady, self.frame))
        return replace(in_frames(collision, 1 / self._pace(frame)), frame=frame)

    def timed(self, collision: Collision) -> Collision:
        """Tell a collision that is told in frames by the steady clock."""
        time = float(self.time_of(np.array([collision.frame]))[0])
        return replace(in_frames(collision, self._pace(collision.frame)), frame=time)

    def _pace(self, frame: float) -> float:
        """Steady time of the frame about a coordinate."""
        middle = float(np.clip(frame, self.frame[0] + 0.5, self.frame[-1] - 0.5))
        ends = np.array([middle - 0.5, middle + 0.5])
        return float(np.diff(self.time_of(ends))[0])

    def slows(self, collisions: Sequence[Collision]) -> bool:
        """Whether a collision, told in frames, lies where no pictures are left out.

        Where none does, no count hangs on the change, and it may be none: bodies that are let go
        speed up as well.
        """
        stretches = np.searchsorted(self.changes, [collision.frame for collision in collisions])
        return bool(((stretches % 2 == 0) != self.sparse_first).any())

    def resolves(self, collisions: Sequence[Collision]) -> bool:
        """Whether there are pictures enough between collisions also where they are rarer."""
        frames = [self.shown(collision).frame for collision in collisions]
        return all(b - a >= RESOLVED_FRAMES for a, b in pairwise(frames))


def ramps_of(track: Track) -> Iterator[list[Ramp]]:
    """Clocks that the clip may have been made by; none where nothing tells.

    The rate rises where collisions crowd and falls again later, by the same factor; or the clip
    shows one of both changes. Exports leave out pictures, so the factor is a whole number. Clocks
    of the same changes, by the factors that come into question, come together, the likeliest first.
    """
    if track.heavy is None:
        return
    changes = sorted(rate_changes(gaps_of(track)), key=lambda change: -change.size)
    rises = [change for change in changes if change.factor < 1][:CHANGES_AT_MOST]
    falls = [change for change in changes if change.factor > 1][:CHANGES_AT_MOST]
    both = [(r, f) for r in rises for f in falls if r.picture < f.picture]
    for some in (*both, *((change,) for change in (*rises, *falls))):
        ramps = [_ramp(track.frame, some, factor) for factor in _factors(some)]
        if ramps:
            yield ramps


def _factors(changes: Sequence[RateChange]) -> list[int]:
    """Whole factors that agree with all changes, the likeliest first."""
    allowed = [1 + FACTOR_SHARE + FACTOR_SIGMAS * change.noise for change in changes]
    low = max(change.size / most for change, most in zip(changes, allowed, strict=True))
    high = min(change.size * most for change, most in zip(changes, allowed, strict=True))
    middle = float(np.sqrt(low * high))
    wholes = range(max(2, int(np.ceil(low))), min(FACTOR_AT_MOST, int(high)) + 1)
    return sorted(wholes, key=lambda whole: abs(whole - middle))


def _ramp(frame: Floats, changes: Sequence[RateChange], factor: int) -> Ramp:
    places = [np.interp(c.picture + c.when, np.arange(len(frame)), frame) for c in changes]
    return Ramp(frame, tuple(map(float, places)), changes[0].factor < 1, factor)


def stray_px(ramp: Ramp, track: Track, collisions: Sequence[Collision]) -> float:
    """By how much the heavy body strays from its path by a clock; inf if the path is not known.

    ``collisions`` are those that the clip shows, in frames.
    """
    timed = [ramp.timed(collision) for collision in collisions]
    path = fit_path(gaps_of(ramp.evened(track)), timed)
    return float("inf") if path is None else path.stray_px


def sharpened(ramp: Ramp, track: Track, collisions: Sequence[Collision]) -> tuple[float, Ramp]:
    """Move the changes to where the heavy body strays least; returns the stray with the clock."""
    best = stray_px(ramp, track, collisions), ramp
    for step in SHARPENING_FRAMES:
        moves = [(n, sign * step) for n in range(len(ramp.changes)) for sign in (-1.0, 1.0)]
        better = True
        while better:
            tried = [_moved(best[1], *move) for move in moves]
            near = [one for one in tried if _in_order(one) and _is_near(one, ramp)]
            nearby = [(stray_px(one, track, collisions), one) for one in near]
            least = min(nearby, key=lambda one: one[0], default=best)
            better = least[0] < best[0]
            best = least if better else best
    return best


def _moved(ramp: Ramp, number: int, step: float) -> Ramp:
    places = [place + step * (n == number) for n, place in enumerate(ramp.changes)]
    return replace(ramp, changes=tuple(places))


def _is_near(ramp: Ramp, other: Ramp) -> bool:
    away = np.subtract(ramp.changes, other.changes)
    return bool(np.abs(away).max() <= MOVED_AT_MOST_FRAMES)


def _in_order(ramp: Ramp) -> bool:
    ends = (ramp.frame[0], *ramp.changes, ramp.frame[-1])
    return all(b > a for a, b in pairwise(ends))

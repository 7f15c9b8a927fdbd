r"""Notice where the rate of the footage changes inside a clip, as slow-motion exports have it.

    place                         .'
                                .'     both bodies go on as before, but a frame spans
                              .'       another time: all speeds change at once, by one
                      ..-'''''         factor, and none changes its sign
              ..-'''''
             -------------+---------> frame

No collision does that: what one body gains in it the other loses, and a wall leaves one of them
alone. So few pictures on either side, along which the heavy body moves evenly, tell the factor; the
ball, which may have struck something there, has to agree by its speed; and the step between both
sides tells when the rate changed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from count_video.collisions.pace import in_frames
from count_video.collisions.resolution import RESOLVED_FRAMES
from count_video.records import Collision, Floats, Track
from count_video.signals import sigma_of

SIDES = ((3, 3), (2, 3), (3, 2))
"""So many pictures are looked at before and after: a side may be cut short by a collision."""
APART_PICTURES = 3
"""Of changes nearer to each other than this the greatest is one: the others are parts of it."""
FACTOR_AT_LEAST = 1.4
"""Exports play at half the rate or less; smaller changes are left to the bodies."""
CLEAR_SIGMAS = 6.0
"""The speed of each body changes by so many standard uncertainties."""
BENT_SIGMAS = 5.0
BENT_SHARE = 0.06
"""The heavy body moves evenly to this many standard uncertainties and this share of its speed:
threads speed it up and slow it down a little."""
BALL_SHARE = 0.2
"""The ball's speed agrees to this share: it may have bounced, and lost some."""
FACTOR_SHARE = 0.25
"""Few pictures tell a factor to about this share."""
CHANGES_AT_MOST = 4
"""So many changes of each sort are tried, the greatest first."""


@dataclass(frozen=True)
class RateChange:
    """A place in a clip from which on a picture spans another time."""

    picture: int
    """Row of the last picture before the change."""
    factor: float
    """Time from one picture to the next after the change over that before."""
    step: float
    """Time from the last picture before to the first after, over that between those before."""

    @property
    def size(self) -> float:
        """Factor of the change, above 1 whichever way it goes."""
        return max(self.factor, 1 / self.factor)


@dataclass(frozen=True)
class Ramp:
    """The clock of a clip with changes of its rate."""

    frame: Floats
    """Frame coordinates of the pictures, shape (n,)."""
    steady: Floats
    """Their times in the shortest of their steps, shape (n,)."""
    warning: str
    """What is unusual about the clip, for the user."""

    def evened(self, track: Track) -> Track:
        """Time the pictures of a track by the steady clock."""
        return replace(track, frame=self.steady)

    def shown(self, collision: Collision) -> Collision:
        """Tell a collision that was found by the steady clock in frames."""
        frame = float(np.interp(collision.frame, self.steady, self.frame))
        pace = float(np.interp(frame + 0.5, self.frame, self.steady)) - float(
            np.interp(frame - 0.5, self.frame, self.steady)
        )
        return replace(in_frames(collision, 1 / pace), frame=frame)

    def resolves(self, collisions: Sequence[Collision]) -> bool:
        """Whether there are pictures enough between collisions also where they are rarer."""
        frames = [self.shown(collision).frame for collision in collisions]
        return all(b - a >= RESOLVED_FRAMES for a, b in pairwise(frames))


def ramps_of(track: Track) -> Iterator[Ramp]:
    """Clocks that the clip may have been made by, the likeliest first; none where nothing tells.

    The rate rises where collisions crowd and falls again later, by the same factor; or the clip
    shows one of both changes. Exports leave out pictures, so the factor is a whole number.
    """
    if track.heavy is None:
        return
    places = track.ball.position_px, track.heavy.position_px
    sigma_px = sigma_of(places[0]), sigma_of(places[1])
    changes = sorted(rate_changes(track.frame, *places, sigma_px), key=lambda c: -c.size)
    rises = [change for change in changes if change.factor < 1][:CHANGES_AT_MOST]
    falls = [change for change in changes if change.factor > 1][:CHANGES_AT_MOST]
    both = [[r, f] for r in rises for f in falls if r.picture < f.picture]
    for some in (*both, *([change] for change in (*rises, *falls))):
        low = max(change.size for change in some) * (1 - FACTOR_SHARE)
        high = min(change.size for change in some) * (1 + FACTOR_SHARE)
        wholes = range(max(2, int(np.ceil(low))), int(np.floor(high)) + 1)
        middle = float(np.sqrt(low * high))
        for factor in sorted(wholes, key=lambda whole: abs(whole - middle)):
            yield _ramp(track.frame, some, factor)


def _ramp(frame: Floats, changes: Sequence[RateChange], factor: int) -> Ramp:
    """Make the clock for changes by one factor."""
    step = np.diff(frame)
    first, last = changes[0], changes[-1]
    begin = first.picture if first.factor < 1 else 0
    end = last.picture if last.factor > 1 else len(step)
    pace = np.full(len(step), float(factor))
    pace[begin:end] = 1.0
    for change in changes:
        # The step is known in units of those before it, on either side of the change.
        before = factor if change.factor < 1 else 1.0
        pace[change.picture] = np.clip(before * change.step, 1.0, factor)
    steady = np.concatenate([[0.0], np.cumsum(step * pace)])
    where = " and ".join(f"{frame[change.picture]:.0f}" for change in changes)
    return Ramp(
        frame,
        steady,
        f"the rate of the footage changes at frame {where}, by a factor of {factor}",
    )


def rate_changes(
    frame: Floats, ball_px: Floats, heavy_px: Floats, sigma_px: tuple[float, float]
) -> list[RateChange]:
    """Find the changes of the rate, in order of time.

    Parameters
    ----------
    frame
        Frame coordinates of the pictures, shape (n,).
    ball_px, heavy_px
        Places of both bodies along the line of motion, shape (n,); NaN where not seen.
    sigma_px
        Standard uncertainty of one place of the ball, and of the heavy body.
    """
    found: list[RateChange] = []
    for picture in range(len(frame) - 1):
        change = _change_after(picture, frame, (ball_px, heavy_px), sigma_px)
        if change is None:
            continue
        if found and picture - found[-1].picture < APART_PICTURES:
            change = max(change, found.pop(), key=lambda one: one.size)
        found.append(change)
    return found


def _change_after(
    picture: int, frame: Floats, places: tuple[Floats, Floats], sigma_px: tuple[float, float]
) -> RateChange | None:
    """Judge the step after a picture by the sides that make most of it."""
    found = []
    for before, after in SIDES:
        rows = slice(picture + 1 - before, picture + 1 + after)
        clock = frame[rows] if rows.start >= 0 else frame[:0]
        if len(clock) < before + after or np.ptp(np.diff(clock)) > 0:
            continue
        change = _judged(places[0][rows], places[1][rows], before, sigma_px)
        if change is not None:
            found.append(RateChange(picture, *change))
    return max(found, key=lambda one: one.size, default=None)


def _judged(
    ball_px: Floats, heavy_px: Floats, before: int, sigma_px: tuple[float, float]
) -> tuple[float, float] | None:
    """Factor and step between the pictures ``before`` and those after; None if the rate stays."""
    if not (np.isfinite(ball_px).all() and np.isfinite(heavy_px).all()):
        return None
    moves, steps = np.diff(heavy_px), np.abs(np.diff(ball_px))
    slow, fast = float(moves[: before - 1].mean()), float(moves[before:].mean())
    # A step in which the ball struck something is shorter than the others.
    was, now = float(steps[: before - 1].max()), float(steps[before:].max())
    if slow * fast <= 0:
        return None
    factor, step = fast / slow, float(moves[before - 1]) / slow
    bend = max(float(np.ptp(moves[: before - 1])), float(np.ptp(moves[before:])))
    bend_allowed = BENT_SIGMAS * np.sqrt(6.0) * sigma_px[1]
    bend_allowed += BENT_SHARE * max(abs(slow), abs(fast))
    told = (
        max(factor, 1 / factor) > FACTOR_AT_LEAST
        and abs(fast - slow) > CLEAR_SIGMAS * 2.0 * sigma_px[1]
        and abs(now - was) > CLEAR_SIGMAS * 2.0 * sigma_px[0]
        and abs(now - factor * was) < BALL_SHARE * max(now, factor * was)
        and bend < bend_allowed
        and 0.8 * min(1.0, factor) < step < 1.2 * max(1.0, factor)
    )
    return (factor, step) if told else None

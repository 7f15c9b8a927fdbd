r"""Notice where the rate of the footage changes inside a clip, as slow-motion exports have it.

    place                         .'
                                .'     both bodies go on as before, but a frame spans
                              .'       another time: all speeds change at once, by one
                      ..-'''''         factor, and none changes its sign
              ..-'''''
             -------------+---------> frame

No collision does that: what one body gains in it the other loses, and a wall leaves one of them
alone. So a change is told by what collisions leave alone, by whichever shows it most clearly; the
others and the energy have to agree; and the step between both sides tells when the rate changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.motion.gaps import Gaps
from count_video.motion.witnesses import (
    Side,
    Witness,
    Witnesses,
    side_of_step,
    witnesses_of,
)

APART_PICTURES = 3
"""Of changes nearer to each other than this the greatest is one: the others are parts of it."""
FACTOR_AT_LEAST = 1.4
"""Exports play at half the rate or less; smaller changes are left to the bodies."""
CLEAR_SIGMAS = 6.0
"""A velocity changes by so many standard uncertainties: of 10 000 none does so by noise."""
AGREE_SIGMAS = 4.0
AGREE_SHARE = 0.25
"""Witnesses agree to their noise and to this share: a collision on either side, with a restitution
of 0.9, takes up to a fifth of the energy's root together."""
STROKES_GIVE = 4.0
"""A stroke gives the ball at most twice the heavy body's speed, and there may be two of them."""
STANDS_OUT = 2.0
"""A velocity changes by so much more than it would go on changing by itself: threads speed bodies
up and slow them down from step to step."""
STEP_SLACK = 0.2
"""The step between both sides is as long as those on either side, or between, to this share."""


@dataclass(frozen=True)
class RateChange:
    """A place in a clip from which on a picture spans another time."""

    picture: int
    """Row of the last picture before the change."""
    factor: float
    """Time from one picture to the next after the change over that before."""
    when: float
    """Part of the step, from 0 to 1, that is taken at the rate before the change."""
    noise: float
    """Standard uncertainty of the factor, as a share of it."""

    @property
    def size(self) -> float:
        """Factor of the change, above 1 whichever way it goes."""
        return max(self.factor, 1 / self.factor)


def rate_changes(gaps: Gaps) -> list[RateChange]:
    """Find the changes of the rate, in order of time."""
    witnesses = witnesses_of(gaps)
    found: list[RateChange] = []
    if witnesses is None:
        return found
    for step in range(len(gaps.frame) - 1):
        change = _change_in(witnesses, step)
        if change is None:
            continue
        if found and step - found[-1].picture < APART_PICTURES:
            change = max(change, found.pop(), key=lambda one: one.size)
        found.append(change)
    return found


def _change_in(witnesses: Witnesses, step: int) -> RateChange | None:
    """Judge one step by the witness that shows a change most clearly; None if the rate stays."""
    told = [(witness, _sides(witness, step)) for witness in witnesses.firm]
    change = _clearest(step, told)
    if change is None and _hardly_struck(witnesses, step):
        change = _clearest(step, [(witnesses.last, _sides(witnesses.last, step))])
    if change is None or not all(_agree(change.factor, *sides) for _, sides in told if sides):
        return None
    return change


def _hardly_struck(witnesses: Witnesses, step: int) -> bool:
    """Whether the ball's speed changes by more than the heavy body's strokes can give it."""
    heavy, ball = _sides(witnesses.firm[0], step), _sides(witnesses.last, step)
    if heavy is None or ball is None:
        return False
    given = STROKES_GIVE * max(abs(side.rate) for side in heavy)
    return abs(ball[1].rate - ball[0].rate) > given


def _sides(witness: Witness, step: int) -> tuple[Side, Side] | None:
    before = side_of_step(witness, step, before=True)
    after = side_of_step(witness, step, before=False)
    return None if before is None or after is None else (before, after)


def _clearest(
    step: int, told: Sequence[tuple[Witness, tuple[Side, Side] | None]]
) -> RateChange | None:
    clearest, change = CLEAR_SIGMAS, None
    for witness, sides in told:
        if sides is None:
            continue
        before, after = sides
        clarity = abs(after.rate - before.rate) / float(np.hypot(before.sigma, after.sigma))
        between = float(witness.rate[step])
        if clarity > clearest and _changes(before, after, between):
            when = (after.rate - between) / (after.rate - before.rate)
            noise = float(np.hypot(after.sigma / after.rate, before.sigma / before.rate))
            clearest = clarity
            change = RateChange(
                step, after.rate / before.rate, float(np.clip(when, 0.0, 1.0)), noise
            )
    return change


def _changes(before: Side, after: Side, between: float) -> bool:
    """Whether one velocity changes as at a change of the rate."""
    if not before.rate * after.rate > 0:
        return False
    factor, step = after.rate / before.rate, between / before.rate
    # From the middle of one side to the middle of the other.
    away = (before.reach + after.reach) / 2 + 1
    by_itself = max(before.bend, after.bend) * away
    return (
        max(factor, 1 / factor) > FACTOR_AT_LEAST
        and abs(after.rate - before.rate) > STANDS_OUT * by_itself
        and (1 - STEP_SLACK) * min(1.0, factor) < step < (1 + STEP_SLACK) * max(1.0, factor)
    )


def _agree(factor: float, before: Side, after: Side) -> bool:
    """Whether a velocity may have changed by this factor."""
    expected = factor * before.rate
    noise = float(np.hypot(after.sigma, factor * before.sigma))
    allowed = AGREE_SIGMAS * noise + AGREE_SHARE * max(abs(after.rate), abs(expected))
    return abs(after.rate - expected) < allowed

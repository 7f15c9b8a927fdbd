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

    velocity                 | wall          | bodies
      heavy body     --------+---------------+_________   changed by the ball alone
      centre of mass --------+_______________+---------   changed by the wall alone
      ball           --------+___            +---------   changed by both
      energy         --------+---------------+---------   but for what each restitution takes

Between the collisions that change it, each of these velocities is even, but for the threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.motion.finding import low_points_of
from count_video.motion.gaps import Gaps
from count_video.records import CollisionKind, Floats
from count_video.signals import sigma_of

APART_PICTURES = 3
"""Of changes nearer to each other than this the greatest is one: the others are parts of it."""
FACTOR_AT_LEAST = 1.4
"""Exports play at half the rate or less; smaller changes are left to the bodies."""
CLEAR_SIGMAS = 6.0
"""A velocity changes by so many standard uncertainties: of 10 000 none does so by noise."""
AGREE_SIGMAS = 4.0
AGREE_SHARE = 0.25
"""Velocities agree to their noise and to this share: a collision on either side, with a restitution
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
    velocities = conserved_by(gaps)
    found: list[RateChange] = []
    if velocities is None:
        return found
    for step in range(len(gaps.frame) - 1):
        change = _change_in(velocities, step)
        if change is None:
            continue
        if found and step - found[-1].picture < APART_PICTURES:
            change = max(change, found.pop(), key=lambda one: one.size)
        found.append(change)
    return found


def _change_in(velocities: Velocities, step: int) -> RateChange | None:
    """Judge one step by the velocity that shows a change most clearly; None if the rate stays."""
    told = [(velocity, _sides(velocity, step)) for velocity in velocities.firm]
    change = _clearest(step, told)
    if change is None and _hardly_struck(velocities, step):
        change = _clearest(step, [(velocities.last, _sides(velocities.last, step))])
    if change is None or not all(_agree(change.factor, *sides) for _, sides in told if sides):
        return None
    return change


def _hardly_struck(velocities: Velocities, step: int) -> bool:
    """Whether the ball's speed changes by more than the heavy body's strokes can give it."""
    heavy, ball = _sides(velocities.firm[0], step), _sides(velocities.last, step)
    if heavy is None or ball is None:
        return False
    given = STROKES_GIVE * max(abs(side.rate) for side in heavy)
    return abs(ball[1].rate - ball[0].rate) > given


def _sides(velocity: Velocity, step: int) -> tuple[Side, Side] | None:
    before = side_of_step(velocity, step, before=True)
    after = side_of_step(velocity, step, before=False)
    return None if before is None or after is None else (before, after)


def _clearest(
    step: int, told: Sequence[tuple[Velocity, tuple[Side, Side] | None]]
) -> RateChange | None:
    clearest, change = CLEAR_SIGMAS, None
    for velocity, sides in told:
        if sides is None:
            continue
        before, after = sides
        clarity = abs(after.rate - before.rate) / float(np.hypot(before.sigma, after.sigma))
        between = float(velocity.rate[step])
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


SIDE_STEPS = 3
"""So many steps on either side tell a velocity: farther away the threads have changed it."""
NEAR_STEPS = 6
"""They are looked for among so many: in a flight that is resolved not all are struck."""
BEND_SIGMAS = 3.0
"""A velocity surely changes from step to step if it does so by more than this."""


@dataclass(frozen=True)
class Velocity:
    """A velocity from picture to picture."""

    rate: Floats
    """In px per frame, shape (n - 1,); NaN in steps that hold a collision that changes it."""
    sigma_px: float
    """Standard uncertainty of one place."""
    lasting: bool = False
    """Whether it is the same before and after such a step."""


@dataclass(frozen=True)
class Side:
    """A velocity right before or right after a step."""

    rate: float
    sigma: float
    bend: float
    """By how much it surely changes from step to step."""
    reach: int
    """How many steps away it is known."""


@dataclass(frozen=True)
class Velocities:
    """All that tells the clock."""

    firm: tuple[Velocity, ...]
    """The heavy body, the centre of mass (its velocity times the whole mass over the heavy one),
    the ball, and the root of the energy, as the speed of a heavy body that had all of it."""
    last: Velocity
    """The ball's speed. Strokes change it, but little as long as the heavy body hardly moves; the
    others tell little then."""


def conserved_by(gaps: Gaps) -> Velocities | None:
    """Velocities of both bodies; None where no collision tells how their masses compare."""
    span = np.diff(gaps.frame)
    ball, heavy = np.diff(gaps.ball_px) / span, np.diff(gaps.heavy_px) / span
    sigma_ball, sigma_heavy = sigma_of(gaps.ball_px), sigma_of(gaps.heavy_px)
    wall, bodies = _struck(gaps, "wall"), _struck(gaps, "bodies")
    flying = Velocity(_except(wall | bodies, ball), sigma_ball)
    pushed = Velocity(_except(bodies, heavy), sigma_heavy)
    share = _mass_share(flying, pushed, bodies)
    if share is None:
        return None
    common = Velocity(
        _except(wall, heavy + share * ball), float(np.hypot(sigma_heavy, share * sigma_ball))
    )
    speed = Velocity(
        _except(wall | bodies, np.sqrt(heavy**2 + share * ball**2)),
        # At most so much, whichever body has the energy.
        float(np.hypot(sigma_heavy, np.sqrt(share) * sigma_ball)),
        lasting=True,
    )
    bounced = Velocity(np.abs(flying.rate), sigma_ball, lasting=True)
    return Velocities((pushed, common, flying, speed), bounced)


def side_of_step(velocity: Velocity, step: int, *, before: bool) -> Side | None:
    """Tell a velocity from the steps next to one; None where none of them shows it."""
    places = _places(velocity, step, -1 if before else 1)
    count = len(places)
    if count == 0:
        return None
    rates = velocity.rate[places]
    bend = 0.0
    if count > 1:
        # Neighbouring steps share a place, with opposite signs.
        apart = abs(places[-1] - places[0])
        noise = velocity.sigma_px * np.sqrt(6.0 if apart == 1 else 4.0)
        bend = max(0.0, abs(rates[-1] - rates[0]) - BEND_SIGMAS * noise) / apart
    # Side by side steps are one long one; others are independent.
    share = count if velocity.lasting else count**2
    sigma = velocity.sigma_px * np.sqrt(2.0 / share)
    reach = abs(places[-1] - step)
    return Side(float(rates.mean()), float(sigma), float(bend), reach)


def _places(velocity: Velocity, step: int, direction: int) -> list[int]:
    """List the steps next to one that show a velocity as it is there."""
    found: list[int] = []
    for place in range(step + direction, step + direction * (NEAR_STEPS + 1), direction):
        if 0 <= place < len(velocity.rate) and np.isfinite(velocity.rate[place]):
            found.append(place)
        elif not velocity.lasting:
            break
    return found[:SIDE_STEPS]


def _except(struck: NDArray[np.bool_], rate: Floats) -> Floats:
    return np.where(struck, np.nan, rate)


def _struck(gaps: Gaps, kind: CollisionKind) -> NDArray[np.bool_]:
    """Which steps hold a collision of a kind, shape (n - 1,).

    It lies on one side of the lowest picture, in the step that is the shorter one: the gap closes
    and opens again in it.
    """
    moved = np.abs(np.diff(gaps.closing(kind)))
    struck = np.zeros(len(moved), dtype=bool)
    for candidate in low_points_of(gaps):
        lowest = int(np.searchsorted(gaps.frame, candidate.lowest))
        steps = [s for s in (lowest - 1, lowest) if 0 <= s < len(moved) and moved[s] >= 0]
        if candidate.kind == kind and steps:
            struck[min(steps, key=moved.__getitem__)] = True
    return struck


def _mass_share(ball: Velocity, heavy: Velocity, bodies: NDArray[np.bool_]) -> float | None:
    """Light mass over heavy mass, from what they give each other; None if no collision tells.

    By the median over the collisions, weighted by the ball's changes: next to a change of the rate
    single ones are off.
    """
    shares, weights = [], []
    for step in np.flatnonzero(bodies).tolist():
        gained, given = (_change_across(velocity, step) for velocity in (ball, heavy))
        if gained and given is not None:
            shares.append(-given / gained)
            weights.append(abs(gained))
    if not shares:
        return None
    order = np.argsort(shares)
    total = np.cumsum(np.array(weights)[order])
    middle = np.searchsorted(total, total[-1] / 2)
    return max(0.0, float(np.array(shares)[order][middle]))


def _change_across(velocity: Velocity, step: int) -> float | None:
    before = side_of_step(velocity, step, before=True)
    after = side_of_step(velocity, step, before=False)
    return None if before is None or after is None else after.rate - before.rate

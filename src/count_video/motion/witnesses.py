r"""What collisions leave alone: witnesses of the clock that pictures were taken by.

    velocity                 | wall          | bodies
      heavy body     --------+---------------+_________   changed by the ball alone
      centre of mass --------+_______________+---------   changed by the wall alone
      ball           --------+___            +---------   changed by both
      energy         --------+---------------+---------   but for what each restitution takes

Between the collisions that change it, the velocity of each is even, but for the threads. So from
picture to picture they can only all change at once, and by one factor, if the pictures change the
time between them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.motion.finding import low_points_of
from count_video.motion.gaps import Gaps
from count_video.records import CollisionKind, Floats
from count_video.signals import sigma_of

SIDE_STEPS = 3
"""So many steps on either side tell a velocity: farther away the threads have changed it."""
NEAR_STEPS = 6
"""They are looked for among so many: in a flight that is resolved not all are struck."""
BEND_SIGMAS = 3.0
"""A velocity surely changes from step to step if it does so by more than this."""


@dataclass(frozen=True)
class Witness:
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
class Witnesses:
    """All that tells the clock."""

    firm: tuple[Witness, ...]
    """The heavy body, the centre of mass (its velocity times the whole mass over the heavy one),
    the ball, and the root of the energy, as the speed of a heavy body that had all of it."""
    last: Witness
    """The ball's speed. Strokes change it, but little as long as the heavy body hardly moves; the
    others tell little then."""


def witnesses_of(gaps: Gaps) -> Witnesses | None:
    """Let both bodies bear witness; None where no collision tells how their masses compare."""
    span = np.diff(gaps.frame)
    ball, heavy = np.diff(gaps.ball_px) / span, np.diff(gaps.heavy_px) / span
    sigma_ball, sigma_heavy = sigma_of(gaps.ball_px), sigma_of(gaps.heavy_px)
    wall, bodies = _struck(gaps, "wall"), _struck(gaps, "bodies")
    flying = Witness(_except(wall | bodies, ball), sigma_ball)
    pushed = Witness(_except(bodies, heavy), sigma_heavy)
    share = _mass_share(flying, pushed, bodies)
    if share is None:
        return None
    common = Witness(
        _except(wall, heavy + share * ball), float(np.hypot(sigma_heavy, share * sigma_ball))
    )
    speed = Witness(
        _except(wall | bodies, np.sqrt(heavy**2 + share * ball**2)),
        # At most so much, whichever body has the energy.
        float(np.hypot(sigma_heavy, np.sqrt(share) * sigma_ball)),
        lasting=True,
    )
    bounced = Witness(np.abs(flying.rate), sigma_ball, lasting=True)
    return Witnesses((pushed, common, flying, speed), bounced)


def side_of_step(witness: Witness, step: int, *, before: bool) -> Side | None:
    """Tell a velocity from the steps next to one; None where none of them shows it."""
    places = _places(witness, step, -1 if before else 1)
    count = len(places)
    if count == 0:
        return None
    rates = witness.rate[places]
    bend = 0.0
    if count > 1:
        # Neighbouring steps share a place, with opposite signs.
        apart = abs(places[-1] - places[0])
        noise = witness.sigma_px * np.sqrt(6.0 if apart == 1 else 4.0)
        bend = max(0.0, abs(rates[-1] - rates[0]) - BEND_SIGMAS * noise) / apart
    # Side by side steps are one long one; others are independent.
    share = count if witness.lasting else count**2
    sigma = witness.sigma_px * np.sqrt(2.0 / share)
    reach = abs(places[-1] - step)
    return Side(float(rates.mean()), float(sigma), float(bend), reach)


def _places(witness: Witness, step: int, direction: int) -> list[int]:
    """List the steps next to one that show a velocity as it is there."""
    found: list[int] = []
    for place in range(step + direction, step + direction * (NEAR_STEPS + 1), direction):
        if 0 <= place < len(witness.rate) and np.isfinite(witness.rate[place]):
            found.append(place)
        elif not witness.lasting:
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


def _mass_share(ball: Witness, heavy: Witness, bodies: NDArray[np.bool_]) -> float | None:
    """Light mass over heavy mass, from what they give each other; None if no collision tells.

    By the median over the collisions, weighted by the ball's changes: next to a change of the rate
    single ones are off.
    """
    shares, weights = [], []
    for step in np.flatnonzero(bodies).tolist():
        gained, given = (_change_across(witness, step) for witness in (ball, heavy))
        if gained and given is not None:
            shares.append(-given / gained)
            weights.append(abs(gained))
    if not shares:
        return None
    order = np.argsort(shares)
    total = np.cumsum(np.array(weights)[order])
    middle = np.searchsorted(total, total[-1] / 2)
    return max(0.0, float(np.array(shares)[order][middle]))


def _change_across(witness: Witness, step: int) -> float | None:
    before = side_of_step(witness, step, before=True)
    after = side_of_step(witness, step, before=False)
    return None if before is None or after is None else after.rate - before.rate

"""Fit a burst from its beginning on: the first few collisions, then more and more of them.

Where the first collisions are seen, they tell wall, contact and losses well enough to foresee the
next few, and these tell them better. So no fit ever starts more than a small part of a collision
from where it ends, and nothing has to be searched for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from count_video.between.observations import Observations, until
from count_video.between.parameters import (
    FIRST_DEVIATION,
    Column,
    Prior,
    deviations_of,
    within_limits,
)
from count_video.between.rivals import with_deviations
from count_video.between.solving import Solution, noise_of, solve
from count_video.motion.seen import SeenCollisions
from count_video.motion.swing import Swing
from count_video.records import Collision, Floats

FIRST_COLLISIONS = 4
GROWTH = 4
"""Each fit spans so many times the collisions of the one before."""
FLOOR_PX = 0.3
"""Until all are in, anything nearer than this is as good."""
CLEAR_FRAMES = 0.6
"""Frames nearer to the next collision may hold it in their exposure."""
CALM_FRAMES = 3.0
"""Collisions further apart than this are all seen."""
SCATTER = 0.006
"""Of the restitution from collision to collision, to begin with."""
SWING_SIGMAS = 4.0
"""The heavy body's swing must be measured this clearly to begin with it."""


def forward_fit(
    observed: Observations, rough: Floats, prior: Prior, found: SeenCollisions, seen: int
) -> Solution:
    """Fit the first so many collisions of a burst, every one of which is seen."""
    burst = found.collisions[: found.burst]
    values = rough
    if seen == len(burst) and found.swing is not None:
        values = _with_swing(rough, found.swing)
    for count in stages(seen):
        part = observed
        if count < len(burst):
            part = until(observed, burst[count].frame - observed.origin - CLEAR_FRAMES)
        missing = FIRST_DEVIATION + deviations_of(count) - len(values)
        values = np.concatenate([values, np.zeros(max(missing, 0))])
        solution = solve(
            part,
            noise_of(part, values, count, FLOOR_PX),
            with_deviations(prior, count, SCATTER),
            values,
            count,
        )
        values = solution.values
    return solution


def calm_beginning(burst: Sequence[Collision]) -> int:
    """Count the collisions up to the first two between which some may be missing."""
    flights = np.diff([collision.frame for collision in burst])
    crowded = np.flatnonzero(flights < CALM_FRAMES)
    return int(crowded[0]) + 1 if len(crowded) else len(burst)


def _with_swing(rough: Floats, swing: Swing) -> Floats:
    """Take from the heavy body's path what it tells better than the rough values do."""
    values = rough.copy()
    if swing.mass_ratio_relative_sigma < 1 / SWING_SIGMAS:
        values[Column.LIGHTNESS] = -np.log(swing.mass_ratio)
    if swing.rate_squared > SWING_SIGMAS * swing.rate_squared_sigma:
        values[Column.SWING] = np.log(swing.rate_squared) / 2
    return np.asarray(within_limits(values[None])[0])


def stages(count: int) -> list[int]:
    """Numbers of collisions that are fitted one after the other; the last is all of them."""
    rising = [min(FIRST_COLLISIONS, count)]
    while rising[-1] < count:
        rising.append(min(rising[-1] * GROWTH, count))
    return rising

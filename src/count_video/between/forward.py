"""Fit a burst from its beginning on: the first few collisions, then more and more of them.

Where the first collisions are seen, they tell wall, contact and losses well enough to foresee the
next few, and these tell them better. So no fit ever starts more than a small part of a collision
from where it ends, and nothing has to be searched for.
"""

from __future__ import annotations

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
from count_video.between.solving import Solution, modelled, noise_of, solve
from count_video.collisions.seen import SeenCollisions
from count_video.collisions.swing import Swing
from count_video.records import Floats

FIRST_COLLISIONS = 4
GROWTH = 4
"""Each fit spans so many times the collisions of the one before."""
FLOOR_PX = 0.3
"""Until all are in, anything nearer than this is as good."""
CLEAR_FRAMES = 0.6
"""Frames nearer to the next collision may hold it in their exposure."""
SCATTER = 0.006
"""Of the restitution from collision to collision, to begin with."""
SWING_SIGMAS = 4.0
"""The heavy body's swing must be measured this clearly to begin with it."""


def forward_fit(
    observed: Observations, rough: Floats, prior: Prior, found: SeenCollisions
) -> Solution:
    """Fit a burst of which every collision is seen, from rough values."""
    values = rough if found.swing is None else _with_swing(rough, found.swing)
    burst = found.collisions[: found.burst]
    for count in stages(len(burst)):
        part = observed
        if count < len(burst):
            part = until(observed, burst[count].frame - observed.origin - CLEAR_FRAMES)
        missing = FIRST_DEVIATION + deviations_of(count) - len(values)
        values = np.concatenate([values, np.zeros(max(missing, 0))])
        _, sampled = modelled(part, values[None], count)
        solution = solve(
            part,
            noise_of(part, sampled, FLOOR_PX),
            with_deviations(prior, count, SCATTER),
            values,
            count,
        )
        values = solution.values
    return solution


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

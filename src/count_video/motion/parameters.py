"""What the fitted model consists of: its parameters, in px and frames, and what is known before.

Distances grow away from the wall. The heavy body's place is that of the ball's centre when the two
touch, so that a contact of the bodies is where ball and heavy body are at the same place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from functools import cache

import numpy as np

from count_video.motion.priors import (
    BALL_RATE_SIGMA,
    DAMPING,
    EXPOSURE,
    GIVEN_RATIO_SHARE,
    LIGHTNESS,
    PARALLAX_SIGMA,
    PULL_SHARE,
    RATE_SIGMA,
    RATE_SIGMA_UNKNOWN,
    RESTITUTION,
    SHOWN_RATIO_SHARE,
    USUAL_CAPTURE_FPS,
    USUAL_RATE_PER_S,
)
from count_video.records import Estimate, Floats

CONTRADICTING_SIGMAS = 4.0
"""Given masses contradict the motion beyond so many standard uncertainties."""


class Column(IntEnum):
    """Columns of an array of parameter sets, shape (sets, FIRST_DEVIATION + deviations).

    Beyond these are the deviations of the restitution at each collision.
    """

    HEAVY = 0
    """Place of the heavy body at time 0, px."""
    HEAVY_RATE = 1
    """Its velocity at time 0, px per frame; negative, toward the wall."""
    HEAVY_PULL = 2
    """Its acceleration at time 0, px per frame squared."""
    SWING = 3
    """Logarithm of the angular rate of its pendulum, radians per frame."""
    BALL_SWING = 4
    """Logarithm of the ball's angular rate over the heavy body's."""
    BALL_REST = 5
    """Place where the ball hangs at rest, px."""
    WALL = 6
    """Place of the ball at the wall, px."""
    CONTACT = 7
    """What the outlines leave between ball and heavy body in contact at the ball's rest, px."""
    EXPOSURE = 8
    """Time of exposure, frames."""
    LIGHTNESS = 9
    """Logarithm of the ball's mass over the heavy body's."""
    BODIES = 10
    """Restitution of the contact of the bodies."""
    BOUNCE = 11
    """Restitution of the contact with the wall."""
    PARALLAX = 12
    """Growth of what the outlines leave with the distance from the ball's rest: a camera close by
    sees the face's rim and the ball under changing angles."""
    SKIP = 13
    """Time that passes at the place where frames may be left out, beyond that between frames."""
    DAMPING = 14
    """Logarithm of the ball's damping ratio in air: its swing's decay, per frame, over its rate."""
    SPEED = 15
    """How much less the restitution is at the speed of the first collision than at none; half of it
    is the mean that the contacts have."""


FIRST_DEVIATION = len(Column)
MOST_DEVIATIONS = 60
"""Of more collisions, neighbours of a kind share a deviation: what matters is how much energy is
lost by when, and neighbours lose it at nearly the same time."""


@cache
def deviation_places(count: int) -> np.ndarray:
    """Which deviation each of so many collisions has, shape (count,), counted from 0."""
    event = np.arange(count)
    pairs = max(1, -(-count // 2))
    groups = min(pairs, MOST_DEVIATIONS // 2)
    places = np.asarray(2 * (event // 2 * groups // pairs) + event % 2)
    places.flags.writeable = False
    return places


@dataclass(frozen=True)
class Prior:
    """Independent normal distributions of all columns; infinite where nothing is known."""

    mean: Floats
    """Shape (columns,)."""
    sigma: Floats
    """Shape (columns,)."""

    def with_value(self, column: Column, mean: float, sigma: float) -> Prior:
        """Return the prior with one column replaced."""
        means, sigmas = self.mean.copy(), self.sigma.copy()
        means[column], sigmas[column] = mean, sigma
        return Prior(means, sigmas)


@dataclass(frozen=True)
class Knowledge:
    """What is known of a trial besides its track, and what may be inferred."""

    capture_fps: float | None = None
    """The camera's rate; None if unknown."""
    mass_ratio: float | None = None
    """Heavy over light; None to let the fit measure it."""
    seen_only: bool = False
    """Whether to count what the frames show, and infer nothing between them."""

    def contradicts(self, shown: Estimate) -> bool:
        """Whether a mass ratio that the motion shows contradicts the one that is given."""
        if self.mass_ratio is None:
            return False
        sigma = math.hypot(SHOWN_RATIO_SHARE * shown.value, shown.sigma)
        return abs(self.mass_ratio - shown.value) > CONTRADICTING_SIGMAS * sigma

    @property
    def rate(self) -> tuple[float, float]:
        """Angular rate of usual threads in radians per frame, and the sigma of its logarithm."""
        if self.capture_fps is None:
            return USUAL_RATE_PER_S / USUAL_CAPTURE_FPS, RATE_SIGMA_UNKNOWN
        return USUAL_RATE_PER_S / self.capture_fps, RATE_SIGMA


def prior_of(rough: Floats, known: Knowledge, *, shows_heavy: bool) -> Prior:
    """State what is known before a coarse fit about the parameters without deviations.

    How strongly the air damps the ball, and how the restitution depends on the speed, is left to a
    fine one. Of a heavy body that is not seen there are no outlines.
    """
    way, (rate, sigma) = rough[Column.BALL_REST] - rough[Column.WALL], known.rate
    normal = {
        Column.HEAVY_PULL: (0.0, PULL_SHARE * np.exp(2 * rough[Column.SWING]) * way),
        Column.SWING: (np.log(rate), sigma),
        Column.BALL_SWING: (0.0, BALL_RATE_SIGMA),
        Column.DAMPING: (DAMPING[0], 0.0),
        Column.EXPOSURE: EXPOSURE,
        Column.PARALLAX: (0.0, PARALLAX_SIGMA),
        Column.SKIP: (0.0, 0.0),
        Column.SPEED: (0.0, 0.0),
        Column.BODIES: RESTITUTION,
        Column.BOUNCE: RESTITUTION,
    }
    if not shows_heavy:
        normal[Column.CONTACT] = 0.0, 0.0
        normal[Column.LIGHTNESS] = LIGHTNESS
    if known.mass_ratio is not None:
        normal[Column.LIGHTNESS] = -np.log(known.mass_ratio), GIVEN_RATIO_SHARE
    mean, sigmas = rough.copy(), np.full(FIRST_DEVIATION, np.inf)
    mean[list(normal)], sigmas[list(normal)] = np.transpose(list(normal.values()))
    return Prior(mean, sigmas)


def with_deviations(prior: Prior, count: int, scatter: float) -> Prior:
    """Let the restitution of each collision deviate by a scatter."""
    sharing = np.bincount(deviation_places(count))
    return Prior(
        np.concatenate([prior.mean[:FIRST_DEVIATION], np.zeros(len(sharing))]),
        np.concatenate([prior.sigma[:FIRST_DEVIATION], scatter / np.sqrt(sharing)]),
    )


LIMITS = {
    Column.SWING: (np.log(1e-5), np.log(0.5)),
    Column.BALL_SWING: (np.log(0.2), np.log(5.0)),
    Column.EXPOSURE: (0.01, 1.0),
    Column.LIGHTNESS: (np.log(1e-6), np.log(2.0)),
    Column.BODIES: (0.3, 1.005),
    Column.BOUNCE: (0.3, 1.005),
    Column.SKIP: (-500.0, 500.0),
    Column.DAMPING: (np.log(1e-6), np.log(0.5)),
}
"""Where the model is defined. A restitution a little above 1 is allowed: a limit right where
perfect bodies lie would bias their fit."""


def limits_of(columns: int) -> tuple[Floats, Floats]:
    """Lowest and highest values for which the model is defined, shape (columns,) each."""
    low, high = np.full(columns, -np.inf), np.full(columns, np.inf)
    low[list(LIMITS)], high[list(LIMITS)] = np.transpose(list(LIMITS.values()))
    return low, high


def within_limits(sets: Floats) -> Floats:
    """Parameter sets, shape (..., columns), brought back to where the model is defined."""
    return np.asarray(np.clip(sets, *limits_of(sets.shape[-1])))

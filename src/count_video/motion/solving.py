"""The model's parameters from what was observed, for a given number of collisions.

Least squares with a Cauchy loss (see ``descent``) and exact derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from count_video.motion.descent import CONVERGED, descend, loss_of, weights_of
from count_video.motion.exposures import Sampled, blur_of, sample, sampled_tangents
from count_video.motion.observations import Observations
from count_video.motion.parameters import (
    FIRST_DEVIATION,
    FIRST_DRIFT,
    Column,
    Prior,
    limits_of,
)
from count_video.motion.pendulums import Paths, follow, tangents_of
from count_video.records import Floats

BLUR_SHARE = 0.06
"""Where a tracker sees a smeared ball is uncertain by this share of the standard deviation of its
places during the exposure: measured on rendered clips, of which the truth is known."""
LATE_COSTS = 10.0
"""Sigmas that each frame costs by which the last collision lies beyond the observations."""
LATE_AT_MOST = 1e4


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the residuals."""

    ball: Floats
    """Shape (frames,)."""
    heavy: float


@dataclass(frozen=True)
class Solution:
    """A fit for one number of collisions."""

    count: int
    values: Floats
    """Parameters, shape (columns,)."""
    loss: float
    """Half the sum of squares, robust, with the prior; inf where the model fails."""
    hessian: Floats
    """Of the loss, shape (columns, columns)."""
    ball_residuals: Floats
    """In px, shape (frames,), NaN where not seen."""
    heavy_residuals: Floats


def noise_of(observed: Observations, values: Floats, count: int, floor_px: float = 0.0) -> Noise:
    """Noise to be expected where the motion of one set, shape (columns,), is smeared."""
    paths = follow(values[None], count, float(observed.frame[0]) - 1.0)
    with np.errstate(invalid="ignore", over="ignore"):
        smeared = BLUR_SHARE * blur_of(paths, values, observed.times(values[None])[0])
    smeared = np.where(np.isfinite(smeared), smeared, 0.0)
    ball = np.hypot(np.hypot(observed.ball_sigma_px, floor_px), smeared)
    return Noise(ball, float(np.hypot(observed.heavy_sigma_px, floor_px)))


def modelled(observed: Observations, sets: Floats, count: int) -> tuple[Paths, Sampled]:
    """Follow and sample parameter sets, shape (sets, columns), where there are observations."""
    start = float(observed.frame[0]) - 1.0
    paths = follow(sets, count, start)
    with np.errstate(invalid="ignore", over="ignore"):
        return paths, sample(paths, sets, observed.times(sets))


@dataclass(frozen=True)
class Linearised:
    """A fit in first order; residuals, of ball and heavy body, have shape (2 frames,).

    They are in sigmas, and times the roots of their weights: large ones count less. Those of what
    was not seen are 0, and so are their derivatives.
    """

    data: Floats
    """Residuals."""
    jacobian: Floats
    """Shape (2 frames, columns)."""
    velocity: Floats
    """Of the places."""
    gradient: Floats
    """Of the loss, shape (columns,)."""
    hessian: Floats
    """Shape (columns, columns); zero for columns without freedom."""


@dataclass(frozen=True)
class Question:
    """What was observed and how sure it is, and what is known before."""

    observed: Observations
    noise: Noise
    prior: Prior
    """A column with sigma 0 stays at the start."""
    count: int

    @cached_property
    def precision(self) -> Floats:
        """One over the noise of ball and heavy body, shape (2 frames,); 0 where not seen."""
        heavy = np.full(len(self.noise.ball), self.noise.heavy)
        seen = np.isfinite(self.observed.places_px)
        return np.where(seen, 1 / np.concatenate([self.noise.ball, heavy]), 0.0)

    @cached_property
    def weight(self) -> Floats:
        """One over the prior's sigma, shape (columns,); 0 where nothing is known, or all."""
        known = np.isfinite(self.prior.sigma) & (self.prior.sigma > 0)
        return np.where(known, 1 / np.where(known, self.prior.sigma, 1.0), 0.0)


class Fit:
    """The model at one set of parameters, against what was observed."""

    def __init__(self, question: Question, values: Floats) -> None:
        self.question, self.values = question, values
        observed = question.observed
        self.paths, self.sampled = modelled(observed, values[None], question.count)
        drift_px = observed.drift @ values[FIRST_DRIFT:FIRST_DEVIATION]
        self.left_px = observed.places_px - np.concatenate(
            [self.sampled.ball[0], self.sampled.heavy[0] + drift_px]
        )
        """What is left of the places of ball and heavy body, shape (2 frames,)."""
        seen = question.precision > 0
        self.data = np.where(seen, -self.left_px * question.precision, 0.0)
        """The same in sigmas; not finite if the model fails."""
        self.away = (values - question.prior.mean) * question.weight
        """Departures from the prior in sigmas, shape (columns,)."""
        beyond = float(self.paths.time[0, -1] - observed.times(values[None])[0, -1])
        self.late = min(max(beyond, 0.0), LATE_AT_MOST) * LATE_COSTS
        """What a last collision beyond the observations costs: it would prove nothing."""
        with np.errstate(invalid="ignore", over="ignore"):
            loss = loss_of(self.data) + 0.5 * float(self.away @ self.away + self.late**2)
        self.loss = loss if np.isfinite(loss) else np.inf

    @property
    def gradient(self) -> Floats:
        """Of the loss, shape (columns,)."""
        return self.linearised.gradient

    @property
    def hessian(self) -> Floats:
        """Of the loss, shape (columns, columns)."""
        return self.linearised.hessian

    @cached_property
    def linearised(self) -> Linearised:
        """The model in first order about these parameters."""
        question, observed = self.question, self.question.observed
        tangents = tangents_of(self.paths, self.values)
        with np.errstate(invalid="ignore", over="ignore"):
            ball, heavy = sampled_tangents(self.sampled, tangents, self.values)
            heavy[:, FIRST_DRIFT:FIRST_DEVIATION] = observed.drift
            root = np.sqrt(weights_of(self.data))
            data = root * self.data
            jacobian = np.concatenate([ball, heavy])
            jacobian *= (root * question.precision)[:, None]
            failed = ~np.isfinite(data + jacobian.sum(axis=1))
        jacobian[failed], data[failed] = 0.0, 0.0
        velocity = jacobian[:, Column.SKIP].copy()
        jacobian[:, Column.SKIP] *= np.tile(observed.after, 2)
        gradient, hessian = jacobian.T @ data, jacobian.T @ jacobian
        gradient += question.weight * self.away
        hessian[np.diag_indices_from(hessian)] += question.weight**2
        if self.late > 0 and np.isfinite(tangents.time[-1]).all():
            last = LATE_COSTS * tangents.time[-1]
            gradient += self.late * last
            hessian += np.outer(last, last)
        fixed = question.prior.sigma == 0
        gradient[fixed], hessian[fixed], hessian[:, fixed] = 0.0, 0.0, 0.0
        return Linearised(data, jacobian, velocity, gradient, hessian)


def solve(
    question: Question, start: Floats, bearable: float = np.inf, enough: float = CONVERGED
) -> Solution:
    """Fit the parameters from a start, shape (columns,).

    A fit that at its pace will not come down to the bearable loss is given up; one whose loss falls
    by less than ``enough`` is done.
    """
    at, limits = partial(Fit, question), limits_of(len(start))
    fit = descend(at, start, limits, bearable, enough)
    ball, heavy = np.split(fit.left_px, 2)
    return Solution(question.count, fit.values, fit.loss, fit.hessian, ball, heavy)

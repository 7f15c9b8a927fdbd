"""The model's parameters from what was observed, for a given number of collisions.

Least squares with a Cauchy loss (see ``descent``) and exact derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from count_video.motion.descent import NEARLY, descend, loss_of, weights_of
from count_video.motion.exposures import Sampled, blur_of, sample, sampled_tangents
from count_video.motion.observations import Observations
from count_video.motion.parameters import (
    FIRST_DEVIATION,
    FIRST_DRIFT,
    Column,
    Prior,
    limits_of,
)
from count_video.motion.pendulums import Paths, follow, follow_one
from count_video.motion.tangents import tangents_of
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
    paths = follow_one(values, count, float(observed.frame[0]) - 1.0)
    with np.errstate(invalid="ignore", over="ignore"):
        smeared = BLUR_SHARE * blur_of(paths, values, observed.times(values[None])[0])
    smeared = np.where(np.isfinite(smeared), smeared, 0.0)
    ball = np.hypot(np.hypot(observed.ball_sigma_px, floor_px), smeared)
    return Noise(ball, float(np.hypot(observed.heavy_sigma_px, floor_px)))


def modelled(observed: Observations, sets: Floats, count: int) -> tuple[Paths, Sampled]:
    """Follow and sample parameter sets, shape (sets, columns), where there are observations."""
    start = float(observed.frame[0]) - 1.0
    paths = follow_one(sets[0], count, start) if len(sets) == 1 else follow(sets, count, start)
    with np.errstate(invalid="ignore", over="ignore"):
        return paths, sample(paths, sets, observed.times(sets))


@dataclass(frozen=True)
class Linearised:
    """A fit in first order: what was observed, in sigmas, by the parameters; shape (n,) each."""

    row: NDArray[np.intp]
    """Frames that the residuals are of."""
    data: Floats
    """Residuals."""
    jacobian: Floats
    """Shape (n, columns)."""
    velocity: Floats
    """Of the places."""
    weights: Floats
    """Large residuals count less."""
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


class Fit:
    """The model at one set of parameters, against what was observed."""

    def __init__(self, question: Question, values: Floats) -> None:
        self.question, self.values = question, values
        observed, noise = question.observed, question.noise
        self.paths, self.sampled = modelled(observed, values[None], question.count)
        ball = (self.sampled.ball[0] - observed.ball_px) / noise.ball
        heavy = (self.sampled.heavy[0] + self.drift_px - observed.heavy_px) / noise.heavy
        ball[np.isnan(observed.ball_px)] = 0.0
        heavy[np.isnan(observed.heavy_px)] = 0.0
        self.data = np.concatenate([ball, heavy])
        """Residuals of ball and heavy body in sigmas, shape (2 frames,); not finite if it fails."""
        prior = question.prior
        known = np.isfinite(prior.sigma) & (prior.sigma > 0)
        self.weight = np.where(known, 1 / np.where(known, prior.sigma, 1.0), 0.0)
        self.away = np.where(known, (values - prior.mean) * self.weight, 0.0)
        """Departures from the prior in sigmas, shape (columns,)."""
        beyond = float(self.paths.time[0, -1] - observed.times(values[None])[0, -1])
        self.late = min(max(beyond, 0.0), LATE_AT_MOST) * LATE_COSTS
        """What a last collision beyond the observations costs: it would prove nothing."""
        with np.errstate(invalid="ignore", over="ignore"):
            loss = loss_of(self.data) + 0.5 * float(self.away @ self.away + self.late**2)
        self.loss = loss if np.isfinite(loss) else np.inf

    @property
    def drift_px(self) -> Floats:
        """Drift of the heavy body's outline, shape (frames,)."""
        drift = self.question.observed.drift
        return np.asarray(drift @ self.values[FIRST_DRIFT:FIRST_DEVIATION])

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
        observed, noise, prior = self.question.observed, self.question.noise, self.question.prior
        tangents = tangents_of(self.paths, self.values)
        with np.errstate(invalid="ignore", over="ignore"):
            ball, heavy = sampled_tangents(self.paths, self.sampled, tangents, self.values)
            heavy[:, FIRST_DRIFT:FIRST_DEVIATION] = observed.drift
            jacobian = np.concatenate([ball / noise.ball[:, None], heavy / noise.heavy])
            velocity = jacobian[:, Column.SKIP].copy()
            jacobian[:, Column.SKIP] *= np.tile(observed.after, 2)
            weights = weights_of(self.data)
            usable = np.isfinite(self.data) & np.isfinite(jacobian).all(axis=1)
        usable &= np.isfinite(np.concatenate([observed.ball_px, observed.heavy_px]))
        jacobian, data, weights = jacobian[usable], self.data[usable], weights[usable]
        weighted = jacobian * weights[:, None]
        gradient, hessian = weighted.T @ data, weighted.T @ jacobian
        gradient += self.weight * self.away
        hessian[np.diag_indices_from(hessian)] += self.weight**2
        if self.late > 0 and np.isfinite(tangents.time[-1]).all():
            last = LATE_COSTS * tangents.time[-1]
            gradient += self.late * last
            hessian += np.outer(last, last)
        fixed = prior.sigma == 0
        gradient[fixed], hessian[fixed], hessian[:, fixed] = 0.0, 0.0, 0.0
        row = np.tile(np.arange(len(observed.frame)), 2)[usable]
        return Linearised(row, data, jacobian, velocity[usable], weights, gradient, hessian)


def solve(
    question: Question, start: Floats, bearable: float = np.inf, enough: float = NEARLY
) -> Solution:
    """Fit the parameters from a start, shape (columns,).

    A fit that at its pace will not come down to the bearable loss is given up; one whose loss falls
    by less than ``enough`` is done.
    """
    at, limits = partial(Fit, question), limits_of(len(start))
    fit = descend(at, start, limits, bearable, enough)
    observed = question.observed
    return Solution(
        count=question.count,
        values=fit.values,
        loss=fit.loss,
        hessian=fit.hessian,
        ball_residuals=observed.ball_px - fit.sampled.ball[0],
        heavy_residuals=observed.heavy_px - fit.sampled.heavy[0] - fit.drift_px,
    )

"""The model's parameters from what was observed, for a given number of collisions.

Least squares with a Cauchy loss (see ``descent``) and exact derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from count_video.motion.descent import CONVERGED, descend, loss_of, weights_of
from count_video.motion.exposures import blur_of, sample, sampled_tangents
from count_video.motion.observations import Observations
from count_video.motion.parameters import (
    FIRST_DEVIATION,
    FIRST_DRIFT,
    Column,
    Prior,
    deviations_of,
    limits_of,
    with_deviations,
)
from count_video.motion.pendulums import Tangents, follow, tangents_of
from count_video.motion.priors import SCATTERS
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


class Fit:
    """The model at one set of parameters, against what was observed."""

    def __init__(self, question: Question, values: Floats) -> None:
        self.question, self.values, self.count = question, values, question.count
        observed = self.observed = question.observed
        self.paths = follow(values[None], question.count, observed.start)
        frame = observed.times(values)
        with np.errstate(invalid="ignore", over="ignore"):
            self.sampled = sample(self.paths, values[None], frame)
        drift_px = observed.drift @ values[FIRST_DRIFT:FIRST_DEVIATION]
        self.left_px = observed.places_px - np.concatenate(
            [self.sampled.ball[0], self.sampled.heavy[0] + drift_px]
        )
        """What is left of the places of ball and heavy body, shape (2 frames,), NaN if not seen."""
        self.data = np.where(question.precision > 0, -self.left_px * question.precision, 0.0)
        """The same in sigmas; not finite if the model fails."""
        self.away = (values - question.prior.mean) * question.weight
        """Departures from the prior in sigmas, shape (columns,)."""
        beyond = float(self.paths.time[0, -1] - frame[-1])
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
        """Gauss-Newton's, shape (columns, columns)."""
        return self.linearised.hessian

    @cached_property
    def tangents(self) -> Tangents:
        """Derivatives of the motion."""
        return tangents_of(self.paths, self.values)

    @cached_property
    def linearised(self) -> Linearised:
        """The fit in first order."""
        question, observed = self.question, self.question.observed
        with np.errstate(invalid="ignore", over="ignore"):
            ball, heavy = sampled_tangents(self.sampled, self.tangents, self.values)
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
        if self.late > 0 and np.isfinite(last := LATE_COSTS * self.tangents.time[-1]).all():
            gradient += self.late * last
            hessian += np.outer(last, last)
        fixed = question.prior.sigma == 0
        gradient[fixed], hessian[fixed], hessian[:, fixed] = 0.0, 0.0, 0.0
        return Linearised(data, jacobian, velocity, gradient, hessian)

    @cached_property
    def covariance(self) -> Floats:
        """Of the parameters, shape (columns, columns)."""
        return np.asarray(np.linalg.pinv(self.hessian, hermitian=True), np.float64)

    @cached_property
    def evidence(self) -> float:
        """Logarithm of the evidence for the count, up to what all counts have in common.

        It is the likelihood integrated over all parameters by Laplace's approximation about the
        fit, so that a count that needs unlikely scatter of the restitution pays for it.
        """
        if not np.isfinite(self.loss):
            return -np.inf
        scale = np.sqrt(np.maximum(np.diag(self.hessian), 1e-300))
        scaled = self.hessian / scale[:, None] / scale
        _, log_determinant = np.linalg.slogdet(scaled + 1e-10 * np.eye(len(scaled)))
        volume = log_determinant + 2 * np.log(scale).sum()
        spread = np.log(self.question.prior.sigma[FIRST_DEVIATION:]).sum()
        return float(-self.loss - 0.5 * volume - spread)


def solve(
    question: Question, start: Floats, bearable: float = np.inf, enough: float = CONVERGED
) -> Fit:
    """Fit the parameters from a start, shape (columns,).

    A fit that at its pace will not come down to the bearable loss is given up; one whose loss falls
    by less than ``enough`` is done.
    """
    return descend(partial(Fit, question), start, limits_of(len(start)), bearable, enough)


def fine_fit(
    question: Question, start: Floats, scatter: float = SCATTERS[-1], bearable: float = np.inf
) -> Fit:
    """Fit with scatter of the restitution, from the values of a coarse fit or another fine one."""
    count = question.count
    columns = FIRST_DEVIATION + deviations_of(count)
    start = np.concatenate([start, np.zeros(columns)])[:columns]
    start[Column.SKIP] = round(start[Column.SKIP])
    full = with_deviations(question.prior, count, scatter).with_value(Column.SKIP, 0.0, 0.0)
    return solve(replace(question, prior=full), start, bearable)


def noise_of(observed: Observations, values: Floats, count: int, floor_px: float = 0.0) -> Noise:
    """Noise to be expected where the motion of one set, shape (columns,), is smeared."""
    paths = follow(values[None], count, observed.start)
    with np.errstate(invalid="ignore", over="ignore"):
        smeared = BLUR_SHARE * blur_of(paths, values, observed.times(values))
    smeared = np.where(np.isfinite(smeared), smeared, 0.0)
    ball = np.hypot(np.hypot(observed.ball_sigma_px, floor_px), smeared)
    return Noise(ball, float(np.hypot(observed.heavy_sigma_px, floor_px)))

"""The model's parameters from what was observed, for a given number of collisions.

Least squares with a Cauchy loss (see ``descent``) and exact derivatives; covariance and evidence by
Laplace's approximation.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from count_video.motion.descent import (
    CONVERGED,
    LEAST_DAMPING,
    descend,
    loss_of,
    weights_of,
)
from count_video.motion.exposures import sample, sampled_tangents
from count_video.motion.observations import Observations
from count_video.motion.parameters import (
    FIRST_DEVIATION,
    Column,
    Prior,
    limits_of,
    with_deviations,
)
from count_video.motion.pendulums import Tangents, follow, tangents_of
from count_video.motion.priors import SCATTERS
from count_video.records import Floats

LATE_COSTS = 10.0
"""Sigmas that each frame costs by which the last collision lies beyond the observations."""
LATE_AT_MOST = 1e4


@dataclass(frozen=True)
class Question:
    """What was observed and how sure it is, and what is known before."""

    observed: Observations
    noise_px: Floats
    """Standard deviations of the residuals of ball and heavy body, shape (2,)."""
    known: Prior
    """Of the parameters without deviations; a column with sigma 0 stays at the start."""
    count: int
    scatter: float = 0.0
    """Standard deviation of the restitution from collision to collision; 0 if it is the same."""
    time_sigma: float = np.inf
    """Of the times of calm collisions, frames; infinite where the places decide alone."""
    lasting: Floats = field(default_factory=lambda: np.ones(2))
    """Factors in the noise for errors that last, by which fewer places are independent, shape (2,).
    """

    @property
    def left_over(self) -> float:
        """Noise of the body that strays most, as a multiple of that of its places."""
        return float((self.noise_px / self.observed.noise_px()).max())

    @cached_property
    def prior(self) -> Prior:
        """Of all parameters."""
        return with_deviations(self.known, self.count, self.scatter) if self.scatter else self.known

    @cached_property
    def precision(self) -> Floats:
        """One over the noise of ball and heavy body, shape (2 frames,); 0 where not seen."""
        noise = np.repeat(self.noise_px, len(self.observed.frame))
        return np.where(np.isfinite(self.observed.places_px), 1 / noise, 0.0)

    @cached_property
    def weight(self) -> Floats:
        """One over the prior's sigma, shape (columns,); 0 where nothing is known, or all."""
        known = np.isfinite(self.prior.sigma) & (self.prior.sigma > 0)
        return np.where(known, 1 / np.where(known, self.prior.sigma, 1.0), 0.0)


class Linearised(NamedTuple):
    """Residuals of ball and heavy body in first order, shape (2 frames,).

    They are in sigmas, and times the roots of their weights: large ones count less. Those of what
    was not seen are 0, and so are their derivatives.
    """

    data: Floats
    """Residuals."""
    jacobian: Floats
    """Shape (2 frames, columns); 0 for columns without freedom."""
    velocity: Floats
    """Of the places."""


class Fit:
    """The model at one set of parameters, against what was observed."""

    def __init__(self, question: Question, values: Floats) -> None:
        self.question, self.values, self.count = question, values, question.count
        observed = self.observed = question.observed
        self.paths = follow(values[None], question.count, observed.start)
        frame = observed.times(values)
        with np.errstate(invalid="ignore", over="ignore"):
            self.sampled = sample(self.paths, values[None], frame)
        self.left_px = observed.places_px - np.concatenate(
            [self.sampled.ball[0], self.sampled.heavy[0]]
        )
        """What is left of the places of ball and heavy body, shape (2 frames,), NaN if not seen."""
        self.data = np.where(question.precision > 0, -self.left_px * question.precision, 0.0)
        """The same in sigmas; not finite if the model fails."""
        self.away = (values - question.prior.mean) * question.weight
        """Departures from the prior in sigmas, shape (columns,)."""
        self.off = self._off(self.paths.time[0, 1:], float(frame[-1]))
        """The same of times, shape (calm collisions + 1,)."""
        with np.errstate(invalid="ignore", over="ignore"):
            squares = self.away @ self.away + self.off @ self.off
            loss = loss_of(self.data) + 0.5 * float(squares)
        self.loss = loss if np.isfinite(loss) else np.inf

    def _off(self, time: Floats, end: float) -> Floats:
        """Compare the calm collisions' times, and what a last one beyond the observations costs.

        That one would prove nothing.
        """
        calm = self.observed.burst[: min(self.count, self.observed.calm)]
        off = np.minimum(time[: len(calm)] - calm, LATE_AT_MOST) / self.question.time_sigma
        late = min(max(float(time[-1]) - end, 0.0), LATE_AT_MOST) * LATE_COSTS
        return np.append(off, late)

    @property
    def reached(self) -> int:
        """How many of the collisions come about before the observations end."""
        end = self.observed.times(self.values)[-1]
        return int(np.count_nonzero(self.paths.time[0, 1:] <= end))

    @property
    def squares(self) -> float:
        """Half the sum of squares with their weights."""
        parts = (self.linearised.data, self.away, self.off)
        return 0.5 * float(sum(part @ part for part in parts))

    @cached_property
    def gradient(self) -> Floats:
        """Of the loss, shape (columns,); 0 for columns without freedom."""
        linear, away = self.linearised, self.question.weight * self.away
        return linear.jacobian.T @ linear.data + self.timing.T @ self.off + away

    @cached_property
    def hessian(self) -> Floats:
        """Gauss-Newton's, shape (columns, columns); 0 for columns without freedom."""
        jacobian = np.vstack([self.linearised.jacobian, self.timing])
        return jacobian.T @ jacobian + np.diag(self.question.weight**2)

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
            root = np.sqrt(weights_of(self.data))
            data = root * self.data
            jacobian = np.concatenate([ball, heavy])
            jacobian *= (root * question.precision)[:, None]
            failed = ~np.isfinite(data + jacobian.sum(axis=1))
        jacobian[failed], data[failed] = 0.0, 0.0
        velocity = jacobian[:, Column.SKIP].copy()
        jacobian[:, Column.SKIP] *= np.tile(observed.after, 2)
        return Linearised(data, jacobian * (question.prior.sigma > 0), velocity)

    @cached_property
    def timing(self) -> Floats:
        """Derivatives of the departures of times, shape (calm collisions + 1, columns).

        Like those of the places they are 0 for columns without freedom.
        """
        time = self.tangents.time * (self.question.prior.sigma > 0)
        rows = [time[: len(self.off) - 1] / self.question.time_sigma]
        rows.append(LATE_COSTS * time[-1:] * (self.off[-1] > 0))
        timing = np.concatenate(rows)
        return np.where(np.isfinite(timing).all(axis=1, keepdims=True), timing, 0.0)

    @cached_property
    def _gaussian(self) -> tuple[Floats, float]:
        """Covariance by errors that are white, shape (columns, columns), and log evidence."""
        sigma = self.question.prior.sigma
        free = np.flatnonzero(sigma > 0)
        # Scaled to a unit diagonal first: the columns' units differ by ten orders of magnitude.
        scale = 1 / np.sqrt(np.maximum(np.diag(self.hessian)[free], 1e-60))
        unit = self.hessian[np.ix_(free, free)] * scale[:, None] * scale
        unit += LEAST_DAMPING * np.eye(len(free))
        covariance = np.zeros_like(self.hessian)
        covariance[np.ix_(free, free)] = np.linalg.inv(unit) * scale[:, None] * scale
        volume = np.linalg.slogdet(unit)[1] - 2 * np.log(scale).sum()
        evidence = -self.loss - 0.5 * volume - np.log(sigma[FIRST_DEVIATION:]).sum()
        return covariance, float(evidence) if np.isfinite(self.loss) else -np.inf

    @property
    def white(self) -> Floats:
        """Covariance of the parameters by errors that are white, shape (columns, columns)."""
        return self._gaussian[0]

    @property
    def evidence(self) -> float:
        """Logarithm of the likelihood integrated over all parameters (Laplace)."""
        return self._gaussian[1]

    @cached_property
    def covariance(self) -> Floats:
        """The same where errors last, with correlations R: C + C J' (R - 1) J C.

        The fit weighs the places as if their errors were white.
        """
        jacobian = self.linearised.jacobian
        lasting = jacobian.T @ (self.correlated(jacobian) - jacobian)
        return np.asarray(self.white + self.white @ lasting @ self.white)

    def correlated(self, values: Floats) -> Floats:
        """Multiply by the correlations of the errors of both bodies, shape (2 frames, ...).

        Those that last are in the noise already, by a factor that is taken out here.
        """
        bodies = zip(
            np.split(values, 2), self.observed.correlations, self.question.lasting, strict=True
        )
        return np.concatenate([v if one is None else one @ v / f**2 for v, one, f in bodies])


def solve(
    question: Question, start: Floats, bearable: float = np.inf, enough: float = CONVERGED
) -> Fit:
    """Fit the parameters from a start of a coarser fit or a finer one, shape (columns,).

    A fit that at its pace will not come down to the bearable loss is given up; one whose loss falls
    by less than ``enough`` is done.
    """
    columns = len(question.prior.mean)
    start = np.concatenate([start, np.zeros(columns)])[:columns]
    if not question.known.sigma[Column.SKIP]:
        start[Column.SKIP] = round(start[Column.SKIP])
    return descend(partial(Fit, question), start, limits_of(columns), bearable, enough)


def with_each_scatter(question: Question, start: Floats, bearable: float = np.inf) -> list[Fit]:
    """Fit with each scatter of the restitution, the largest first; none if that is not bearable."""
    *smaller, largest = SCATTERS
    fit = solve(replace(question, scatter=largest), start, bearable)
    if not fit.loss < bearable:
        return []
    fits = [fit]
    for scatter in reversed(smaller):
        fits.append(solve(replace(question, scatter=scatter), fits[-1].values))
    return fits

"""Least squares: the model's parameters from what was observed, for a given number of collisions.

Levenberg (1944) and Marquardt (1963), with exact derivatives. Large residuals count like Cauchy
errors: a frame in which the tracker was misled, or which blends two paths, must not bend the fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.motion.exposures import Sampled, blur_of, sample, sampled_tangents
from count_video.motion.observations import Observations
from count_video.motion.parameters import (
    FIRST_DEVIATION,
    FIRST_DRIFT,
    Column,
    Prior,
    within_limits,
)
from count_video.motion.pendulums import Paths, follow, follow_one
from count_video.motion.priors import CAUCHY_SIGMAS
from count_video.motion.tangents import tangents_of
from count_video.records import Floats

BLUR_SHARE = 0.06
"""Where a tracker sees a smeared ball is uncertain by this share of the standard deviation of its
places during the exposure: measured on rendered clips, of which the truth is known."""
FIRST_DAMPING = 1e-3
"""Of the normal equations, scaled to a unit diagonal: nearly a Gauss-Newton step ..."""
MOST_DAMPING = 1e4
"""... up to a short one downhill."""
DAMPING_FACTOR = 8.0
LATE_COSTS = 10.0
"""Sigmas that each frame costs by which the last collision lies beyond the observations."""
LATE_AT_MOST = 1e4
CONVERGED = 0.01
"""Fall of the loss in an iteration that is not worth another one."""
ITERATIONS = 30


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


def scaled(noise: Noise, ball: float, heavy: float) -> Noise:
    """Noise with a factor for each body."""
    return Noise(noise.ball * ball, noise.heavy * heavy)


def modelled(observed: Observations, sets: Floats, count: int) -> tuple[Paths, Sampled]:
    """Follow and sample parameter sets, shape (sets, columns), where there are observations."""
    start = float(observed.frame[0]) - 1.0
    paths = follow_one(sets[0], count, start) if len(sets) == 1 else follow(sets, count, start)
    with np.errstate(invalid="ignore", over="ignore"):
        return paths, sample(paths, sets, observed.times(sets))


@dataclass(frozen=True)
class _Fit:
    """The model at one set of parameters, against what was observed."""

    values: Floats
    paths: Paths
    sampled: Sampled
    data: Floats
    """Residuals of ball and heavy body in sigmas, shape (2 frames,); not finite where it fails."""
    away: Floats
    """Departures from the prior in sigmas, shape (columns,)."""
    late: float
    """What a last collision beyond the observations costs: it would prove nothing."""
    loss: float


def solve(
    observed: Observations,
    noise: Noise,
    prior: Prior,
    start: Floats,
    count: int,
    bearable: float = np.inf,
) -> Solution:
    """Fit the parameters from a start, shape (columns,).

    A column of the prior with sigma 0 stays at the start. A fit that at its pace will not come
    down to the bearable loss is given up.
    """
    fit = _fit(observed, noise, prior, start, count)
    damping = FIRST_DAMPING
    gradient, hessian = _normal_equations(observed, noise, prior, fit)
    for left in range(ITERATIONS, 0, -1):
        before = fit.loss
        while True:
            trial = _stepped(fit.values, hessian, gradient, damping)
            tried = _fit(observed, noise, prior, trial, count)
            if tried.loss < before or damping > MOST_DAMPING:
                break
            damping *= DAMPING_FACTOR
        if not tried.loss < before:
            break
        fit, damping = tried, damping / DAMPING_FACTOR
        gradient, hessian = _normal_equations(observed, noise, prior, fit)
        fallen = before - fit.loss
        if fallen < CONVERGED or fit.loss - left * fallen > bearable:
            break
    return Solution(
        count=count,
        values=fit.values,
        loss=fit.loss,
        hessian=hessian,
        ball_residuals=observed.ball_px - fit.sampled.ball[0],
        heavy_residuals=observed.heavy_px - fit.sampled.heavy[0] - _drift(observed, fit.values),
    )


def _fit(observed: Observations, noise: Noise, prior: Prior, values: Floats, count: int) -> _Fit:
    """Follow the model and compare; a loss of inf where it fails."""
    paths, sampled = modelled(observed, values[None], count)
    ball = (sampled.ball[0] - observed.ball_px) / noise.ball
    heavy = (sampled.heavy[0] + _drift(observed, values) - observed.heavy_px) / noise.heavy
    ball[np.isnan(observed.ball_px)] = 0.0
    heavy[np.isnan(observed.heavy_px)] = 0.0
    away = np.where(_known(prior), (values - prior.mean) * _weight(prior), 0.0)
    beyond = float(paths.time[0, -1] - observed.times(values[None])[0, -1])
    late = min(max(beyond, 0.0), LATE_AT_MOST) * LATE_COSTS
    data = np.concatenate([ball, heavy])
    with np.errstate(invalid="ignore", over="ignore"):
        robust = CAUCHY_SIGMAS**2 / 2 * np.log1p((data / CAUCHY_SIGMAS) ** 2).sum()
        loss = float(robust + 0.5 * (away @ away + late**2))
    loss = loss if np.isfinite(loss) else np.inf
    return _Fit(values, paths, sampled, data, away, late, loss)


def _drift(observed: Observations, values: Floats) -> Floats:
    """Drift of the heavy body's outline, px, shape (frames,)."""
    return np.asarray(observed.drift @ values[FIRST_DRIFT:FIRST_DEVIATION])


def _known(prior: Prior) -> np.ndarray:
    return np.isfinite(prior.sigma) & (prior.sigma > 0)


def _weight(prior: Prior) -> Floats:
    return np.where(_known(prior), 1 / np.where(_known(prior), prior.sigma, 1.0), 0.0)


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
    """Shape (columns, columns)."""


def linearised(
    observed: Observations, noise: Noise, prior: Prior, solution: Solution
) -> Linearised:
    """Linearise the model about a solution."""
    fit = _fit(observed, noise, prior, solution.values, solution.count)
    return _linearised(observed, noise, prior, fit)


def loss_of(observed: Observations, noise: Noise, prior: Prior, solution: Solution) -> float:
    """Loss of a solution for other observations."""
    return _fit(observed, noise, prior, solution.values, solution.count).loss


def _linearised(observed: Observations, noise: Noise, prior: Prior, fit: _Fit) -> Linearised:
    """Gradient and Gauss-Newton Hessian of the loss; columns without freedom have zeros."""
    tangents = tangents_of(fit.paths, fit.values)
    with np.errstate(invalid="ignore", over="ignore"):
        time = observed.times(fit.values[None])[0]
        ball, heavy = sampled_tangents(fit.paths, fit.sampled, tangents, fit.values, time)
        heavy[:, FIRST_DRIFT:FIRST_DEVIATION] = observed.drift
        jacobian = np.concatenate([ball / noise.ball[:, None], heavy / noise.heavy])
        velocity = jacobian[:, Column.SKIP].copy()
        jacobian[:, Column.SKIP] *= np.tile(observed.after, 2)
        weights = 1 / (1 + (fit.data / CAUCHY_SIGMAS) ** 2)
        usable = np.isfinite(fit.data) & np.isfinite(jacobian).all(axis=1)
    usable &= np.isfinite(np.concatenate([observed.ball_px, observed.heavy_px]))
    jacobian, data, weights = jacobian[usable], fit.data[usable], weights[usable]
    weighted = jacobian * weights[:, None]
    gradient, hessian = weighted.T @ data, weighted.T @ jacobian
    weight = _weight(prior)
    gradient += weight * fit.away
    hessian[np.diag_indices_from(hessian)] += weight**2
    if fit.late > 0 and np.isfinite(tangents.time[-1]).all():
        last = LATE_COSTS * tangents.time[-1]
        gradient += fit.late * last
        hessian += np.outer(last, last)
    fixed = prior.sigma == 0
    gradient[fixed], hessian[fixed], hessian[:, fixed] = 0.0, 0.0, 0.0
    row = np.tile(np.arange(len(time)), 2)[usable]
    return Linearised(row, data, jacobian, velocity[usable], weights, gradient, hessian)


def _normal_equations(
    observed: Observations, noise: Noise, prior: Prior, fit: _Fit
) -> tuple[Floats, Floats]:
    """Gradient and Hessian of the loss."""
    whole = _linearised(observed, noise, prior, fit)
    return whole.gradient, whole.hessian


def _stepped(values: Floats, hessian: Floats, gradient: Floats, damping: float) -> Floats:
    """Step within the limits: a column that would leave them goes to its limit and stays there."""
    free = np.ones(len(values), dtype=bool)
    trial = values.copy()
    while True:
        trial[free] = (values - _step(hessian, gradient, damping, values - trial, free))[free]
        limited = within_limits(trial[None])[0]
        outside = free & (limited != trial)
        trial[outside] = limited[outside]
        free &= ~outside
        if not outside.any():
            return trial


def _step(
    hessian: Floats, gradient: Floats, damping: float, taken: Floats, free: np.ndarray
) -> Floats:
    """Step of the damped normal equations, shape (columns,), where some columns have theirs."""
    # Scaled to a unit diagonal first: the columns' units differ by ten orders of magnitude.
    scale = 1 / np.sqrt(np.maximum(np.diag(hessian)[free], 1e-300))
    fixed = ~free
    right = gradient[free] - hessian[np.ix_(free, fixed)] @ taken[fixed]
    unit = hessian[np.ix_(free, free)] * scale[:, None] * scale
    step = taken.copy()
    step[free] = np.linalg.solve(unit + damping * np.eye(len(unit)), right * scale) * scale
    return step

"""Least squares: the model's parameters from what was observed, for a given number of collisions.

Levenberg (1944) and Marquardt (1963) with all derivatives, and all trial steps, in one run of the
model each. Large residuals count like Cauchy errors: a frame in which the tracker was misled, or
which blends two paths, must not bend the fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.between.model import Paths, follow
from count_video.between.observations import Observations
from count_video.between.parameters import FIRST_DEVIATION, Column, Prior, within_limits
from count_video.between.sampling import Sampled, sample
from count_video.records import Floats

CORNER_SHARE = 0.15
"""A frame that holds a corner shows the ball twice or smeared; where a tracker then sees it is
uncertain by this share of what the exposure smears."""
CAUCHY_SIGMAS = 3.0
"""From here on a residual counts less than its square."""
DAMPINGS = 10.0 ** np.arange(-7, 3, 1.5)
"""Trial steps of one iteration, from a Gauss-Newton step to a short one downhill."""
LATE_COSTS = 10.0
"""Sigmas that each frame costs by which the last collision lies beyond the observations."""
LATE_AT_MOST = 1e4
STEPS = np.array([1e-4, 1e-6, 1e-8, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4, 1e-4, 1e-6, 1e-7, 1e-7, 1e-6])
"""Differences for the derivatives, by columns: far above rounding, far below any curvature."""
CONVERGED = 1e-3
"""Fall of the loss in an iteration that is not worth another one."""


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


def noise_of(observed: Observations, sampled: Sampled, floor_px: float = 0.0) -> Noise:
    """Noise to be expected where a model (its first set) has its corners."""
    smeared = CORNER_SHARE * (sampled.ball[0] - sampled.ball_centre[0])
    smeared = np.where(np.isfinite(smeared), smeared, 0.0)
    ball = np.hypot(np.hypot(observed.ball_sigma_px, floor_px), smeared)
    return Noise(ball, float(np.hypot(observed.heavy_sigma_px, floor_px)))


def scaled(noise: Noise, ball: float, heavy: float) -> Noise:
    """Noise with a factor for each body."""
    return Noise(noise.ball * ball, noise.heavy * heavy)


def derivative_widths(values: Floats) -> Floats:
    """Differences for derivatives at these values, shape (columns,)."""
    widths = np.concatenate([STEPS, np.full(len(values) - FIRST_DEVIATION, 1e-7)])
    widths[Column.EXPOSURE] *= -1 if values[Column.EXPOSURE] > 0.5 else 1  # stay within limits
    return widths


def modelled(observed: Observations, sets: Floats, count: int) -> tuple[Paths, Sampled]:
    """Follow and sample parameter sets where there are observations."""
    paths = follow(sets, count, float(observed.frame[0]) - 1.0)
    with np.errstate(invalid="ignore", over="ignore"):
        return paths, sample(paths, sets, observed.frame)


def losses(observed: Observations, noise: Noise, prior: Prior, sets: Floats, count: int) -> Floats:
    """Loss of each parameter set, shape (sets,)."""
    residuals = _residuals(observed, noise, prior, sets, count)
    return _loss(residuals, 2 * len(observed.frame))


def solve(
    observed: Observations,
    noise: Noise,
    prior: Prior,
    start: Floats,
    count: int,
    iterations: int = 20,
) -> Solution:
    """Fit the parameters from a start, shape (columns,); columns without freedom stay.

    A column of the prior with sigma 0 stays at the start.
    """
    free = np.flatnonzero(prior.sigma > 0)
    data = 2 * len(observed.frame)
    values, loss = start, np.inf
    for _ in range(iterations):
        residuals, jacobian = _linearized(observed, noise, prior, values, (count, free))
        before = float(_loss(residuals[None], data)[0])
        gradient, hessian = _normal_equations(residuals, jacobian, data)
        steps = _steps(hessian, gradient)
        trials = np.repeat(values[None], len(steps), axis=0)
        trials[:, free] -= steps
        trials = within_limits(trials)
        found = losses(observed, noise, prior, trials, count)
        best = int(np.argmin(found))
        if not found[best] < before:
            loss = before
            break
        values, loss = trials[best], float(found[best])
        if before - loss < CONVERGED:
            break
    return _solution(observed, noise, prior, values, (count, free))


def _solution(
    observed: Observations,
    noise: Noise,
    prior: Prior,
    values: Floats,
    freedom: tuple[int, np.ndarray],
) -> Solution:
    count, _ = freedom
    data = 2 * len(observed.frame)
    residuals, jacobian = _linearized(observed, noise, prior, values, freedom)
    _, hessian = _normal_equations(residuals, jacobian, data)
    _, sampled = modelled(observed, values[None], count)
    return Solution(
        count=count,
        values=values,
        loss=float(_loss(residuals[None], data)[0]),
        hessian=hessian,
        ball_residuals=observed.ball_px - sampled.ball[0],
        heavy_residuals=observed.heavy_px - sampled.heavy[0],
    )


def _residuals(
    observed: Observations, noise: Noise, prior: Prior, sets: Floats, count: int
) -> Floats:
    """Residuals in sigmas, shape (sets, 2 frames + columns); inf where the model fails."""
    paths, sampled = modelled(observed, sets, count)
    ball = (sampled.ball - observed.ball_px) / noise.ball
    heavy = (sampled.heavy - observed.heavy_px) / noise.heavy
    ball[:, np.isnan(observed.ball_px)] = 0.0
    heavy[:, np.isnan(observed.heavy_px)] = 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        known = np.isfinite(prior.sigma) & (prior.sigma > 0)
        away = np.where(known, (sets - prior.mean) / prior.sigma, 0.0)
    # A collision that these frames do not reach would cost nothing and prove nothing.
    late = np.clip(paths.time[:, -1:] - observed.frame[-1], 0.0, LATE_AT_MOST) * LATE_COSTS
    return np.concatenate([ball, heavy, away, late], axis=1)


def _loss(residuals: Floats, data: int) -> Floats:
    scaled = (residuals[:, :data] / CAUCHY_SIGMAS) ** 2
    with np.errstate(invalid="ignore", over="ignore"):
        robust = CAUCHY_SIGMAS**2 / 2 * np.log1p(scaled).sum(axis=1)
        total = robust + 0.5 * (residuals[:, data:] ** 2).sum(axis=1)
    return np.where(np.isfinite(total), total, np.inf)


def _linearized(
    observed: Observations,
    noise: Noise,
    prior: Prior,
    values: Floats,
    freedom: tuple[int, np.ndarray],
) -> tuple[Floats, Floats]:
    """Residuals and their derivatives by the free columns; shapes (r,) and (r, free)."""
    count, free = freedom
    widths = derivative_widths(values)
    sets = np.repeat(values[None], len(free) + 1, axis=0)
    sets[np.arange(1, len(sets)), free] += widths[free]
    residuals = _residuals(observed, noise, prior, sets, count)
    with np.errstate(invalid="ignore"):
        jacobian = ((residuals[1:] - residuals[0]) / widths[free, None]).T
    return residuals[0], np.where(np.isfinite(jacobian), jacobian, 0.0)


def _normal_equations(residuals: Floats, jacobian: Floats, data: int) -> tuple[Floats, Floats]:
    weights = np.ones_like(residuals)
    with np.errstate(invalid="ignore", over="ignore"):
        weights[:data] = 1 / (1 + (residuals[:data] / CAUCHY_SIGMAS) ** 2)
    usable = np.isfinite(residuals)
    weighted = jacobian * np.where(usable, weights, 0.0)[:, None]
    return weighted.T @ np.where(usable, residuals, 0.0), weighted.T @ jacobian


def _steps(hessian: Floats, gradient: Floats) -> Floats:
    """Trial steps for all dampings, shape (dampings, free)."""
    # Scaled to a unit diagonal first: the columns' units differ by ten orders of magnitude.
    scale = 1 / np.sqrt(np.maximum(np.diag(hessian), 1e-300))
    unit = hessian * scale[:, None] * scale
    damped = unit + DAMPINGS[:, None, None] * np.eye(len(unit))
    right = np.broadcast_to((gradient * scale)[:, None], (len(DAMPINGS), len(unit), 1))
    return np.asarray(np.linalg.solve(damped, right)[:, :, 0] * scale)

"""Least squares within limits, by Levenberg's and Marquardt's method; the losses are Cauchy's.

Large residuals count less than their squares: a frame in which the tracker was misled, or which
blends two paths, must not bend the fit. Levenberg (1944), Marquardt (1963), Cauchy's loss as in
Holland and Welsch (1977).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

import numpy as np

from count_video.motion.priors import CAUCHY_SIGMAS
from count_video.records import Floats

FIRST_DAMPING = 1e-3
"""Of the normal equations, scaled to a unit diagonal: nearly a Gauss-Newton step ..."""
MOST_DAMPING, LEAST_DAMPING = 1e4, 1e-12
"""... up to a short one downhill. The least is above the rounding of the equations, which without
any are singular where a parameter changes nothing."""
DAMPING_FALLS = 0.1
"""From one iteration to the next the damping falls to no less than this share."""
CONVERGED, NEARLY = 0.01, 0.5
"""Fall of the loss in an iteration that is not worth another one, and where the fit only begins
another one, or is compared with such: half a squared standard deviation."""
ITERATIONS = 30
SLOW_STEPS = 6
"""So many in a row are not worth another one, whatever is foreseen."""
FORESEEN = 2.0
"""The loss falls by less than so many times the share that the normal equations foresee."""


class Point(Protocol):
    """A model at one set of parameters, against what was observed."""

    @property
    def values(self) -> Floats:
        """Parameters, shape (columns,)."""

    @property
    def loss(self) -> float:
        """Half the sum of squares, robust, with the prior; inf where the model fails."""

    @property
    def squares(self) -> float:
        """Half the sum of squares with their weights, of which the normal equations foresee."""

    @property
    def gradient(self) -> Floats:
        """Of the loss, shape (columns,)."""

    @property
    def hessian(self) -> Floats:
        """Gauss-Newton's, shape (columns, columns); zero for columns without freedom."""


P = TypeVar("P", bound=Point)


def loss_of(residuals: Floats) -> float:
    """Sum the losses of residuals in standard deviations."""
    return float(CAUCHY_SIGMAS**2 / 2 * np.log1p((residuals / CAUCHY_SIGMAS) ** 2).sum())


def weights_of(residuals: Floats) -> Floats:
    """Weights by which squares of residuals have the slopes of their losses."""
    return np.asarray(1 / (1 + (residuals / CAUCHY_SIGMAS) ** 2))


def descend(
    at: Callable[[Floats], P],
    start: Floats,
    limits: tuple[Floats, Floats],
    bearable: float = np.inf,
    enough: float = CONVERGED,
) -> P:
    """Descend to the least loss from a start, shape (columns,), within limits of that shape.

    It ends where the loss falls by less than ``enough``, and the normal equations foresee no more,
    or in some steps in a row: in a curved valley they are short, and little falls although much is
    left to fall. What neither at its pace nor by these equations comes down to the bearable loss is
    given up. The damping follows from how well the equations foresaw the fall (Nielsen 1999), so
    that few steps are tried in vain.
    """
    point, damping, slow = at(start), FIRST_DAMPING, 0
    for left in range(ITERATIONS, 0, -1):
        tried, shortened = at(_stepped(point, damping, limits)), 0
        while not tried.loss < point.loss and damping <= MOST_DAMPING:
            shortened += 1
            damping *= 2**shortened
            tried = at(_stepped(point, damping, limits))
        fallen = point.loss - tried.loss
        if not fallen > 0:
            break
        foreseen = _foreseen(point, tried.values)
        agreed = fallen / foreseen if foreseen > 0 else 0.0
        damping *= max(DAMPING_FALLS, 1 - (2 * agreed - 1) ** 3)
        point, damping = tried, max(damping, LEAST_DAMPING)
        slow = slow + 1 if fallen < enough else 0
        if not slow and point.loss <= bearable:
            continue
        whole = _stepped(point, LEAST_DAMPING, limits)
        foreseen = _foreseen(point, whole)
        # A large residual counts for less in the squares than in the loss: a share holds for both.
        share = FORESEEN * foreseen / point.squares
        if point.loss - min(share * point.loss, left * fallen) > bearable:
            break
        if slow == SLOW_STEPS or (slow and foreseen < enough):
            # Near the least loss the undamped step comes closer to it by a square.
            return min(point, at(whole), key=lambda one: one.loss)
    return point


def _foreseen(point: Point, values: Floats) -> float:
    """Fall of the loss on the way to other values, shape (columns,), by the normal equations."""
    taken = values - point.values
    return -float(taken @ (point.gradient + point.hessian @ taken / 2))


def _stepped(point: Point, damping: float, limits: tuple[Floats, Floats]) -> Floats:
    """Step within the limits: a column that would leave them goes to its limit and stays there."""
    free, trial = np.ones(len(point.values), dtype=bool), point.values.copy()
    while True:
        trial[free] = (point.values - step(point, damping, point.values - trial, free))[free]
        limited = np.clip(trial, *limits)
        outside = free & (limited != trial)
        trial[outside] = limited[outside]
        free &= ~outside
        if not outside.any():
            return trial


def step(point: Point, damping: float, taken: Floats, free: np.ndarray) -> Floats:
    """Step of the damped normal equations, shape (columns,), where some columns have theirs."""
    # Scaled to a unit diagonal first: the columns' units differ by ten orders of magnitude.
    hessian, fixed = point.hessian, ~free
    scale = 1 / np.sqrt(np.maximum(np.diag(hessian)[free], 1e-300))
    right = point.gradient[free] - hessian[np.ix_(free, fixed)] @ taken[fixed]
    unit = hessian[np.ix_(free, free)] * scale[:, None] * scale
    whole = taken.copy()
    whole[free] = np.linalg.solve(unit + damping * np.eye(len(unit)), right * scale) * scale
    return whole

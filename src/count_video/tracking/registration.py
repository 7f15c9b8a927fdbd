"""Where in a picture is this template? Sub-pixel registration by Gauss-Newton.

A piece of the picture is smoothed as the template was, at a fraction of a pixel. The shift then
follows by weighted least squares on the linearised template, together with a gain and an offset for
lamps that flicker (Lucas and Kanade 1981; Baker and Matthews 2004).

Pixels that disagree (something passes in front, a reflection) lose their weight by Tukey's
biweight. The standard uncertainty comes from the residual noise carried through the same linear
equations, with the correlation that the smoothing causes taken into account.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.template import (
    Model,
    Picture,
    Pixels,
    Template,
    pixels_at,
    solve,
)

ROUNDS, FRESH_ROUNDS = 8, 2
"""In the first rounds, pixels may disagree because the place is wrong: which of them do is judged
anew. If that does not settle, the weights that were left judge the next round, as in iteratively
reweighted least squares."""
CONVERGED_PX = 0.1
"""A Gauss-Newton step this small ends the iteration: what is left is of the order of its square
times the bend of an edge over its slope, some thousandths of a px."""
CONVERGED_SIGMAS = 0.5
"""So does one that is small beside the uncertainty: along an edge there is no end of steps."""
GUESS_PX = 2.0
"""A guess is right to so much, as a standard deviation."""
STEP_AT_MOST_PX = 2.0
ASTRAY_PX = 8.0
"""The linear model leads nowhere from further away than this."""
BIWEIGHT = 5.0
"""Residuals beyond this many robust standard deviations have no say."""
KEPT = 1 - 2 / BIWEIGHT**2 + 3 / BIWEIGHT**4
"""Mean weight that the biweight leaves to pixels with normal noise: it takes from the normal
equations, but hardly from their information."""
SPREAD_STRIDE = 4
"""The robust standard deviation is taken over every fourth pixel: it need not be finer."""
PIXELS_AT_LEAST = 30
GAIN_AT_LEAST = 0.2
"""A body whose contrast fades below this share of the template's is not there."""


@dataclass(frozen=True)
class Fit:
    """Place of a template in one picture."""

    x_px: float
    y_px: float
    """Image position of the template's top left pixel."""
    sigma_x_px: float
    """Standard uncertainty of ``x_px``."""
    sigma_y_px: float
    agreement: float
    """Correlation of the picture with the template at its place, -1 to 1, over the pixels that
    were not taken for something in front of the body or behind it."""
    inside: float
    """Share of the template's pixels that lie within the picture, with nothing in front of them."""


Hides = Callable[[NDArray[np.intp], NDArray[np.intp]], NDArray[np.bool_]]
"""Whether something stands in front at these columns and rows of a picture, shape (n,) each."""


def register(
    picture: Picture, template: Template, guess: tuple[float, float], hides: Hides | None = None
) -> Fit | None:
    """Place the template in the picture, starting from a guess that is right to a pixel or two.

    ``hides`` marks which px of the picture show something in front of the body. Returns None where
    the equations have no solution or the iteration does not settle nearby.
    """
    within = _within(picture, template, guess, hides)
    if within is None:
        return None
    model, inside = within
    x, y = guess
    at, solver = (round(x), round(y)), model.solver
    for number in range(ROUNDS):
        if hides is not None and at != (round(x), round(y)):
            at = round(x), round(y)
            within = _within(picture, template, (x, y), hides)
            if within is None:
                return None
            model, inside = within
        seen = pixels_at(picture, x, y, model.tiles)
        step = _step(model, solver, seen, (guess[0] - x, guess[1] - y))
        if step is None:
            return None
        x, y = x + step.x_px, y + step.y_px
        if max(abs(x - guess[0]), abs(y - guess[1])) > ASTRAY_PX:
            return None
        if step.is_small:
            return Fit(x, y, step.sigma_x_px, step.sigma_y_px, step.agreement, inside)
        # What was found to disagree may not lead the next step astray.
        solver = step.solver if number >= FRESH_ROUNDS - 1 else model.solver
    return None


def _within(
    picture: Picture, template: Template, guess: tuple[float, float], hides: Hides | None
) -> tuple[Model, float] | None:
    """Model of those pixels that the picture shows, and their share; None if too few."""
    model = template.model
    if len(model.chosen) < PIXELS_AT_LEAST:
        return None
    height, width = template.shape
    rows, columns = picture.shape
    left, top = round(guess[0]), round(guess[1])
    whole = left >= 0 and top >= 0 and left + width <= columns and top + height <= rows
    if whole and hides is None:
        return model, 1.0
    y, x = np.divmod(model.chosen, width)
    x, y = x + left, y + top
    good = (x >= 1) & (x < columns - 1) & (y >= 1) & (y < rows - 1)
    if hides is not None:
        good &= ~hides(x, y)
    if np.count_nonzero(good) < PIXELS_AT_LEAST:
        return None
    # The others are read as well, but have no say.
    weight, root_weight = model.weight * good, model.root_weight * good
    solver = solve(model.design, weight)
    part = replace(model, weight=weight, root_weight=root_weight, solver=solver)
    return part, float(good.mean())


@dataclass(frozen=True)
class _Step:
    x_px: float
    y_px: float
    sigma_x_px: float
    sigma_y_px: float
    agreement: float
    """Weighted correlation of the picture with the template, at the place before the step."""
    solver: Pixels
    """Weighted least squares solution for the weights that were left, shape (4, n)."""

    @property
    def is_small(self) -> bool:
        """Whether another step would change little, or less than what the noise leaves open."""
        return abs(self.x_px) < max(CONVERGED_PX, CONVERGED_SIGMAS * self.sigma_x_px) and (
            abs(self.y_px) < max(CONVERGED_PX, CONVERGED_SIGMAS * self.sigma_y_px)
        )


def _step(model: Model, solver: Pixels, seen: Pixels, back: tuple[float, float]) -> _Step | None:
    """One robust least squares step; None if it is singular or the template fades away.

    ``solver`` gives the residuals that weigh the pixels. ``back`` is the way to where the search
    began. Along a straight edge nothing but that says where a template is: its prior keeps it from
    running away with the noise.
    """
    left_over = np.asarray(seen - (solver @ seen) @ model.design, np.float32)
    weight, spread = _robust(model, left_over)
    weighted = model.design * weight
    normal = (weighted @ model.design.T).astype(np.float64)
    projected = (weighted @ seen).astype(np.float64)
    agreement = _correlation(normal, projected, float((weight * seen) @ seen))
    prior = (spread / GUESS_PX) ** 2
    normal[0, 0] += prior
    normal[1, 1] += prior
    try:
        covariance = np.linalg.inv(normal)
    except np.linalg.LinAlgError:
        return None
    right = projected + prior * np.array([*back, 0.0, 0.0])
    along, across, gain, _ = (covariance @ right).tolist()
    if not gain > GAIN_AT_LEAST:
        return None
    x, y = (min(max(one / gain, -STEP_AT_MOST_PX), STEP_AT_MOST_PX) for one in (along, across))
    scale = spread * (KEPT * model.correlation) ** 0.5 / gain
    sigma_x, sigma_y = (max(float(covariance[k, k]), 0.0) ** 0.5 * scale for k in range(2))
    return _Step(x, y, sigma_x, sigma_y, agreement, covariance.astype(np.float32) @ weighted)


def _robust(model: Model, left_over: Pixels) -> tuple[Pixels, float]:
    """Weights with pixels that disagree taken down, and the spread of the others."""
    scaled = left_over * model.root_weight
    some = np.abs(scaled[::SPREAD_STRIDE][model.weight[::SPREAD_STRIDE] > 0])
    if len(some) == 0:
        return model.weight, 1e-6
    middle = len(some) // 2
    spread = MEDIAN_TO_SIGMA * float(np.partition(some, middle)[middle]) + 1e-6
    ratio = scaled * (1 / (BIWEIGHT * spread))
    keep = np.maximum(1 - ratio * ratio, 0)
    return model.weight * keep * keep, spread


def _correlation(normal: Floats, projected: Floats, power: float) -> float:
    """Weighted correlation of picture and template, from sums that the equations hold already.

    ``normal`` and ``projected`` are the weighted products of appearance (row 2) and ones (row 3)
    with each other and with the picture, ``power`` that of the picture with itself.
    """
    total = float(normal[3, 3])
    shared = float(projected[2]) - float(normal[2, 3]) * float(projected[3]) / total
    expected = float(normal[2, 2]) - float(normal[2, 3]) ** 2 / total
    seen = power - float(projected[3]) ** 2 / total
    return shared / float(np.sqrt(expected * seen)) if min(expected, seen) > 0 else 0.0

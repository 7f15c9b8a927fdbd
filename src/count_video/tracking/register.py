"""Where in a picture is this sprite? Sub-pixel registration by Gauss-Newton.

The picture is looked at as the sprite was, smoothed and at a fraction of a pixel. The shift then
follows by weighted least squares on the linearised sprite, together with a gain and an offset for
lamps that flicker (Lucas and Kanade 1981; Baker and Matthews 2004).

Pixels that disagree (something passes in front, a reflection) lose their weight by Tukey's
biweight. The standard uncertainty comes from the residual noise carried through the same linear
equations, with the correlation that the smoothing causes taken into account.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.tracking.sprite import Model, Picture, Pixels, Sprite, look, solve

ROUNDS = 8
CONVERGED_PX = 0.1
"""A Gauss-Newton step this small ends the iteration: what is left is of the order of its square
times the bend of an edge over its slope, some thousandths of a px."""
STEP_AT_MOST_PX = 2.0
ASTRAY_PX = 8.0
"""The linear model leads nowhere from further away than this."""
BIWEIGHT = 5.0
"""Residuals beyond this many robust standard deviations have no say."""
KEPT = 1 - 2 / BIWEIGHT**2 + 3 / BIWEIGHT**4
"""Mean weight that the biweight leaves to pixels with normal noise: it takes from the normal
equations, but hardly from what the pixels tell."""
SPREAD_STRIDE = 4
"""The robust standard deviation is taken over every fourth pixel: it need not be finer."""
PIXELS_AT_LEAST = 30
GAIN_AT_LEAST = 0.2
"""A body whose contrast fades below this share of the sprite's is not there."""


@dataclass(frozen=True)
class Fit:
    """Place of a sprite in one picture."""

    x_px: float
    y_px: float
    """Image position of the sprite's top left pixel."""
    sigma_x_px: float
    """Standard uncertainty of ``x_px``."""
    agreement: float
    """Correlation of the picture with the sprite at its place, -1 to 1, over the pixels that
    were not taken for something in front of the body or behind it."""
    inside: float
    """Share of the sprite's pixels that lie within the picture."""


def register(picture: Picture, sprite: Sprite, guess: tuple[float, float]) -> Fit | None:
    """Place the sprite in the picture, starting from a guess that is right to a pixel or two.

    Returns None where the equations have no solution or the iteration does not settle nearby.
    """
    model, inside = _within(picture, sprite, guess)
    if len(model.chosen) < PIXELS_AT_LEAST:
        return None
    x, y = guess
    for _ in range(ROUNDS):
        seen = look(picture, x, y, sprite.shape).ravel()[model.chosen]
        step = _step(model, seen)
        if step is None:
            return None
        x, y = x + step.x_px, y + step.y_px
        if max(abs(x - guess[0]), abs(y - guess[1])) > ASTRAY_PX:
            return None
        if max(abs(step.x_px), abs(step.y_px)) < CONVERGED_PX:
            agreement = _correlation(seen, model.design[:, 2], step.weight)
            return Fit(x, y, step.sigma_x_px, agreement, inside)
    return None


def _within(picture: Picture, sprite: Sprite, guess: tuple[float, float]) -> tuple[Model, float]:
    """Model of those pixels that lie within the picture, and their share."""
    height, width = sprite.shape
    rows, columns = picture.shape
    left, top = round(guess[0]), round(guess[1])
    model = sprite.model
    if left >= 0 and top >= 0 and left + width <= columns and top + height <= rows:
        return model, 1.0
    y, x = np.divmod(model.chosen, width)
    good = (x + left >= 1) & (x + left < columns - 1) & (y + top >= 1) & (y + top < rows - 1)
    design, weight = model.design[good], model.weight[good]
    solver = solve(design, weight)
    part = Model(
        model.chosen[good], design, weight, model.root_weight[good], solver, model.correlation
    )
    return part, float(good.mean()) if len(good) else 0.0


@dataclass(frozen=True)
class _Step:
    x_px: float
    y_px: float
    sigma_x_px: float
    weight: Pixels
    """Weights of the pixels, those that disagree taken down."""


def _step(model: Model, seen: Pixels) -> _Step | None:
    """One robust least squares step; None if it is singular or the sprite fades away."""
    left_over = seen - model.design @ (model.solver @ seen)
    scaled = left_over * model.root_weight
    some = np.abs(scaled[::SPREAD_STRIDE])
    middle = len(some) // 2
    spread = 1.4826 * float(np.partition(some, middle)[middle]) + 1e-6
    ratio = scaled * (1 / (BIWEIGHT * spread))
    keep = np.maximum(1 - ratio * ratio, 0)
    weight = model.weight * keep * keep
    weighted = model.design * weight[:, None]
    normal = (model.design.T @ weighted).astype(np.float64)
    wanted = np.zeros((4, 2))
    wanted[:, 0] = weighted.T @ seen
    wanted[0, 1] = 1.0  # the second solution is the first column of the covariance
    try:
        solution = np.linalg.solve(normal, wanted)
    except np.linalg.LinAlgError:
        return None
    gain = float(solution[2, 0])
    if not gain > GAIN_AT_LEAST:
        return None
    x, y = (
        min(max(float(value) / gain, -STEP_AT_MOST_PX), STEP_AT_MOST_PX)
        for value in solution[:2, 0]
    )
    variance = max(float(solution[0, 1]), 0.0) * spread**2 * KEPT * model.correlation
    return _Step(x, y, float(np.sqrt(variance)) / gain, weight)


def _correlation(seen: Pixels, expected: Pixels, weight: Pixels) -> float:
    total = float(weight.sum())
    a = seen - float(weight @ seen) / total
    b = expected - float(weight @ expected) / total
    power = float((weight * a) @ a) * float((weight * b) @ b)
    return float((weight * a) @ b) / float(np.sqrt(power)) if power > 0 else 0.0

"""Where in a picture is this sprite? Sub-pixel registration by Gauss-Newton.

A sprite is the mean appearance of a body, smoothed by a Gaussian. The picture is smoothed by the
same Gaussian *shifted by the fraction of a pixel that is asked for*: a Gaussian of 0.8 px holds
almost nothing beyond the sampling frequency, so this interpolates and smooths in one exact step.
The shift then follows by weighted least squares on the linearised sprite, together with a gain
and an offset for lamps that flicker (Lucas and Kanade 1981; Baker and Matthews 2004).

Pixels that disagree (something passes in front, a reflection) lose their weight by Tukey's
biweight. The standard uncertainty comes from the residual noise carried through the same linear
equations, with the correlation that the smoothing causes taken into account.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Pixels = NDArray[np.float32]

SMOOTHING_PX = 0.8
REACH_PX = 4
"""Half width of the smoothing kernel: five standard deviations."""
ROUNDS = 8
CONVERGED_PX = 0.05
"""A Gauss-Newton step this small ends the iteration: what is left is of the order of its square
times the bend of an edge over its slope, a few thousandths of a px."""
STEP_AT_MOST_PX = 2.0
STEP_LIMITS_PX = (-STEP_AT_MOST_PX, STEP_AT_MOST_PX)
ASTRAY_PX = 8.0
"""The linear model leads nowhere from further away than this."""
BIWEIGHT = 5.0
"""Residuals beyond this many robust standard deviations have no say."""
SPREAD_STRIDE = 4
"""The robust standard deviation is taken over every fourth pixel: it need not be finer."""
INFORMATIVE_PIXELS = 2000
"""More pixels than this cost time and add little: the best are taken."""
PIXELS_AT_LEAST = 30
GAIN_AT_LEAST = 0.2
"""A body whose contrast fades below this share of the sprite's is not there."""


@dataclass(frozen=True)
class Sprite:
    """Appearance of one body; pixel (0, 0) is the top left corner of the box around it."""

    appearance: Pixels
    """Mean smoothed luma, shape (height, width)."""
    weight: Pixels
    """Inverse variance of each pixel in 1 / grey level squared; 0 where it is not the body."""
    model: Model
    """The linearised sprite, at the pixels that take part in the registration."""

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in px."""
        height, width = self.appearance.shape
        return height, width


@dataclass(frozen=True)
class Model:
    """Brightness of n chosen pixels, linear in shift x, shift y, gain and offset."""

    chosen: NDArray[np.intp]
    """Flat indices of the pixels within the sprite, shape (n,)."""
    design: Pixels
    """Shape (n, 4): minus the slopes by x and y, the centred appearance, ones."""
    weight: Pixels
    """Shape (n,)."""
    solver: Pixels
    """Weighted least squares solution for all weights as given, shape (4, n)."""
    correlation: float
    """Variance of the shift by x over that which independent pixels would give."""


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


def make_sprite(appearance: Pixels, weight: Pixels) -> Sprite:
    """Complete a sprite from its mean appearance and the weight of its pixels."""
    slope_y, slope_x = np.gradient(appearance)
    worth = (slope_x**2 + 0.1 * slope_y**2) * weight
    usable = np.flatnonzero(weight.ravel() > 0)
    if len(usable) > INFORMATIVE_PIXELS:
        best = np.argpartition(-worth.ravel()[usable], INFORMATIVE_PIXELS)[:INFORMATIVE_PIXELS]
        usable = np.sort(usable[best])
    flat = appearance.ravel()[usable]
    columns = [
        -slope_x.ravel()[usable],
        -slope_y.ravel()[usable],
        flat - flat.mean(),  # centred, so that gain and offset do not mix
        np.ones_like(flat),
    ]
    design = np.stack(columns, axis=1).astype(np.float32)
    chosen_weight = weight.ravel()[usable].astype(np.float32)
    solver = _solver(design, chosen_weight)
    correlation = _correlation_factor(usable, solver[0], appearance.shape)
    return Sprite(
        appearance=appearance.astype(np.float32),
        weight=weight.astype(np.float32),
        model=Model(usable, design, chosen_weight, solver, correlation),
    )


def _solver(design: Pixels, weight: Pixels) -> Pixels:
    """Pseudo-inverse of the weighted design; a body without slopes gets the least-norm one."""
    weighted = (design * weight[:, None]).astype(np.float64)
    normal = np.linalg.pinv(design.T.astype(np.float64) @ weighted, hermitian=True)
    return np.asarray(normal @ weighted.T, dtype=np.float32)


def _correlation_factor(
    chosen: NDArray[np.intp], combination: Pixels, shape: tuple[int, ...]
) -> float:
    """How much a combination of pixels gains in variance because smoothing made them share noise.

    White noise of variance v, smoothed by a kernel g, has the variance v sum(g^2) in each pixel;
    a combination c of its pixels has v sum((c * g)^2) instead of v sum(g^2) sum(c^2).
    """
    picture = np.zeros((shape[0] + 2 * REACH_PX, shape[1] + 2 * REACH_PX), dtype=np.float32)
    row, column = np.divmod(chosen, shape[1])
    picture[row + REACH_PX, column + REACH_PX] = combination
    power = float((picture.astype(np.float64) ** 2).sum())
    if power == 0.0:
        return 1.0
    shared = float((_smooth(picture, 0.0, 0.0).astype(np.float64) ** 2).sum())
    return shared / power / float((_kernel(0.0).astype(np.float64) ** 2).sum()) ** 2


def look(picture: Picture, x_px: float, y_px: float, shape: tuple[int, int]) -> Pixels:
    """Cut out a smoothed piece of the picture at a fractional place.

    Returns shape ``shape``: the piece whose top left pixel lies at (``x_px``, ``y_px``). Beyond
    the picture's border its last row or column goes on.
    """
    left, top = round(x_px), round(y_px)
    piece = _cut(picture, left - REACH_PX, top - REACH_PX, shape)
    return _smooth(piece, x_px - left, y_px - top)[REACH_PX:-REACH_PX, REACH_PX:-REACH_PX]


def _cut(picture: Picture, left: int, top: int, shape: tuple[int, int]) -> Picture:
    height, width = shape[0] + 2 * REACH_PX, shape[1] + 2 * REACH_PX
    rows, columns = picture.shape
    if left >= 0 and top >= 0 and left + width <= columns and top + height <= rows:
        return picture[top : top + height, left : left + width]
    y = np.clip(np.arange(top, top + height), 0, rows - 1)
    x = np.clip(np.arange(left, left + width), 0, columns - 1)
    return picture[np.ix_(y, x)]


def _smooth(piece: Picture | Pixels, fraction_x: float, fraction_y: float) -> Pixels:
    smoothed = cv2.sepFilter2D(
        np.ascontiguousarray(piece), cv2.CV_32F, _kernel(fraction_x), _kernel(fraction_y)
    )
    return np.asarray(smoothed, dtype=np.float32)


def _kernel(fraction: float) -> Pixels:
    """Gaussian sampled about ``fraction``, normalised."""
    taps = np.arange(-REACH_PX, REACH_PX + 1) - fraction
    bell = np.exp(-0.5 * (taps / SMOOTHING_PX) ** 2)
    return np.asarray(bell / bell.sum(), dtype=np.float32)


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
    solver = _solver(design, weight)
    part = Model(model.chosen[good], design, weight, solver, model.correlation)
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
    scaled = left_over * np.sqrt(model.weight)
    spread = 1.4826 * float(np.median(np.abs(scaled[::SPREAD_STRIDE]))) + 1e-6
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
    x, y = (float(value) for value in np.clip(solution[:2, 0] / gain, *STEP_LIMITS_PX))
    variance = max(float(solution[0, 1]), 0.0) * spread**2 * model.correlation
    return _Step(x, y, float(np.sqrt(variance)) / gain, weight)


def _correlation(seen: Pixels, expected: Pixels, weight: Pixels) -> float:
    total = float(weight.sum())
    a = seen - float(weight @ seen) / total
    b = expected - float(weight @ expected) / total
    power = float((weight * a) @ a) * float((weight * b) @ b)
    return float((weight * a) @ b) / float(np.sqrt(power)) if power > 0 else 0.0


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

from count_video.records import Floats

Picture = NDArray[np.uint8]
Pixels = NDArray[np.float32]

SMOOTHING_PX = 0.8
REACH_PX = 4
"""Half width of the smoothing kernel: five standard deviations."""
ROUNDS = 8
CONVERGED_PX = 0.01
"""A Gauss-Newton step this small ends the iteration: its square is far below the noise."""
STEP_AT_MOST_PX = 2.0
BIWEIGHT = 5.0
"""Residuals beyond this many robust standard deviations have no say."""
QUANTISATION = 0.29
"""Standard deviation of rounding to whole grey levels, 1/sqrt(12)."""
INFORMATIVE_PIXELS = 3000
"""More pixels than this cost time and add little: the best are taken."""


@dataclass(frozen=True)
class Sprite:
    """Appearance of one body; pixel (0, 0) is the top left corner of the box around it."""

    appearance: Pixels
    """Mean smoothed luma, shape (height, width)."""
    slope_x: Pixels
    slope_y: Pixels
    """Derivatives of ``appearance`` by x and y, in grey levels per px."""
    weight: Pixels
    """Inverse variance of each pixel in 1 / grey level squared; 0 where it is not the body."""
    chosen: NDArray[np.intp]
    """Flat indices of the pixels that take part in the registration."""

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in px."""
        height, width = self.appearance.shape
        return height, width


@dataclass(frozen=True)
class Fit:
    """Place of a sprite in one picture."""

    x_px: float
    y_px: float
    """Image position of the sprite's top left pixel."""
    sigma_x_px: float
    """Standard uncertainty of ``x_px``."""
    agreement: float
    """Correlation of the picture with the sprite at its place, -1 to 1."""
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
    return Sprite(
        appearance=appearance.astype(np.float32),
        slope_x=slope_x.astype(np.float32),
        slope_y=slope_y.astype(np.float32),
        weight=weight.astype(np.float32),
        chosen=usable,
    )


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


def _smooth(piece: Picture, fraction_x: float, fraction_y: float) -> Pixels:
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

    Returns None where the equations have no solution or the iteration runs away.
    """
    chosen, inside = _within(picture, sprite, guess)
    if len(chosen) < 30:
        return None
    design, weight = _design(sprite, chosen)
    x, y = guess
    for _ in range(ROUNDS):
        seen = look(picture, x, y, sprite.shape).ravel()[chosen]
        solution = _solve(design, weight, seen)
        if solution is None:
            return None
        step_x, step_y = solution.step_px
        x, y = x + step_x, y + step_y
        if max(abs(x - guess[0]), abs(y - guess[1])) > 4 * STEP_AT_MOST_PX:
            return None
        if max(abs(step_x), abs(step_y)) < CONVERGED_PX:
            break
    agreement = _correlation(seen, sprite.appearance.ravel()[chosen], weight)
    return Fit(x, y, solution.sigma_x_px, agreement, inside)


def _within(
    picture: Picture, sprite: Sprite, guess: tuple[float, float]
) -> tuple[NDArray[np.intp], float]:
    """Those chosen pixels that lie within the picture, and their share."""
    height, width = sprite.shape
    rows, columns = picture.shape
    left, top = round(guess[0]), round(guess[1])
    if left >= 0 and top >= 0 and left + width <= columns and top + height <= rows:
        return sprite.chosen, 1.0
    y, x = np.divmod(sprite.chosen, width)
    good = (x + left >= 1) & (x + left < columns - 1) & (y + top >= 1) & (y + top < rows - 1)
    return sprite.chosen[good], float(good.mean()) if len(good) else 0.0


def _design(sprite: Sprite, chosen: NDArray[np.intp]) -> tuple[Pixels, Pixels]:
    """Columns of the linear model: shift in x, shift in y, gain, offset."""
    flat = sprite.appearance.ravel()[chosen]
    columns = [
        -sprite.slope_x.ravel()[chosen],
        -sprite.slope_y.ravel()[chosen],
        flat,
        np.ones_like(flat),
    ]
    return np.stack(columns, axis=1), sprite.weight.ravel()[chosen]


@dataclass(frozen=True)
class _Solution:
    step_px: tuple[float, float]
    sigma_x_px: float


def _solve(design: Pixels, weight: Pixels, seen: Pixels) -> _Solution | None:
    """One weighted least squares step; None if it is singular or the sprite fades away."""
    start = _weighted(design, weight, seen)
    if start is None:
        return None
    scaled = (seen - design @ start[0]) * np.sqrt(weight)
    spread = 1.4826 * float(np.median(np.abs(scaled))) + 1e-6
    robust = weight * np.clip(1 - (scaled / (BIWEIGHT * spread)) ** 2, 0, None) ** 2
    final = _weighted(design, robust, seen)
    if final is None or final[0][2] < 0.2:
        return None
    coefficients, covariance = final
    gain = float(coefficients[2])
    step = np.clip(coefficients[:2] / gain, -STEP_AT_MOST_PX, STEP_AT_MOST_PX)
    variance = float(covariance[0, 0]) * spread**2 * CORRELATION_FACTOR
    return _Solution((float(step[0]), float(step[1])), float(np.sqrt(variance)) / gain)


def _weighted(design: Pixels, weight: Pixels, seen: Pixels) -> tuple[Floats, Floats] | None:
    """Coefficients and their covariance (for unit variance of the weighted residuals)."""
    weighted = design * weight[:, None]
    normal = (design.T @ weighted).astype(np.float64)
    scale = np.sqrt(np.diag(normal))
    if not np.all(scale > 0):
        return None
    try:
        inverse = np.linalg.inv(normal / np.outer(scale, scale)) / np.outer(scale, scale)
    except np.linalg.LinAlgError:
        return None
    return inverse @ (weighted.T @ seen).astype(np.float64), inverse


def _correlation(seen: Pixels, expected: Pixels, weight: Pixels) -> float:
    total = float(weight.sum())
    a = seen - float(weight @ seen) / total
    b = expected - float(weight @ expected) / total
    power = float((weight * a) @ a) * float((weight * b) @ b)
    return float((weight * a) @ b) / float(np.sqrt(power)) if power > 0 else 0.0


# Neighbouring pixels of a smoothed picture share their noise. For white noise smoothed by a
# Gaussian of width s, a slowly varying combination of n pixels has a variance larger than that of
# n independent ones by 4 pi s^2, the area under the squared kernel's autocorrelation; the slopes
# used here vary along x as the derivative of an edge does, which the same smoothing made, and
# the factor comes down to sqrt(4 pi) s times the share that survives a second smoothing in x.
CORRELATION_FACTOR = float(np.sqrt(4 * np.pi) * SMOOTHING_PX)

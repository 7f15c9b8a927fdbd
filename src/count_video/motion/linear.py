"""Linear least squares, of one design or of many at once."""

from __future__ import annotations

import numpy as np

from count_video.records import Floats


def least_squares(design: Floats, place: Floats) -> tuple[Floats, Floats, Floats]:
    """Fit places, shape (..., n), by designs of shape (..., n, k); rows of zeros say nothing.

    Returns the coefficients, shape (..., k), their covariance for places of variance 1, and the
    sums of squares that are left over; all NaN where the columns are not independent.
    """
    scale = np.abs(design).max(axis=-2)
    scale = np.where(scale > 0, scale, 1.0)[..., None]
    scaled = design / np.swapaxes(scale, -1, -2)
    sides = np.swapaxes(scaled, -1, -2)
    # Eigenvalues of the small normal equations: for many designs far faster than those of each.
    sizes, vectors = np.linalg.eigh(sides @ scaled)
    least = design.shape[-2] * np.finfo(np.float64).eps * sizes[..., -1:]
    sizes = np.where(sizes[..., :1] > least, sizes, np.nan)
    inverse = (vectors / sizes[..., None, :]) @ np.swapaxes(vectors, -1, -2)
    solution = (inverse @ (sides @ place[..., None])) / scale
    rest = place[..., None] - design @ solution
    covariance = inverse / (scale * np.swapaxes(scale, -1, -2))
    return solution[..., 0], covariance, np.sum(rest**2, axis=(-2, -1))

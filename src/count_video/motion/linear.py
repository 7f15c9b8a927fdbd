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
    left, sizes, right = np.linalg.svd(design / np.swapaxes(scale, -1, -2), full_matrices=False)
    least = design.shape[-2] * np.finfo(np.float64).eps * sizes[..., :1]
    sizes = np.where(sizes[..., -1:] > least, sizes, np.nan)
    inverse = np.swapaxes(right, -1, -2) / sizes[..., None, :] / scale
    solution = (inverse @ (np.swapaxes(left, -1, -2) @ place[..., None]))[..., 0]
    rest = place - (design @ solution[..., None])[..., 0]
    return solution, inverse @ np.swapaxes(inverse, -1, -2), np.sum(rest**2, axis=-1)

"""How the bodies hung and where the heavy one was let go, as the fits have it.

The fits' parameters are the motion at the first collision; what a person set up by hand follows
from them: the gap, the release (the swing's amplitude before the first collision), the gap between
the bodies at rest, and the periods of the threads. Their uncertainties are those of the parameters,
carried over by numeric derivatives, and the differences between the fits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from count_video.between.parameters import Column
from count_video.between.weighing import Weighed
from count_video.records import Estimate, FittedSetup, Floats

STEP_SIGMAS = 0.01
"""Step of a numeric derivative, in standard deviations of the parameter: what is asked for is
smooth, and much smaller steps would leave roundings."""
_USED = (
    *(Column.HEAVY, Column.HEAVY_RATE, Column.HEAVY_PULL, Column.SWING, Column.BALL_SWING),
    *(Column.BALL_REST, Column.WALL),
)


class _Arrangement(NamedTuple):
    gap_px: Floats
    release_px: Floats
    bodies_gap_px: Floats
    heavy_period_frames: Floats
    ball_period_frames: Floats


def fitted_setup(weighed: Weighed, shares: Floats) -> FittedSetup:
    """Mean and standard uncertainty of the set-up over all fits, of which each has its share."""
    fits = [fit for _, fit in weighed.values()]
    values = np.array([_arranged(fit.values) for fit in fits])
    variances = np.array([_variances(fit.values, fit.hessian) for fit in fits])
    mean = shares @ values
    sigma = np.sqrt(shares @ (variances + (values - mean) ** 2))
    return FittedSetup(*(Estimate(float(m), float(s)) for m, s in zip(mean, sigma, strict=True)))


def _arranged(values: Floats) -> _Arrangement:
    """Derive the set-up from parameters, shape (columns,) or (columns, sets)."""
    rate = np.exp(values[Column.SWING])
    from_rest = -values[Column.HEAVY_PULL] / rate**2
    rest = values[Column.HEAVY] - from_rest
    period = 2.0 * np.pi / rate
    return _Arrangement(
        gap_px=values[Column.BALL_REST] - values[Column.WALL],
        release_px=np.hypot(from_rest, values[Column.HEAVY_RATE] / rate),
        bodies_gap_px=rest - values[Column.BALL_REST],
        heavy_period_frames=period,
        ball_period_frames=period * np.exp(-values[Column.BALL_SWING]),
    )


def _variances(values: Floats, hessian: Floats) -> Floats:
    """Variances of the set-up that belongs to one fit, shape (5,)."""
    covariance = np.linalg.pinv(hessian, hermitian=True)[np.ix_(_USED, _USED)]
    steps = STEP_SIGMAS * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    sets = np.repeat(values[:, None], 2 * len(_USED), axis=1)
    places = np.arange(len(_USED))
    sets[_USED, 2 * places] += steps
    sets[_USED, 2 * places + 1] -= steps
    moved = np.array(_arranged(sets))
    rise = moved[:, 0::2] - moved[:, 1::2]
    jacobian = np.divide(rise, 2.0 * steps, out=np.zeros_like(rise), where=steps > 0)
    return np.asarray(np.einsum("ip,pq,iq->i", jacobian, covariance, jacobian))

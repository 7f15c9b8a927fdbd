"""Noisy signals: where they turn or are highest, how noisy they are, how long their errors last."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats

Values = NDArray[np.float32] | Floats

MEDIAN_TO_SIGMA = 1.4826
"""Standard deviation over the median of absolute values, of normal noise."""

QUARTILE = 0.3186
"""Lower quartile of a standard normal value without its sign."""

# ---- low points and noise ------------------------------------------------------------------------
# Low points of a gap that closes and opens again:
#
#     gap
#      |\            /\            __/
#      | \    /\    /  \        __/
#      |  \  /  \  /    \    __/
#      |   \/    \/      \__/
#      +----1-----2--------3---------> frame
#
# A low point counts once the signal has risen above it by more than the hysteresis, and had come
# down to it from as far above; smaller ups and downs are noise. By name:
#
# - an exact zero, or a value below zero: no different from any other value, only order matters;
# - a plateau (equal lowest values, 3): its middle;
# - the two ends: a signal that still falls at its end has no low point there, nor has one that
#   rises from its start, for nothing was seen on the other side;
# - NaN (not seen): passed over.

NOISE_AT_LEAST_PX = 0.03
"""Footage is compressed: no track is better than this over a few frames."""


def low_points(signal: Floats, hysteresis: float) -> NDArray[np.intp]:
    """Find the low points of a signal, shape (n,), NaN where not seen.

    Each is deeper on both sides than the hysteresis, which is positive, in the signal's unit.
    """
    found: list[int] = []
    highest, lowest, begin, end = -np.inf, np.inf, -1, -1
    for place in np.flatnonzero(np.isfinite(signal)):
        value = float(signal[place])
        if begin < 0:
            # Seeking the way down: from the highest point so far.
            highest = max(highest, value)
            if highest - value > hysteresis:
                lowest, begin, end = value, int(place), int(place)
        elif value < lowest:
            lowest, begin, end = value, int(place), int(place)
        elif value == lowest:
            end = int(place)
        elif value - lowest > hysteresis:
            found.append((begin + end) // 2)
            highest, lowest, begin = value, np.inf, -1
    return np.array(found, dtype=np.intp)


def noise_px(signal: Floats) -> float:
    """Estimate the independent noise on a smooth signal, shape (n,); 0 if n < 4.

    Third differences remove any locally quadratic motion; of white noise they have a variance of
    1 + 9 + 9 + 1 = 20. The lower quartile keeps the corners of the signal out of it: short
    flights leave fewer than half of them clear.
    """
    third = np.diff(signal, n=3)
    third = third[np.isfinite(third)]
    if len(third) == 0:
        return 0.0
    return float(np.quantile(np.abs(third), 0.25) / QUARTILE / np.sqrt(20.0))


def sigma_of(signal: Floats) -> float:
    """Noise in px of one frame of a track, shape (n,), not below what compression leaves."""
    return max(noise_px(signal), NOISE_AT_LEAST_PX)


def interpolated(signal: Floats) -> Floats:
    """Fill what was not seen of a signal, shape (n,), in by linear interpolation.

    Before the first value and after the last one these go on; one at least must have been seen.
    """
    rows, seen = np.arange(len(signal)), np.isfinite(signal)
    return np.asarray(np.interp(rows, rows[seen], signal[seen]), np.float64)


def integral(time: Floats, values: Floats) -> Floats:
    """Integrate by the trapezoidal rule from the first value on, shape (n,)."""
    means = (values[1:] + values[:-1]) / 2
    return np.concatenate([[0.0], np.cumsum(means * np.diff(time))])


# ---- medians, and peaks between samples ----------------------------------------------------------


def weighted_quantile(values: Floats, weights: Floats, part: float) -> float:
    """Value below which a part of the weight lies."""
    order = np.argsort(values, kind="stable")
    share = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(share, part * share[-1])])


MISPLACED = 5
"""A median of so many places in a row is right though two of them are misplaced."""


def running_median(values: Floats) -> Floats:
    """Median of some rows about each, shape (n, ...); the first and last are repeated."""
    around = np.pad(values, [(MISPLACED // 2,) * 2, *[(0, 0)] * (values.ndim - 1)], mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(around, MISPLACED, axis=0)
    return np.asarray(np.median(windows, axis=-1))


def correlation(one: Values, other: Values, weight: Values) -> float:
    """Weighted correlation of n values with others; NaN where one of both is flat."""
    a, b = (values - np.average(values, weights=weight) for values in (one, other))
    power = float((weight * a) @ a) * float((weight * b) @ b)
    return float((weight * a) @ b) / power**0.5 if power > 0 else np.nan


def peak_of(values: Values, place: int) -> float:
    """Refine the place of a peak by the parabola through its highest sample and the neighbours.

    ``values`` have shape (n,), and the highest is at ``place``; at an end the peak is taken to be
    there.
    """
    if not 0 < place < len(values) - 1:
        return float(place)
    return place + float(beyond(values[place - 1], values[place], values[place + 1]))


def beyond(
    before: Values | np.float32, here: Values | np.float32, after: Values | np.float32
) -> NDArray[np.float64]:
    """How far a peak lies from its highest sample, -0.5 to 0.5; 0 for a plateau."""
    low, high, top = np.float64(before), np.float64(after), np.float64(here)
    bend = 2 * top - low - high
    return np.asarray(np.where(bend > 0, 0.5 * (high - low) / np.where(bend > 0, bend, 1), 0))

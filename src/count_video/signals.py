"""Noisy signals: where they turn or are highest, how noisy they are, how long their errors last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats

Values = NDArray[np.float32] | Floats

MEDIAN_TO_SIGMA = 1.4826
"""Standard deviation over the median of absolute values, of normal noise."""

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
    """Find the low points of a signal, each deeper than the hysteresis on both sides.

    Parameters
    ----------
    signal
        Shape (n,); NaN where not seen.
    hysteresis
        Depth, in the signal's unit, that a low point must have on either side; positive.
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


def depths(signal: Floats, lows: NDArray[np.intp]) -> Floats:
    """How deep low points are: how far the signal rises on the way to the next lower one.

    That is their persistence (Edelsbrunner, Letscher and Zomorodian 2002). The lowest of all is as
    deep as the signal reaches up. ``signal`` has shape (n,), NaN where not seen, and ``lows`` are
    places in it, in order.
    """
    found = np.empty(len(lows))
    peaks = [np.nanmax(part) for part in np.split(signal, lows)] if len(lows) else []
    for place, low in enumerate(lows):
        barriers = []
        for rising, others in (
            (peaks[place::-1], lows[:place][::-1]),
            (peaks[place + 1 :], lows[place + 1 :]),
        ):
            highest = np.maximum.accumulate(rising)
            lower = np.flatnonzero(signal[others] < signal[low])
            barriers += [float(highest[lower[0]])] if len(lower) else []
        found[place] = min(barriers, default=max(peaks)) - signal[low]
    return found


def noise_px(signal: Floats) -> float:
    """Estimate the independent noise on a smooth signal, shape (n,); 0 if n < 4.

    Third differences remove any locally quadratic motion; of white noise they have a variance of
    1 + 9 + 9 + 1 = 20. The median keeps the corners of the signal out of it.
    """
    third = np.diff(signal[np.isfinite(signal)], n=3)
    if len(third) == 0:
        return 0.0
    return float(MEDIAN_TO_SIGMA * np.median(np.abs(third)) / np.sqrt(20.0))


def sigma_of(signal: Floats) -> float:
    """Noise in px of one frame of a track, shape (n,), not below what compression leaves."""
    return max(noise_px(signal), NOISE_AT_LEAST_PX)


# ---- errors that last: restricted maximum likelihood ---------------------------------------------
# Places y of a body in flight are a smooth path and an error e,
#
#     y_i = X_i b + e_i,     cov(e_i, e_j) = s^2 [w (i = j) + (1 - w) exp(-|t_i - t_j| / T)].
#
# A share w of the error's variance is white, the rest lasts for about T frames: encoders leave
# both. What lasts resembles motion in part. The fit takes it up, and what is left about the fit is
# too small. The restricted likelihood (Patterson and Thompson 1971) is that of the part of y which
# no path can explain. For each pair (T, w) it gives s^2 without that loss, and how well the pair
# agrees with the places:
#
#     2 log L = - log|C| - log|X' C^-1 X| - f log(s^2),     s^2 = y' P y / f,
#
# with C the covariance over s^2, P = C^-1 - C^-1 X (X' C^-1 X)^-1 X' C^-1 and f the degrees of
# freedom. C is never written down: a Kalman filter whose state is the lasting error turns the
# columns of X and y into independent ones, frame by frame, for all pairs at once. Pairs that fit
# alike are hard to distinguish, so the variance is the mean of theirs, weighted by likelihood.

LASTS_FRAMES = (2.0, 4.0, 8.0, 16.0)
"""What lasts longer than that the path takes up in most flights: the places say nothing of it."""
FORGOTTEN_FRAMES = 36 * LASTS_FRAMES[-1]
"""Errors so far apart have a correlation of exp(-36), a rounding error, or less."""
WHITE_SHARES = (0.0, 0.1, 0.2, 0.4, 0.6, 0.8)
FRAMES_AT_LEAST = 4
"""A shorter flight says hardly more than its own place and velocity."""
FREEDOM_AT_LEAST = 8
"""Fewer degrees of freedom know a standard deviation to no better than a quarter."""
SINGULAR = 1e-9
"""A shared column whose square is less than this, over its own before, is none of its own."""


@dataclass(frozen=True)
class Flight:
    """One flight of a body; n frames in which it was seen."""

    clock: Floats
    """Frame coordinates, shape (n,)."""
    own: Floats
    """What this flight's path is made of, with coefficients of its own, shape (n, p)."""
    shared: Floats
    """What the paths of all flights share, with the same coefficients, shape (n, q)."""
    place_px: Floats
    """Shape (n,)."""

    @property
    def freedom(self) -> int:
        """Degrees of freedom that its own coefficients leave."""
        return int(len(self.clock) - self.own.shape[1])


def flight_of(clock: Floats, position: Floats) -> Flight | None:
    """Describe a flight under an acceleration linear in time and place, the law of all flights.

    Parameters
    ----------
    clock
        Frame coordinates, shape (n,).
    position
        Places from an origin that all flights share, shape (n,); NaN where not seen.

    Returns
    -------
    Flight or None
        None where the body is hardly seen.
    """
    seen = np.isfinite(position)
    if seen.sum() < FRAMES_AT_LEAST:
        return None
    time = clock - clock[seen].mean()
    fallen = integral(time, integral(time, np.interp(clock, clock[seen], position[seen])))
    time, place = time[seen], position[seen] - position[seen].mean()
    own = np.column_stack([np.ones_like(time), time])
    return Flight(clock[seen], own, np.column_stack([time**2, fallen[seen]]), place)


def integral(time: Floats, values: Floats) -> Floats:
    """Integrate by the trapezoidal rule from the first value on, shape (n,)."""
    means = (values[1:] + values[:-1]) / 2
    return np.concatenate([[0.0], np.cumsum(means * np.diff(time))])


@dataclass(frozen=True)
class Errors:
    """How the errors of places vary together."""

    white_px2: float
    """Variance of what is new in every frame."""
    lasting_px2: Floats
    """Variance of what lasts, for each of ``LASTS_FRAMES``."""

    @property
    def sigma_px(self) -> float:
        """Standard deviation of one error."""
        return float(np.sqrt(self.white_px2 + self.lasting_px2.sum()))

    def covariance_of(self, clock: Floats) -> Floats:
        """Covariance of errors in px squared in frames of shape (n,), shape (n, n)."""
        apart = np.abs(clock[:, None] - clock)
        total = self.white_px2 * np.eye(len(clock))
        for lasts, variance in zip(LASTS_FRAMES, self.lasting_px2, strict=True):
            if variance > 0:
                total += variance * np.exp(-apart / lasts)
        return np.asarray(total)


def errors_of(flights: Sequence[Flight]) -> Errors | None:
    """Measure the errors of places about flights; None where these say too little."""
    freedom = sum(flight.freedom for flight in flights)
    if not flights or freedom - flights[0].shared.shape[1] < FREEDOM_AT_LEAST:
        return None
    lasts, white = _pairs()
    log_own, products = _reduced(flights, lasts, white)
    log_shared, squares, rank = _without_shared(products)
    freedom = freedom - rank
    squares = np.maximum(squares, np.finfo(np.float64).tiny)
    likelihood = -0.5 * (log_own + log_shared + freedom * np.log(squares))
    weight = np.exp(likelihood - likelihood.max())
    variance = weight / weight.sum() * squares / freedom
    lasting = [float(((1 - white) * variance)[lasts == each].sum()) for each in LASTS_FRAMES]
    return Errors(float(white @ variance), np.array(lasting))


def _pairs() -> tuple[Floats, Floats]:
    """List times and white shares to try, shape (pairs,) each; the last pair is all white."""
    lasts, white = (grid.ravel() for grid in np.meshgrid(LASTS_FRAMES, WHITE_SHARES))
    return np.append(lasts, LASTS_FRAMES[0]), np.append(white, 1.0)


def _reduced(flights: Sequence[Flight], lasts: Floats, white: Floats) -> tuple[Floats, Floats]:
    """Log determinants, and the products of shared columns and place without flights' own columns.

    Both are sums over the flights, shapes (pairs,) and (pairs, q + 1, q + 1).
    """
    products, log = _independent(flights, lasts, white)
    own = flights[0].own.shape[1]
    first, mixed = products[..., :own, :own], products[..., :own, own:]
    rest = products[..., own:, own:] - np.swapaxes(mixed, -1, -2) @ np.linalg.solve(first, mixed)
    return (log + np.linalg.slogdet(first)[1]).sum(axis=0), rest.sum(axis=0)


def _independent(flights: Sequence[Flight], lasts: Floats, white: Floats) -> tuple[Floats, Floats]:
    """Turn columns with correlated errors into such with independent ones of variance 1.

    Returns the products of these columns, shape (flights, pairs, columns, columns), and the log
    determinants of the correlation, shape (flights, pairs). Of all flights one row is taken at a
    time: the longest come first, so that those which have one are the first of them.
    """
    ordered = sorted(flights, key=lambda flight: -len(flight.clock))
    lengths = np.array([len(flight.clock) for flight in ordered])
    width = ordered[0].own.shape[1] + ordered[0].shared.shape[1] + 1
    columns = np.zeros((lengths[0], len(ordered), width))
    apart = np.zeros(columns.shape[:2])
    for number, flight in enumerate(ordered):
        rows = slice(len(flight.clock))
        columns[rows, number] = np.column_stack([flight.own, flight.shared, flight.place_px])
        apart[rows, number] = np.diff(flight.clock, prepend=flight.clock[0])
    lasting = 1.0 - white
    log = np.zeros((len(ordered), len(lasts)))
    variance = np.tile(lasting, (len(ordered), 1))
    expected = np.zeros((*log.shape, columns.shape[2]))
    products = np.zeros((*expected.shape, columns.shape[2]))
    for row, left in enumerate(np.searchsorted(-lengths, -np.arange(lengths[0]))):
        some = slice(int(left))
        keep = np.exp(-apart[row, some, None] / lasts)
        passed = keep**2 * variance[some] + (1 - keep**2) * lasting
        total = passed + white
        surprise = columns[row, some, None] - keep[..., None] * expected[some]
        gain = passed / total
        expected[some] = keep[..., None] * expected[some] + gain[..., None] * surprise
        variance[some] = passed * (1 - gain)
        log[some] += np.log(total)
        products[some] += surprise[..., None] * (surprise / total[..., None])[..., None, :]
    return products, log


def _without_shared(products: Floats) -> tuple[Floats, Floats, int]:
    """Take the shared columns out of the places, one after the other.

    Returns log determinants and remaining sums of squares, shape (pairs,), and how many columns
    were there to take.
    """
    before = np.einsum("cjj->cj", products).copy()
    log, rank = np.zeros(len(products)), 0
    for column in range(products.shape[1] - 1):
        square = products[:, column, column]
        if np.all(square > SINGULAR * before[:, column]) and np.all(square > 0):
            line = products[:, column, :]
            products = products - line[:, :, None] * line[:, None, :] / square[:, None, None]
            log, rank = log + np.log(square), rank + 1
    return log, products[:, -1, -1], rank


# ---- medians, and peaks between samples ----------------------------------------------------------


def weighted_median(values: Floats, weights: Floats) -> float:
    """Value below which half of the weight lies."""
    order = np.argsort(values)
    share = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(share, share[-1] / 2)])


def peak_of(values: Values, place: int) -> float:
    """Refine the place of a peak by the parabola through its highest sample and the neighbours.

    Parameters
    ----------
    values
        Shape (n,).
    place
        Index of the highest sample; at an end the peak is taken to be there.
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

"""Errors of places that last for some frames: restricted maximum likelihood."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise

import numpy as np

from count_video.records import Floats
from count_video.signals import integral

HALF_EXPOSURE = 0.5
"""Frames: the longest shutter is open for the whole frame, half of it before its centre."""
WINDOW_FRAMES = 48.0
"""Places this near to a contact say what there is to say about it. Flights are measured in pieces
of so many frames at most, beside which what lasts is short."""
ENOUGH_ROWS = 3000
"""So many rows give the standard deviation of errors to 1.5 %."""

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
# freedom. Pairs that fit alike are hard to distinguish, so the variance is the mean of theirs,
# weighted by likelihood.

LASTS_FRAMES = (2.0, 4.0, 8.0, 16.0)
"""What lasts longer than that the path takes up in most flights: the places say nothing of it."""
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
    log_own, products = zip(*(_reduced(flight, lasts, white) for flight in flights), strict=True)
    log_shared, squares, rank = _without_shared(np.sum(products, axis=0))
    freedom = freedom - rank
    squares = np.maximum(squares, np.finfo(np.float64).tiny)
    likelihood = -0.5 * (np.sum(log_own, axis=0) + log_shared + freedom * np.log(squares))
    weight = np.exp(likelihood - likelihood.max())
    variance = weight / weight.sum() * squares / freedom
    lasting = [float(((1 - white) * variance)[lasts == each].sum()) for each in LASTS_FRAMES]
    return Errors(float(white @ variance), np.array(lasting))


def _pairs() -> tuple[Floats, Floats]:
    """List times and white shares to try, shape (pairs,) each; the last pair is all white."""
    lasts, white = (grid.ravel() for grid in np.meshgrid(LASTS_FRAMES, WHITE_SHARES))
    return np.append(lasts, LASTS_FRAMES[0]), np.append(white, 1.0)


def _reduced(flight: Flight, lasts: Floats, white: Floats) -> tuple[Floats, Floats]:
    """Log determinants, and the products of shared columns and place without the flight's own.

    Shapes (pairs,) and (pairs, q + 1, q + 1).
    """
    apart = np.abs(flight.clock[:, None] - flight.clock)
    lasting = (1.0 - white)[:, None, None] * np.exp(-apart / lasts[:, None, None])
    covariance = lasting + white[:, None, None] * np.eye(len(apart))
    columns = np.column_stack([flight.own, flight.shared, flight.place_px])
    products = columns.T @ np.linalg.solve(covariance, columns)
    own = flight.own.shape[1]
    first, mixed = products[..., :own, :own], products[..., :own, own:]
    rest = products[..., own:, own:] - np.swapaxes(mixed, -1, -2) @ np.linalg.solve(first, mixed)
    return np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(first)[1], rest


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


def errors_about(
    frame: Floats, signal: Floats, contacts: Sequence[float], touching: float
) -> Errors | None:
    """Measure the errors of a body's places about its flights next to some contacts.

    Hands and rest, before the first one and after the last, are no flights: only what lies between
    is one, if that says enough.

    Parameters
    ----------
    frame, signal
        Shape (n,); NaN where not seen.
    contacts
        Frame coordinates of its contacts, increasing.
    touching
        Frames on either side of a contact that may show it.
    """
    if not contacts or not np.isfinite(signal).any():
        return None
    middle, flights = np.nanmean(signal), []
    for low, high in pairwise([-np.inf, *contacts, np.inf]):
        first = high - WINDOW_FRAMES if np.isinf(low) else low
        last = low + WINDOW_FRAMES if np.isinf(high) else high
        ends = max(first, frame[0]) + touching, min(last, frame[-1]) - touching
        pieces = np.linspace(*ends, 1 + max(1, int(np.ceil((ends[1] - ends[0]) / WINDOW_FRAMES))))
        inner = [(frame > since) & (frame <= until) for since, until in pairwise(pieces)]
        flights.append([flight_of(frame[rows], signal[rows] - middle) for rows in inner])
    return errors_of(_enough(chain(*flights[1:-1]))) or errors_of(_enough(chain(*flights)))


def _enough(flights: Iterable[Flight | None]) -> list[Flight]:
    """Flights that say something, of very many rows only every so many of them."""
    shown = [flight for flight in flights if flight]
    rows = sum(len(flight.clock) for flight in shown)
    return shown[:: max(1, rows // ENOUGH_ROWS)]

r"""Flights between contacts, cut into pieces that a fit can take.

Between contacts a body at x obeys x'' = g - w^2 (x - x0). Of a flight that is short, both ends give
of each other: one piece from contact to contact. Of a long one each end has a piece of its own, for
what a hand, a slope or a lens does in the middle of it says nothing of its ends.

What the term -w^2 x adds to the path follows from the places as they were measured, for noise
hardly counts in a double integral. So the fit stays linear in w^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.signals import Errors, Flight, errors_of, flight_of, integral, sigma_of

HALF_EXPOSURE = 0.5
"""Frames: the longest shutter is open for the whole frame, half of it before its centre."""
WINDOW_FRAMES = 24.0
"""A piece with one contact reaches this far: motion further away says little about it, ..."""
WINDOW_AT_MOST_FRAMES = 192.0
"""... or farther, to this limit, ..."""
WAY_SIGMAS = 60.0
"""... until the body has covered so many standard deviations of a mean over 24 places."""

ENOUGH_ROWS = 3000
"""So many rows give the standard deviation of errors to 1.5 %."""

Rows = NDArray[np.intp]
Stop = tuple[int, float]
"""Number and frame coordinate of a contact."""


@dataclass(frozen=True)
class Piece:
    """Rows of a flight next to one contact, or between two; n rows."""

    body: int
    """0 for the ball, 1 for the heavy body."""
    rows: Rows
    """Of the track, shape (n,)."""
    frame: Floats
    """Their frame coordinates, shape (n,)."""
    place_px: Floats
    """Measured places, shape (n,)."""
    before: int | None
    """Contact at its beginning; None where no contact is, or one that is too far away."""
    after: int | None
    """Contact at its end; the same."""
    swung: Floats
    """What -w^2 x adds to the path, over w^2; 0 at the contacts, shape (n,)."""
    swung_rate: Floats
    """Its slopes, shape (n,)."""
    end_rates: tuple[float, float]
    """Its slopes at the contacts: 0 where there is only one."""

    @property
    def anchor(self) -> int:
        """The contact that it begins at, or else the one that it ends at."""
        return self.ends[0]

    @property
    def ends(self) -> tuple[int, int]:
        """The contacts at both ends, or twice the only one."""
        known = [contact for contact in (self.before, self.after) if contact is not None]
        return known[0], known[-1]

    @property
    def spans(self) -> bool:
        """Whether it goes from one contact to the next."""
        return self.before is not None and self.after is not None


def pieces_of(
    frame: Floats,
    signal: Floats,
    body: int,
    contacts: Sequence[Stop],
    touching: float = HALF_EXPOSURE,
) -> list[Piece]:
    """Cut the flights of one body.

    Parameters
    ----------
    frame, signal
        Shape (n,); NaN where not seen.
    body
        Number of the body.
    contacts
        Its contacts, in order of time.
    touching
        Frames on either side of a contact that may show it.
    """
    seen, sigma = np.isfinite(signal), sigma_of(signal)
    found: list[Piece | None] = []
    for before, after in pairwise([None, *contacts, None]):
        low = -np.inf if before is None else before[1] + touching
        high = np.inf if after is None else after[1] - touching
        rows = np.flatnonzero(seen & (frame > low) & (frame < high))
        near = [
            np.empty(0, np.intp) if stop is None else _near(frame, signal, rows, stop[1], sigma)
            for stop in (before, after)
        ]
        meet = min(map(len, near)) > 0 and near[0][-1] >= near[1][0]
        if before and after and meet:
            found.append(_piece(frame, signal, (body, rows), (before, after)))
        else:
            found.append(_piece(frame, signal, (body, near[0]), (before, None)))
            found.append(_piece(frame, signal, (body, near[1]), (None, after)))
    return [piece for piece in found if piece is not None]


def _near(frame: Floats, signal: Floats, rows: Rows, contact: float, sigma: float) -> Rows:
    """Rows of a flight that know of a contact at one of its ends."""
    window = WINDOW_FRAMES
    while True:
        near = rows[np.abs(frame[rows] - contact) < window]
        if window >= WINDOW_AT_MOST_FRAMES or len(near) == len(rows):
            return near
        needed = WAY_SIGMAS * sigma * np.sqrt(WINDOW_FRAMES / max(len(near), 1))
        if len(near) and np.ptp(signal[near]) > needed:
            return near
        window *= 2


def _piece(
    frame: Floats,
    signal: Floats,
    which: tuple[int, Rows],
    stops: tuple[Stop | None, Stop | None],
) -> Piece | None:
    body, rows = which
    if len(rows) == 0 or stops == (None, None):
        return None
    before, after = ([] if stop is None else [stop[1]] for stop in stops)
    first, last = (None if stop is None else stop[0] for stop in stops)
    frame, place = frame[rows], signal[rows]
    return Piece(body, rows, frame, place, first, last, *_swung(frame, place, before, after))


def _swung(
    frame: Floats, place: Floats, before: list[float], after: list[float]
) -> tuple[Floats, Floats, tuple[float, float]]:
    """Twice integrate minus the places, from 0 at the contacts; also the slopes, all and there."""
    grid = np.concatenate([before, frame, after])
    rows = slice(len(before), len(before) + len(frame))
    once = -integral(grid, np.interp(grid, frame, place) - place.mean())
    twice = integral(grid, once)
    at, both = 0 if before else -1, before and after
    slope = (twice[-1] - twice[0]) / (grid[-1] - grid[0]) if both else once[at]
    once, twice = once - slope, twice - twice[at] - slope * (grid - grid[at])
    end_rates = (float(once[0]), float(once[-1])) if both else (0.0, 0.0)
    return twice[rows], once[rows], end_rates


def errors_about(
    frame: Floats, signal: Floats, contacts: Sequence[float], touching: float, *, inside: bool
) -> Errors | None:
    """Measure the errors of a body's places about its flights next to the contacts.

    With ``inside``, those between the contacts only, if they say enough. The arguments are those of
    :func:`pieces_of`; of the contacts, their frame coordinates.
    """
    if not np.isfinite(signal).any():
        return None
    middle, flights = np.nanmean(signal), []
    for low, high in pairwise([-np.inf, *contacts, np.inf]):
        first = high - 2 * WINDOW_FRAMES if np.isinf(low) else low
        last = low + 2 * WINDOW_FRAMES if np.isinf(high) else high
        rows = (frame > first + touching) & (frame < last - touching)
        flights.append(flight_of(frame[rows], signal[rows] - middle))
    errors = errors_of(_enough(flights[1:-1])) if inside else None
    return errors or errors_of(_enough(flights))


def _enough(flights: Sequence[Flight | None]) -> list[Flight]:
    """Flights that say something, of very many rows only every so many of them."""
    shown = [flight for flight in flights if flight]
    rows = sum(len(flight.clock) for flight in shown)
    return shown[:: max(1, rows // ENOUGH_ROWS)]

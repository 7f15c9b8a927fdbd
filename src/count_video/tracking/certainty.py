"""Stated uncertainties that hold: judged by how smooth the tracks are, not by the pictures alone.

The registration takes the noise of a picture for white. Encoders leave errors that neighbouring
pixels share and that last for many frames: whole blocks are moved by quarters of a pixel, or stay
where they were until it is worth the bits to move them. Such an error looks like motion in every
single picture, so its uncertainties come out too small by factors of two to ten. The tracks tell:
between two collisions a body follows a smooth path, and what strays from it is no motion.

    place
     |        x x               Flights reach from one turning point of either body, or of the gap
     |     x        .           between them, to the next. Each has a place and a velocity of its
     |   x             x        own; the law of the acceleration, linear in time and place, is the
     |  .                x      same in all: that of a pendulum, a slope, a throw. What so stiff a
     +--------------------->    path leaves over holds most of the errors, the lasting ones too.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from count_video.records import Floats
from count_video.signals import Flight, errors_of, flight_of, low_points, sigma_of

TURN_SIGMAS = 6.0
TURNS_AWAY = 2
"""Frames at a turning point that take no part: their exposure may hold it."""
MOVED_AT_LEAST_PX = 1.0
"""A body at rest has the same error all the time, and an encoder may show the same picture of it:
that tells little of its errors, so long rests are cut."""
FREEDOM_TO_JUDGE = 4
STRAYS = 25.0
"""A flight with so many times the variance of the calmest quarter holds a collision without a turn;
errors of an encoder come in bursts, and chance alone makes five times."""

Span = tuple[int, int]
"""First row, and row to stop before."""


def stated_sigmas(
    frame: Floats, positions_px: Sequence[Floats], sigmas_px: Sequence[Floats]
) -> list[Floats]:
    """Enlarge the uncertainties of two bodies that meet until they cover how their tracks scatter.

    Parameters
    ----------
    frame
        Frame coordinates, shape (n,).
    positions_px, sigmas_px
        For each body, shape (n,): places and their standard uncertainties by the registration, in
        px; NaN where not seen. The body on the left comes first.

    Returns
    -------
    list of Floats
        Shape (n,) each: to the variance of every place of a body the same is added, never less
        than nothing. Errors that last longer than a flight, or hang on the place itself, cannot be
        told from motion and are not covered.
    """
    spans = _spans(positions_px)
    return [
        _enlarged(frame, position, sigma, spans)
        for position, sigma in zip(positions_px, sigmas_px, strict=True)
    ]


def _enlarged(frame: Floats, position: Floats, sigma: Floats, spans: Sequence[Span]) -> Floats:
    known = np.isfinite(sigma)
    if not np.any(sigma[known] > 0) or not np.isfinite(position).any():
        return sigma
    # Where copies were put in, pictures are even and frames are not, or the other way round: the
    # right clock makes the smoother path.
    rows = np.arange(len(frame), dtype=np.float64)
    clocks = [frame] if np.array_equal(frame - frame[0], rows) else [frame, rows]
    position = position - np.nanmean(position)
    found = [errors_of(_flights(clock, position, spans)) for clock in clocks]
    known_px2 = float(np.mean(sigma[known] ** 2))
    hidden = min((errors.sigma_px**2 for errors in found if errors), default=0.0) - known_px2
    return np.asarray(np.sqrt(sigma**2 + hidden), dtype=np.float64) if hidden > 0 else sigma


def _spans(positions: Sequence[Floats]) -> list[Span]:
    """Rows between turning points of any body or of the gap, clear of these."""
    left, right = positions
    turns = [-TURNS_AWAY, len(left) + TURNS_AWAY - 1]
    for signal in (left, -left, right, -right, right - left):
        turns += low_points(signal, TURN_SIGMAS * sigma_of(signal)).tolist()
    spans = [(turn + TURNS_AWAY, after - TURNS_AWAY + 1) for turn, after in pairwise(sorted(turns))]
    return [(start, stop) for start, stop in spans if start < stop]


def _flights(clock: Floats, position: Floats, spans: Sequence[Span]) -> list[Flight]:
    """Flights that tell of errors, as far as simple paths can judge it."""
    found = [flight_of(clock[slice(*span)], position[slice(*span)]) for span in spans]
    flights = _short_rests([flight for flight in found if flight is not None])
    variances = np.array([_variance(flight) for flight in flights])
    known = np.isfinite(variances)
    if not known.any():
        return []
    # A body at rest tells little of the errors of one that moves.
    moves = known & [_moves(flight) for flight in flights]
    judges = variances[moves if moves.any() else known]
    strays = variances > STRAYS * np.quantile(judges, 0.25, method="lower")
    return [flight for flight, out in zip(flights, strays, strict=True) if not out]


def _short_rests(flights: Sequence[Flight]) -> list[Flight]:
    """Let no body rest for longer than its longest flight; something may hold it then."""
    moves = [_moves(flight) for flight in flights]
    longest = max(
        (len(flight.clock) for flight, go in zip(flights, moves, strict=True) if go), default=0
    )
    return [
        flight
        if go
        else Flight(
            flight.clock[:longest],
            flight.own[:longest],
            0.0 * flight.shared[:longest],
            flight.place_px[:longest],
        )
        for flight, go in zip(flights, moves, strict=True)
        if longest > 0
    ]


def _moves(flight: Flight) -> bool:
    return bool(np.ptp(flight.place_px) >= MOVED_AT_LEAST_PX)


def _variance(flight: Flight) -> float:
    """Variance about a path with a law of its own; NaN for a flight too short to tell."""
    design = np.column_stack([flight.own, flight.shared])
    freedom = int(len(design) - design.shape[1])
    if freedom < FREEDOM_TO_JUDGE:
        return float("nan")
    solution, *_ = np.linalg.lstsq(design, flight.place_px, rcond=None)
    left_over = flight.place_px - design @ solution
    return float(left_over @ left_over) / freedom

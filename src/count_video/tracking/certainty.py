"""Stated uncertainties that hold: judged by how smooth the tracks are, not by the pictures alone.

The registration takes the noise of a picture for white. Encoders leave errors that neighbouring
pixels share and that last for many frames: whole blocks are moved by quarters of a pixel, or stay
where they were until it is worth the bits to move them. Such an error looks like motion in every
single picture, so its uncertainties come out too small by factors of two to six. The tracks tell:
between two collisions a body follows a smooth path, and what strays from it is no motion.

    place
     |        x x               Each flight, from one turning point of any of the bodies to the
     |     x        .           next, is cut into pieces; a polynomial is fitted to each. The
     |   x     ^      x         longer the pieces, the more of what lasts is seen: the scatter
     |  .    piece      x       about the fits grows, slowly, until it is all there. Where a piece
     +--------------------->    is so long that the motion itself does not fit, it grows at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from count_video.records import Floats
from count_video.signals import low_points, sigma_of

TURN_SIGMAS = 6.0
PIECES = ((12, 2), (18, 2), (27, 3), (40, 3), (60, 3), (90, 3))
"""Frames that a piece has at most, and the degree of its polynomial. A free flight bends by gravity
and threads, and the longer it is the less is its bend the same throughout."""
GROWTH_AT_MOST = 1.4
"""From one length of the pieces to the next the scatter of errors that wander at random grows by
sqrt(1.5) = 1.22, give or take what a few pieces do not know. What grows faster is motion."""
CLEARLY = 1.35
"""The scatter is known to a quarter by a few pieces, and the largest of several is taken: less than
this beyond the stated uncertainty is no sign of anything but white noise."""
PIECES_AT_LEAST = 4
TURNS_AWAY = 2
"""Frames at a turning point that take no part: their exposure may hold it."""
MOVED_AT_LEAST_PX = 1.0
"""A body at rest has the same error all the time: nothing of it shows."""
STRAYS = 25.0
"""A piece with so many times the variance of the calmest quarter holds a collision without a turn;
errors of an encoder come in bursts, and chance alone makes five times."""

Span = tuple[int, int]
"""First row, and row to stop before."""


def stated_sigmas(positions_px: Sequence[Floats], sigmas_px: Sequence[Floats]) -> list[Floats]:
    """Enlarge the uncertainties of bodies that meet until they cover how their tracks scatter.

    Parameters
    ----------
    positions_px, sigmas_px
        For each body, shape (n,): places and their standard uncertainties by the registration, in
        px; NaN where not seen.

    Returns
    -------
    list of Floats
        Shape (n,) each, all of a body enlarged by one factor, never smaller than it was. Errors
        that last longer than a flight cannot be told from motion and are not covered.
    """
    flights = _flights(positions_px)
    return [
        _enlarged(position, sigma, flights)
        for position, sigma in zip(positions_px, sigmas_px, strict=True)
    ]


def _enlarged(position: Floats, sigma: Floats, flights: Sequence[Span]) -> Floats:
    seen = sigma[np.isfinite(sigma)]
    typical = float(np.median(seen)) if len(seen) else 0.0
    if typical == 0.0:
        return sigma
    factor = _scatter(position, flights) / typical
    return sigma * factor if factor > CLEARLY else sigma


def _flights(positions: Sequence[Floats]) -> list[Span]:
    """Rows between turning points of any body, clear of these."""
    turns = [-TURNS_AWAY, len(positions[0]) + TURNS_AWAY - 1]
    for position in positions:
        depth = TURN_SIGMAS * sigma_of(position)
        turns += [*low_points(position, depth).tolist(), *low_points(-position, depth).tolist()]
    spans = [(turn + TURNS_AWAY, after - TURNS_AWAY + 1) for turn, after in pairwise(sorted(turns))]
    return [(start, stop) for start, stop in spans if start < stop]


def _scatter(position: Floats, flights: Sequence[Span]) -> float:
    """Measure the standard deviation about smooth flights; 0 where nothing tells it."""
    scatter = 0.0
    for most, degree in PIECES:
        longer = _scatter_about(position, _pieces(flights, most, degree), degree)
        if np.isnan(longer) or (scatter and longer > GROWTH_AT_MOST * scatter):
            break
        scatter = max(scatter, longer)
    return scatter


def _pieces(flights: Sequence[Span], most: int, degree: int) -> list[Span]:
    """Cut flights into equal pieces of at most so many rows; too short ones are left out."""
    pieces: list[Span] = []
    for start, stop in flights:
        count = -(-(stop - start) // most)
        cuts = [start + (stop - start) * place // count for place in range(count + 1)]
        pieces += pairwise(cuts)
    return [piece for piece in pieces if piece[1] - piece[0] >= degree + 4]


def _scatter_about(position: Floats, pieces: Sequence[Span], degree: int) -> float:
    """Measure the standard deviation about fits to pieces with motion; NaN for too few."""
    variances, freedoms = [], []
    for start, stop in pieces:
        places = position[start:stop]
        if np.isfinite(places).all() and np.ptp(places) >= MOVED_AT_LEAST_PX:
            basis = _basis(stop - start, degree)
            left_over = places - basis @ (basis.T @ places)
            freedoms.append(stop - start - degree - 1)
            variances.append(float(left_over @ left_over) / freedoms[-1])
    if len(variances) < PIECES_AT_LEAST:
        return float("nan")
    variance, freedom = np.array(variances), np.array(freedoms)
    usual = variance <= STRAYS * np.quantile(variance, 0.25)
    return float(np.sqrt(np.average(variance[usual], weights=freedom[usual])))


@lru_cache(maxsize=256)
def _basis(rows: int, degree: int) -> Floats:
    """Orthonormal basis of the polynomials over so many rows, shape (rows, degree + 1)."""
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1, 1, rows), degree + 1))
    return np.asarray(basis, dtype=np.float64)

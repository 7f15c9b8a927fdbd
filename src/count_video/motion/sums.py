"""Sums over the rows of pieces: the normal equations of a fit, and the covariance of its gradient.

Each row's place depends on few columns, those that the slots of its piece list. Rows are summed
piece by piece, and then put where the columns are, so a long clip takes no matrix of all its rows.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from count_video.motion.pieces import Rows
from count_video.records import Floats
from count_video.signals import FORGOTTEN_FRAMES, LASTS_FRAMES, Errors


@dataclass(frozen=True)
class Sums:
    """Rows of pieces, one piece after the other, n in all; derivatives have shape (n, slots)."""

    columns: int
    slots: Rows
    """Columns of each piece, shape (pieces, slots); one after the last for slots without use."""
    frame: Floats
    """Frame coordinates of the rows, shape (n,)."""
    rows: Rows
    """How many rows each piece has, shape (pieces,)."""

    @cached_property
    def starts(self) -> Rows:
        """Row at which each piece begins, shape (pieces,)."""
        return np.asarray(np.cumsum(self.rows) - self.rows)

    def products(self, left: Floats, right: Floats) -> Floats:
        """Sum products of derivatives over the rows, shape (columns, columns)."""
        size = self.columns + 1
        if not len(self.rows):
            return np.zeros((self.columns, self.columns))
        sums = np.add.reduceat(left[:, :, None] * right[:, None, :], self.starts)
        places = self.slots[:, :, None] * size + self.slots[:, None, :]
        flat = np.bincount(places.ravel(), sums.ravel(), minlength=size * size)
        return np.asarray(flat.reshape(size, size)[:-1, :-1])

    def weighted(self, jacobian: Floats, weights: Floats) -> Floats:
        """Sum derivatives with weights over the rows, shape (columns,)."""
        if not len(self.rows):
            return np.zeros(self.columns)
        sums = np.add.reduceat(jacobian * weights[:, None], self.starts)
        flat = np.bincount(self.slots.ravel(), sums.ravel(), minlength=self.columns + 1)
        return np.asarray(flat[:-1])

    def covariance(
        self, jacobian: Floats, pieces: Rows, errors: Errors | None, sigma: float
    ) -> Floats:
        """Covariance of the sums of some pieces' derivatives times errors, shape (columns,) twice.

        What lasts of the errors is exp(-(t - s) / T) from a row of one piece at s to one of a later
        piece at t: a factor of each row and one of the gap between the pieces. Derivatives are
        those of residuals over ``sigma``; unknown errors are independent, and as large as that.
        """
        total = np.zeros((self.columns + 1, self.columns + 1))
        for piece in pieces.tolist():
            rows = slice(self.starts[piece], self.starts[piece] + self.rows[piece])
            own = jacobian[rows]
            if errors is not None:
                own = errors.covariance_of(self.frame[rows]) @ own / sigma**2
            slots = self.slots[piece]
            np.add.at(total, (slots[:, None], slots), jacobian[rows].T @ own)
        if errors is not None and len(pieces) > 1:
            between = np.zeros_like(total)
            for first, last, products in self._between(jacobian, pieces, errors):
                np.add.at(between, (first[:, :, None], last[:, None, :]), products)
            total += (between + between.T) / sigma**2
        return total[:-1, :-1]

    def _between(
        self, jacobian: Floats, pieces: Rows, errors: Errors
    ) -> Iterator[tuple[Rows, Rows, Floats]]:
        """Yield the covariance of derivatives of pieces with those of others after them.

        Each is that of some pairs: the slots of both, shape (pairs, slots), and the products, shape
        (pairs, slots, slots).
        """
        start, stop = self.frame[self.starts], self.frame[self.starts + self.rows - 1]
        lasts = np.array(LASTS_FRAMES)
        ahead, behind = (np.repeat(ends, self.rows) - self.frame for ends in (start, stop))
        since, until = (
            np.stack(
                [np.add.reduceat(jacobian * np.exp(gap / t)[:, None], self.starts) for t in lasts],
                axis=1,
            )[pieces]
            for gap in (ahead, -behind)
        )
        start, stop, slots = start[pieces], stop[pieces], self.slots[pieces]
        for offset in range(1, len(pieces)):
            gap = start[offset:] - stop[:-offset]
            near = np.flatnonzero(gap < FORGOTTEN_FRAMES)
            if len(near) == 0:
                return
            kept = errors.lasting_px2 * np.exp(-gap[near, None] / lasts)
            left = until[near] * kept[:, :, None]
            yield slots[near], slots[near + offset], np.swapaxes(left, 1, 2) @ since[near + offset]

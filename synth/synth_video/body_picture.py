"""Pictures of moving bodies, placed by exact area coverage.

A body is painted once on *cells*, ``n`` to a pixel in each direction. A pixel shows the mean of the
cells that lie under it. When the body is shifted by a fraction of a cell, that mean is linear in
the shift between one cell boundary and the next, so interpolating between the ``n`` x ``n``
*phases* (means for shifts of whole cells) is not an approximation: it is the exact area coverage
at any shift. A path during an exposure is a set of shifts; its mean picture is the same sum with
the weights of all shifts gathered first, so a long exposure costs one term a cell of travel.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from synth_video.pixels import Pixels, as_pixels


@dataclass(frozen=True)
class Placed:
    """A part of a body's picture at its place in a frame."""

    x_px: int
    y_px: int
    """Pixel of the picture's upper left corner; may lie outside the frame."""
    pixels: Pixels
    """Shape (h, w, channels)."""


@dataclass
class BodyPicture:
    """A body's picture on cells, and its phases as they are asked for."""

    cells: Pixels
    """Shape (h * n, w * n, channels); colour is premultiplied by coverage."""
    cells_per_px: int
    anchor_x_px: float
    anchor_y_px: float
    """The body's reference point, in px from the corner of the first cell."""
    _phases: dict[tuple[int, int], Pixels] = field(default_factory=dict)

    def at(self, time_s: float) -> BodyPicture:
        """Return itself: this appearance does not change with time."""
        return self

    def placed(self, x_px: Floats, y_px: Floats) -> Placed:
        """Mean picture while the reference point passes the image points given, shape (m,) each."""
        n = self.cells_per_px
        # Pixel p covers p - 1/2 to p + 1/2, hence the half; then shifts are counted in cells.
        rows, row_weights = _neighbours((y_px - self.anchor_y_px + 0.5) * n)
        columns, column_weights = _neighbours((x_px - self.anchor_x_px + 0.5) * n)
        weights = _gather(rows, row_weights, columns, column_weights)
        top, left = int(rows.min()), int(columns.min())
        y_first, x_first = top // n, left // n
        height, width, channels = self._phase(0, 0).shape
        y_last, x_last = (int(rows.max()) + 1) // n, (int(columns.max()) + 1) // n
        mean = np.zeros(
            (height + y_last - y_first, width + x_last - x_first, channels), dtype=np.float32
        )
        for i, j in np.argwhere(weights > 0):
            y_whole, y_phase = divmod(top + int(i), n)
            x_whole, x_phase = divmod(left + int(j), n)
            y, x = y_whole - y_first, x_whole - x_first
            part = mean[y : y + height, x : x + width]
            cv2.scaleAdd(self._phase(y_phase, x_phase), float(weights[i, j]), part, dst=part)
        return Placed(x_first, y_first, mean)

    def _phase(self, y_phase: int, x_phase: int) -> Pixels:
        """Pixel means when the cells are shifted by whole cells down and right, 0 to n - 1."""
        key = (y_phase, x_phase)
        if key not in self._phases:
            n = self.cells_per_px
            height, width, _ = self.cells.shape
            padded = cv2.copyMakeBorder(
                self.cells,
                *(y_phase, n - y_phase, x_phase, n - x_phase),
                borderType=cv2.BORDER_CONSTANT,
            )
            # Shrinking by a whole factor, OpenCV's area method is the plain mean of the cells.
            size = (width // n + 1, height // n + 1)
            phase = cv2.resize(padded, size, interpolation=cv2.INTER_AREA)
            self._phases[key] = as_pixels(phase)
        return self._phases[key]


def _neighbours(shift_cells: Floats) -> tuple[NDArray[np.int64], Floats]:
    """Whole shifts next below each shift, and the weight of the one above."""
    below = np.floor(shift_cells)
    return below.astype(np.int64), shift_cells - below


def _gather(
    rows: NDArray[np.int64], row_weights: Floats, columns: NDArray[np.int64], column_weights: Floats
) -> Floats:
    """Sum the four bilinear weights of every shift on the lattice of whole shifts; total 1."""
    i, j = rows - rows.min(), columns - columns.min()
    lattice = np.zeros((int(i.max()) + 2, int(j.max()) + 2))
    for di, wi in ((0, 1 - row_weights), (1, row_weights)):
        for dj, wj in ((0, 1 - column_weights), (1, column_weights)):
            np.add.at(lattice, (i + di, j + dj), wi * wj / len(rows))
    return lattice

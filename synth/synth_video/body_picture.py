"""Pictures of moving bodies: the cells they are painted on, and their placing by area coverage."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from count_video.errors import UsageError
from count_video.records import Floats

Pixels = NDArray[np.float32]


def as_pixels(values: ArrayLike) -> Pixels:
    """Return the values as ``Pixels``, without a copy where they are that already."""
    return np.asarray(values, dtype=np.float32)


# ---- placing -------------------------------------------------------------------------------------
# Pictures of moving bodies, placed by exact area coverage.
#
# A body is painted once on *cells*, ``n`` to a pixel in each direction. A pixel shows the mean of
# the cells that lie under it. When the body is shifted by a fraction of a cell, that mean is linear
# in the shift between one cell boundary and the next, so interpolating between the ``n`` x ``n``
# *phases* (means for shifts of whole cells) is not an approximation: it is the exact area coverage
# at any shift. A path during an exposure is a set of shifts; its mean picture is the same sum with
# the weights of all shifts gathered first, so a long exposure costs one term a cell of travel.


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


# ---- cells ---------------------------------------------------------------------------------------
# The cells on which a body is painted, in the body's own coordinates.

CELLS_PER_PX = ((260.0, 8), (700.0, 4), (1400.0, 2))
"""Cells to a px for bodies up to this many px long. The cells of large bodies are coarser to keep
their phases within memory; edges stay exact, as cells on an edge carry its coverage."""


@dataclass(frozen=True)
class BodyCanvas:
    """Cells around a body's reference point with the body's coordinates of each cell's centre."""

    along_px: Floats
    """Coordinate along the line of motion, growing away from the wall, shape (h, w)."""
    down_px: Floats
    """Coordinate across the line, growing downward, shape (h, w)."""
    anchor_x_px: float
    anchor_y_px: float
    """Reference point in px from the corner of the first cell."""
    cells_per_px: int

    def coverage(self, outside_px: Floats) -> Floats:
        """Covered part of each cell, given the distance of its centre outside the outline."""
        return np.clip(0.5 - outside_px * self.cells_per_px, 0.0, 1.0)

    def finish(self, layers: list[Floats], blur_px: float) -> BodyPicture:
        """Blur the layers by the lens and make them a picture."""
        cells = as_pixels(np.stack(layers, axis=-1))
        return BodyPicture(
            _blurred(cells, blur_px * self.cells_per_px),
            self.cells_per_px,
            self.anchor_x_px,
            self.anchor_y_px,
        )


def body_canvas(
    along_px: tuple[float, float],
    down_px: tuple[float, float],
    tilt_deg: float,
    blur_px: float = 0.0,
    cells_per_px: int | None = None,
) -> BodyCanvas:
    """Lay out cells for a body that reaches over the given intervals about its reference point.

    Raises
    ------
    UsageError
        If the body is too large to be painted.
    """
    n = cells_per_px or _fitting_cells(max(along_px[1] - along_px[0], down_px[1] - down_px[0]))
    cosine, sine = np.cos(np.radians(tilt_deg)), np.sin(np.radians(tilt_deg))
    corners = np.array([(a, d) for a in along_px for d in down_px])
    x = corners[:, 0] * cosine - corners[:, 1] * sine
    y = corners[:, 0] * sine + corners[:, 1] * cosine
    margin = 4 * blur_px + 1
    left, top = np.floor(x.min() - margin), np.floor(y.min() - margin)
    width = int(np.ceil(x.max() + margin) - left) * n
    height = int(np.ceil(y.max() + margin) - top) * n
    dx = (np.arange(width) + 0.5) / n + left
    dy = ((np.arange(height) + 0.5) / n + top)[:, None]
    return BodyCanvas(
        dx * cosine + dy * sine, dy * cosine - dx * sine, -float(left), -float(top), n
    )


def _fitting_cells(size_px: float) -> int:
    """Cells to a px for a body of this size."""
    for limit_px, cells in CELLS_PER_PX:
        if size_px <= limit_px:
            return cells
    raise UsageError(
        f"a body would be {size_px:.0f} px long, more than {CELLS_PER_PX[-1][0]:.0f}; "
        "raise view.width_m or lower camera.width_px"
    )


def _blurred(cells: Pixels, sigma_cells: float) -> Pixels:
    """Gaussian blur; a symmetric kernel moves no edge."""
    if sigma_cells <= 0:
        return cells
    layers = cv2.split(cells)
    outside = cv2.BORDER_CONSTANT
    blurred = [cv2.GaussianBlur(c, (0, 0), sigma_cells, borderType=outside) for c in layers]
    return np.stack([as_pixels(c) for c in blurred], axis=-1)


def printed(text: str, height_px: float, cells_per_px: int) -> NDArray[np.float64]:
    """Coverage of a line of print, on cells, cropped to the letters."""
    scale = height_px * cells_per_px / 22.0  # a capital of this face is 22 px high at scale 1
    thickness = max(1, round(scale * 2.4))
    (width, rise), drop = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, thickness)
    page = np.zeros((rise + drop + 2 * thickness, width + 2 * thickness), dtype=np.uint8)
    origin = (thickness, rise + thickness)
    cv2.putText(page, text, origin, cv2.FONT_HERSHEY_SIMPLEX, scale, 255, thickness, cv2.LINE_AA)
    return page / 255.0

"""The cells on which a body is painted, in the body's own coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.records import Floats
from synth_video.body_picture import BodyPicture
from synth_video.pixels import Pixels, as_pixels

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

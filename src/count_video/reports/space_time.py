"""The space-time image: the line of motion, cut out of every frame and laid row upon row."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, MotionLine

Luma = NDArray[np.uint8]
HALF_WIDTH_DIAMETERS = 0.1
"""The line is averaged this far to either side, in ball diameters: noise goes, edges stay."""


@dataclass(frozen=True)
class SpaceTime:
    """The rows of all frames."""

    frame: Floats
    """Frame coordinates of the rows, shape (n,)."""
    image: Luma
    """Brightness, shape (n, length): row by frame, column by position along the line in px."""


class SpaceTimeSampler:
    """Takes the rows while the frames stream by."""

    def __init__(self, line: MotionLine, ball_diameter_px: float, shape: tuple[int, int]) -> None:
        """``shape`` is that of the pictures: (height, width)."""
        self._upright = line.upright
        across, along = shape[::-1] if line.upright else shape
        anchor = (line.anchor_x_px, line.anchor_y_px)
        anchor_along, anchor_across = anchor[::-1] if line.upright else anchor
        place = np.arange(along)
        slope = np.tan(np.radians(line.tilt_deg))
        middle = np.rint(anchor_across + slope * (place - anchor_along)).astype(np.intp)
        half = max(1, round(HALF_WIDTH_DIAMETERS * ball_diameter_px))
        aside = np.arange(-half, half + 1)
        self._across = middle + aside[:, None]
        self._along = np.broadcast_to(place, self._across.shape)
        self._size = (across, along)

    def row(self, luma: Luma, shift: tuple[float, float]) -> Luma:
        """Brightness along the line of one picture that lies shifted by x and y, shape (length,).

        Beyond the picture's border its last pixel goes on.
        """
        picture = luma.T if self._upright else luma
        along, across = shift[::-1] if self._upright else shift
        rows = np.clip(self._across + round(across), 0, self._size[0] - 1)
        columns = np.clip(self._along + round(along), 0, self._size[1] - 1)
        row: Luma = np.rint(picture[rows, columns].mean(axis=0)).astype(np.uint8)
        return row

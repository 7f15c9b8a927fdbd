"""From the flat picture to the light on the sensor: through the lens, moved by the tripod.

The flat picture is composed with a margin, so that what moves or bends into the picture is there.
Shifts by parts of a pixel are taken with a windowed sinc, which moves a picture that the lens has
blurred without softening it further.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from count_video.records import Floats
from synth_video.pixels import Pixels, as_pixels
from synth_video.projection import Projection

TAPS = 4
"""The windowed sinc reaches so many px to each side."""


@dataclass(frozen=True)
class Optics:
    """What lies between the composed picture and the sensor; coordinates are tilted ones."""

    composed: Projection
    """Projection of the picture to compose: that of the clip with a margin around it."""
    margin_px: int
    shift_px: Floats
    """Shift of the picture in each frame, shape (n, 2)."""
    bend: tuple[Pixels, Pixels] | None
    """Column and row of the composed picture that each pixel of the bent one shows, shape
    (h + 2 * TAPS, w + 2 * TAPS) or more; None for an ideal lens."""

    def seen(self, light: Pixels, frame: int) -> Pixels:
        """Light on the sensor, shape (h, w, 3), of a composed picture."""
        if not self.margin_px:
            return light
        if self.bend is not None:
            light = as_pixels(cv2.remap(light, *self.bend, interpolation=cv2.INTER_CUBIC))
        return _shifted(light, self.shift_px[frame], self.composed, self.margin_px)


def optics_for(projection: Projection, shift_px: Floats) -> Optics:
    """Build the optics of a clip from its projection and the tripod's shifts, shape (n, 2)."""
    moved = int(np.ceil(np.abs(shift_px).max()))
    ideal = projection.lens.ideal
    if ideal and not moved:
        return Optics(projection, 0, shift_px, None)
    margin = moved + TAPS + 1
    if ideal:
        return Optics(_widened(projection, margin), margin, shift_px, None)
    x, y = _flat_points(projection, margin)
    # The bent picture keeps its size, so that the composed one needs what lies beyond it besides.
    beyond = max(-x.min(), -y.min(), x.max() - projection.width_px, y.max() - projection.height_px)
    margin = max(margin, int(np.ceil(beyond)) + 2)
    x, y = _flat_points(projection, margin)
    bend = (as_pixels(x + margin), as_pixels(y + margin))
    return Optics(_widened(projection, margin), margin, shift_px, bend)


def _flat_points(projection: Projection, margin: int) -> tuple[Floats, Floats]:
    """Points of the flat picture that the pixels of the bent one show, margin included."""
    x_centre, y_centre = (projection.width_px - 1) / 2, (projection.height_px - 1) / 2
    x = np.arange(-margin, projection.width_px + margin) - x_centre
    y = np.arange(-margin, projection.height_px + margin)[:, None] - y_centre
    flat_x, flat_y = projection.lens.flat(*np.broadcast_arrays(x, y))
    return flat_x + x_centre, flat_y + y_centre


def _widened(projection: Projection, margin: int) -> Projection:
    """Return a projection of the same things with so many px more on each side."""
    return replace(
        projection,
        width_px=projection.width_px + 2 * margin,
        height_px=projection.height_px + 2 * margin,
        wall_x_px=projection.wall_x_px + margin,
        line_y_px=projection.line_y_px + margin,
    )


def _shifted(light: Pixels, shift_px: Floats, composed: Projection, margin: int) -> Pixels:
    """Cut the picture out of the composed one, moved by the shift."""
    whole = np.rint(shift_px).astype(int)
    kernel_x, kernel_y = (_kernel(part) for part in shift_px - whole)
    left, top = margin - TAPS - int(whole[0]), margin - TAPS - int(whole[1])
    width = composed.width_px - 2 * margin + 2 * TAPS
    height = composed.height_px - 2 * margin + 2 * TAPS
    part = np.ascontiguousarray(light[top : top + height, left : left + width])
    if np.any(shift_px != whole):
        part = as_pixels(cv2.sepFilter2D(part, -1, kernel_x, kernel_y))
    return np.ascontiguousarray(part[TAPS:-TAPS, TAPS:-TAPS])


def _kernel(part_px: float) -> Floats:
    """Weights by which a row moves by a part of a pixel, shape (2 * TAPS + 1,), sum 1."""
    place = np.arange(-TAPS, TAPS + 1) + part_px
    weights = np.sinc(place) * np.sinc(place / (TAPS + 0.5))
    return np.asarray(weights / weights.sum())

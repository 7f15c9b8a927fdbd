"""Where an outline is drawn in a picture, against where it should be."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import map_coordinates

from count_video.records import Floats

OUTLINE_WITHIN_PX = 1.0


def drawn_shift(picture: Floats, centre: tuple[float, float], radius: float) -> Floats:
    """Shift of the drawn circle from where it should be, (x, y), by the colour that it adds.

    On each ray from the centre the place of the largest added brightness is the line; its distance
    from the radius, over all rays, is a shift (first harmonic) and a change of size (the mean).
    """
    angle = np.radians(np.arange(0, 360, 5))
    along = np.arange(-6.0, 6.01, 0.25)
    reach = radius + along[:, None]
    x, y = centre[0] + reach * np.cos(angle), centre[1] + reach * np.sin(angle)
    added = map_coordinates(picture, [y, x], order=1)
    weight = np.clip(added - 0.5 * added.max(axis=0), 0, None)
    off = (weight * along[:, None]).sum(axis=0) / weight.sum(axis=0)
    return np.array(
        [2 * (off * np.cos(angle)).mean(), 2 * (off * np.sin(angle)).mean(), off.mean()]
    )

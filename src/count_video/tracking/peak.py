"""Where a sampled peak is highest, between its samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from count_video.tracking.sprite import Pixels


def peak_of(values: Pixels, place: int) -> float:
    """Refine the place of a peak by the parabola through its highest sample and the neighbours.

    Parameters
    ----------
    values
        Shape (n,).
    place
        Index of the highest sample; at an end the peak is taken to be there.
    """
    if not 0 < place < len(values) - 1:
        return float(place)
    return place + float(beyond(values[place - 1], values[place], values[place + 1]))


def beyond(
    before: Pixels | np.float32, here: Pixels | np.float32, after: Pixels | np.float32
) -> NDArray[np.float64]:
    """How far a peak lies from its highest sample, -0.5 to 0.5; 0 for a plateau."""
    low, high, top = np.float64(before), np.float64(after), np.float64(here)
    bend = 2 * top - low - high
    return np.asarray(np.where(bend > 0, 0.5 * (high - low) / np.where(bend > 0, bend, 1), 0))

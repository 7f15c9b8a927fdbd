"""The one type of pictures in the making: float32, values 0 to 255 or coverage 0 to 1."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Pixels = NDArray[np.float32]


def as_pixels(values: ArrayLike) -> Pixels:
    """Return the values as ``Pixels``, without a copy where they are that already."""
    return np.asarray(values, dtype=np.float32)

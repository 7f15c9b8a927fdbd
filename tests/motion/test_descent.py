"""Levenberg's and Marquardt's descent, by functions whose lowest place is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.motion.descent import CONVERGED, descend
from count_video.records import Floats


@dataclass(frozen=True)
class Valley:
    """Half the square of (x + y)^2: along x - y nothing changes."""

    values: Floats

    @property
    def loss(self) -> float:
        return float(self.values.sum() ** 4) / 2

    @property
    def gradient(self) -> Floats:
        return np.full(2, 2 * self.values.sum() ** 3)

    @property
    def hessian(self) -> Floats:
        return np.full((2, 2), 4 * self.values.sum() ** 2)


def test_a_long_descent_bears_parameters_that_cannot_be_told_apart() -> None:
    unlimited = np.full(2, -np.inf), np.full(2, np.inf)

    found = descend(Valley, np.array([1e7, 3.0]), unlimited)

    # Each step halves the sum, and so takes the loss to a sixteenth.
    assert found.loss < CONVERGED

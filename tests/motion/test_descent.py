"""Levenberg's and Marquardt's descent, by functions whose lowest place is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.motion.descent import CONVERGED, descend, loss_of, weights_of
from count_video.records import Floats


@dataclass(frozen=True)
class Valley:
    """Half the square of (x + y)^2: along x - y nothing changes."""

    values: Floats

    @property
    def loss(self) -> float:
        return float(self.values.sum() ** 4) / 2

    @property
    def squares(self) -> float:
        return self.loss

    @property
    def gradient(self) -> Floats:
        return np.full(2, 2 * self.values.sum() ** 3)

    @property
    def hessian(self) -> Floats:
        return np.full((2, 2), 4 * self.values.sum() ** 2)


@dataclass(frozen=True)
class Cubes:
    """Twenty residuals that are the cube of one parameter: each step takes a third off it."""

    values: Floats

    @property
    def residuals(self) -> Floats:
        return np.full(20, self.values[0] ** 3)

    @property
    def loss(self) -> float:
        return loss_of(self.residuals)

    @property
    def squares(self) -> float:
        return 0.5 * float((weights_of(self.residuals) * self.residuals**2).sum())

    @property
    def gradient(self) -> Floats:
        return np.array([6 * self.squares / self.values[0]])

    @property
    def hessian(self) -> Floats:
        return np.array([[18 * self.squares / self.values[0] ** 2]])


def test_residuals_so_large_that_they_hardly_count_are_no_reason_to_give_up() -> None:
    unlimited, bearable = (np.full(1, -np.inf), np.full(1, np.inf)), 1.0

    found = descend(Cubes, np.array([6.0]), unlimited, bearable)

    assert found.loss < bearable


def test_a_long_descent_bears_parameters_that_cannot_be_told_apart() -> None:
    unlimited = np.full(2, -np.inf), np.full(2, np.inf)

    found = descend(Valley, np.array([1e7, 3.0]), unlimited)

    # Each step halves the sum, and so takes the loss to a sixteenth.
    assert found.loss < CONVERGED

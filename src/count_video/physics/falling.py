"""Motion under a constant acceleration: a ball in the air, a cart on an inclined track."""

from __future__ import annotations

import math
from dataclasses import dataclass

from count_video.records import Floats


@dataclass(frozen=True, slots=True)
class Falling:
    """A parabola in time: q'' = a. It is a ``Law`` as ``count_video.physics.flights`` has it."""

    acceleration_m_s2: float
    """Of any sign; negative toward a stop at lower positions."""

    def advance(self, position_m: float, velocity_m_s: float, tau_s: float) -> tuple[float, float]:
        """Displacement and velocity after ``tau_s``."""
        pull = self.acceleration_m_s2
        return (velocity_m_s + 0.5 * pull * tau_s) * tau_s, velocity_m_s + pull * tau_s

    def advance_many(
        self, position_m: Floats, velocity_m_s: Floats, tau_s: Floats
    ) -> tuple[Floats, Floats]:
        """Do the same for arrays of shape (n,)."""
        pull = self.acceleration_m_s2
        return (velocity_m_s + 0.5 * pull * tau_s) * tau_s, velocity_m_s + pull * tau_s

    def acceleration(self, position_m: float, velocity_m_s: float) -> float:
        """Constant."""
        return self.acceleration_m_s2

    def bounds(self, position_m: float, velocity_m_s: float) -> tuple[float, float]:
        """|acceleration|, and no jerk."""
        return abs(self.acceleration_m_s2), 0.0

    def valid_for_s(self, velocity_m_s: float) -> float:
        """For ever."""
        return math.inf

    def turning_s(self, position_m: float, velocity_m_s: float) -> float:
        """Top of the parabola, where it opens downward and is still ahead."""
        if self.acceleration_m_s2 < 0.0 < velocity_m_s:
            return -velocity_m_s / self.acceleration_m_s2
        return math.inf

    def settled(self, velocity_m_s: float, slow_m_s: float) -> float:
        """No friction: as it is."""
        return velocity_m_s

    def potential(self, position_m: float) -> float:
        """Per unit mass: −a q, 0 at the origin."""
        return -self.acceleration_m_s2 * position_m

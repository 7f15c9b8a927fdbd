"""The apparatus: masses, threads, gaps and restitution; the defaults are the paper's Table 1."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from count_video.errors import UsageError

Mounting = Literal["free", "suspended"]


@dataclass(frozen=True)
class Setup:
    """One apparatus and the way a trial on it starts, in SI units.

    Metres point away from the wall, whose face is at 0. The ball lies between the wall and the
    heavy body (the cylinder). The gap of the bodies may be negative: then the cylinder would hang
    where the ball does. UsageError if a value is out of its range, or the combination is
    impossible.
    """

    heavy_mass_kg: float = 1.050
    light_mass_kg: float = 0.0105
    mounting: Mounting = "suspended"
    """``free``: no force between collisions; ``suspended``: each body a pendulum of its own, in the
    small-angle approximation."""
    heavy_thread_m: float = 1.0
    light_thread_m: float = 1.0
    heavy_damping_per_s: float = 0.0
    """Rate at which the amplitude of the free pendulum decays (suspended only)."""
    light_damping_per_s: float = 0.0
    ball_diameter_m: float = 0.040
    wall_gap_m: float = 0.07
    """Distance from the wall to the ball's wall-side face when the ball hangs at rest."""
    bodies_gap_m: float = 0.0
    """Distance from the ball's near face to the cylinder's face when both hang at rest."""
    release_m: float = 0.09
    """The cylinder starts this far beyond its rest position."""
    heavy_velocity_m_s: float = 0.0
    """Velocity of the cylinder at time 0; a free one needs it negative (toward the wall)."""
    restitution_bodies: float = 1.0
    restitution_wall: float = 1.0
    restitution_bodies_sd: float = 0.0
    """Standard deviation of the restitution from collision to collision (clipped to [0, 1])."""
    restitution_wall_sd: float = 0.0
    gravity_m_s2: float = 9.81

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if name != "mounting":
                _check_number(name, value)
        if self.bodies_gap_m + self.release_m < 0:
            raise UsageError(
                f"the cylinder would start {-self.bodies_gap_m - self.release_m:g} m inside the "
                "ball; raise release_m or the gaps"
            )
        if self.mounting == "suspended":
            self._check_pendulums()
        elif self.heavy_velocity_m_s >= 0:
            raise UsageError(
                f"heavy_velocity_m_s is {self.heavy_velocity_m_s:g}; a free cylinder "
                "needs a negative one (toward the wall) to collide at all"
            )

    @property
    def heavy_rest_m(self) -> float:
        """Face of the cylinder at rest."""
        return self.wall_gap_m + self.ball_diameter_m + self.bodies_gap_m

    def _check_pendulums(self) -> None:
        if self.gravity_m_s2 == 0:
            raise UsageError("gravity_m_s2 is 0; a suspended body needs weight, or choose free")
        for body in ("heavy", "light"):
            damping = getattr(self, f"{body}_damping_per_s")
            natural = swing_rate(getattr(self, f"{body}_thread_m"), self.gravity_m_s2)
            if damping >= natural:
                raise UsageError(
                    f"{body}_damping_per_s is {damping:g}; a pendulum that swings needs less than "
                    f"{natural:g}"
                )


def swing_rate(thread_m: float, gravity_m_s2: float) -> float:
    """Angular rate of a free pendulum, in radians per second; damped as much, it swings no more."""
    return math.sqrt(gravity_m_s2 / thread_m)


_POSITIVE = ("heavy_mass_kg", "light_mass_kg", "heavy_thread_m", "light_thread_m")
_ANY_SIGN = ("bodies_gap_m", "release_m", "heavy_velocity_m_s")
_FRACTIONS = ("restitution_bodies", "restitution_wall")


def _check_number(name: str, value: float) -> None:
    """Refuse a value outside the range of its field."""
    if name in _POSITIVE and value <= 0:
        raise UsageError(f"{name} is {value:g}; it must be greater than 0")
    if name not in _ANY_SIGN and value < 0:
        raise UsageError(f"{name} is {value:g}; it must not be negative")
    if name in _FRACTIONS and value > 1:
        raise UsageError(f"{name} is {value:g}; it must lie between 0 and 1")

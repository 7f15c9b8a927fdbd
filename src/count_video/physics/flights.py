"""How a body moves between collisions, in closed form.

Displacements, not positions, are returned: two bodies in contact have gap 0 exactly, and the gap
of a hop much smaller than a rounding of the positions still comes out with full relative accuracy.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from count_video.records import Floats

WINDOW_PERIODS = 2.0
"""A pendulum that meets nothing begins a new flight after this many of its periods."""
_INSTANT_S = 1e-300
"""A body at rest stops after so long: next to nothing, and not 0, by which one cannot divide."""

Number = TypeVar("Number", float, Floats)
"""One number, or an array of shape (n,)."""


class Law(ABC):
    """Motion of one body while it touches nothing new.

    Every method is given where and how fast the body starts. What a law does not say otherwise
    holds of a body that nothing stops or turns.
    """

    __slots__ = ()

    @abstractmethod
    def advance(
        self, position_m: Number, velocity_m_s: Number, tau_s: Number
    ) -> tuple[Number, Number]:
        """Displacement (m) and velocity (m/s) after ``tau_s``."""

    @abstractmethod
    def acceleration(self, position_m: float, velocity_m_s: float) -> float:
        """Acceleration at the start, m/s²."""

    @abstractmethod
    def bounds(self, position_m: float, velocity_m_s: float) -> tuple[float, float]:
        """Numbers that |acceleration| and |jerk| never exceed while the law is valid."""

    def valid_for_s(self, velocity_m_s: float) -> float:
        """Time for which closed form and bounds hold; then the body begins a new flight."""
        return math.inf

    def turning_s(self, position_m: Number, velocity_m_s: Number) -> Number:
        """Time until the velocity passes from positive to negative; inf if it never does."""
        return velocity_m_s * 0.0 + math.inf

    def settled(self, velocity_m_s: float, slow_m_s: float) -> float:
        """Velocity, or 0 where friction stops whatever is no faster than ``slow_m_s``."""
        return velocity_m_s

    def potential(self, position_m: float) -> float:
        """Potential energy per unit mass, J/kg."""
        return 0.0


@dataclass(frozen=True, slots=True)
class Sliding(Law):
    """A straight line with constant deceleration until rest; deceleration 0 is a free body."""

    deceleration_m_s2: float = 0.0

    def advance(
        self, position_m: Number, velocity_m_s: Number, tau_s: Number
    ) -> tuple[Number, Number]:
        """Displacement and velocity; once the body has stopped its velocity is 0 exactly."""
        if self.deceleration_m_s2 == 0.0:
            return velocity_m_s * tau_s, velocity_m_s + 0.0 * tau_s
        of_arrays = isinstance(tau_s, np.ndarray)
        least: Any = np.minimum if of_arrays else min
        most: Any = np.maximum if of_arrays else max
        stop_s = most(abs(velocity_m_s) / self.deceleration_m_s2, _INSTANT_S)
        share = least(tau_s / stop_s, 1.0)
        return velocity_m_s * (share * stop_s) * (1.0 - 0.5 * share), velocity_m_s * (1.0 - share)

    def acceleration(self, position_m: float, velocity_m_s: float) -> float:
        """Against the motion; 0 at rest, where friction only holds."""
        return -math.copysign(self.deceleration_m_s2, velocity_m_s) if velocity_m_s else 0.0

    def bounds(self, position_m: float, velocity_m_s: float) -> tuple[float, float]:
        """|acceleration| and |jerk| until the body stops."""
        return (self.deceleration_m_s2 if velocity_m_s else 0.0), 0.0

    def valid_for_s(self, velocity_m_s: float) -> float:
        """Until the body stops; for ever if nothing brakes it or it rests."""
        if self.deceleration_m_s2 == 0.0 or velocity_m_s == 0.0:
            return math.inf
        return abs(velocity_m_s) / self.deceleration_m_s2

    def settled(self, velocity_m_s: float, slow_m_s: float) -> float:
        """Stop at once what friction stops soon; a free body goes on, however slowly."""
        return 0.0 if self.deceleration_m_s2 and abs(velocity_m_s) <= slow_m_s else velocity_m_s


REST = Sliding(0.0)
"""The law of a body that is held: with velocity 0 it stays where it is."""


@dataclass(frozen=True, slots=True)
class Pendulum(Law):
    """A damped harmonic swing about ``rest_m``: q'' + 2 γ q' + ω₀² q = 0 with γ < ω₀.

    One pendulum, or n side by side: then fields and arguments are arrays of shape (n,), and
    ``advance``, ``phasor`` and ``turning_s`` hold of each.
    """

    rest_m: Any
    natural_rad_s: Any
    """ω₀ = √(g / thread length)."""
    damping_per_s: Any
    """γ, the decay rate of the amplitude."""
    damped_rad_s: Any
    """ω = √(ω₀² − γ²), the angular frequency of the swing."""

    @classmethod
    def from_thread(
        cls, thread_m: Any, gravity_m_s2: Any, damping_per_s: Any, rest_m: Any
    ) -> Pendulum:
        """Small-angle pendulum on a thread."""
        return cls.from_stiffness(gravity_m_s2 / thread_m, damping_per_s, rest_m)

    @classmethod
    def from_stiffness(cls, stiffness_per_s2: Any, damping_per_s: Any, rest_m: Any) -> Pendulum:
        """Pendulum from ω₀² and γ."""
        root = _functions_of(stiffness_per_s2).sqrt
        damped = root(stiffness_per_s2 - damping_per_s * damping_per_s)
        return cls(rest_m, root(stiffness_per_s2), damping_per_s, damped)

    @property
    def period_s(self) -> Any:
        """Time of a full swing."""
        return 2.0 * math.pi / self.damped_rad_s

    @property
    def rate_per_s(self) -> Any:
        """λ = iω − γ, of magnitude ω₀."""
        return 1j * self.damped_rad_s - self.damping_per_s

    def take(self, rows: Any) -> Pendulum:
        """Return some of n pendulums, by a mask or by places."""
        columns = (self.rest_m, self.natural_rad_s, self.damping_per_s, self.damped_rad_s)
        return Pendulum(*(column[rows] for column in columns))

    def phasor(self, position_m: Any, velocity_m_s: Any) -> Any:
        """C in q = Re(C e^{λτ})."""
        q = position_m - self.rest_m
        return q - 1j * ((velocity_m_s + self.damping_per_s * q) / self.damped_rad_s)

    def advance(
        self, position_m: Number, velocity_m_s: Number, tau_s: Number
    ) -> tuple[Number, Number]:
        """Displacement and velocity after ``tau_s``.

        q(τ) − q = q (e^{−γτ} cos ωτ − 1) + e^{−γτ} (v + γ q)/ω · sin ωτ, with the bracket written
        by expm1 and by 1 − cos ωτ = 2 sin² ωτ/2, so that nothing cancels at small τ.
        """
        functions = _functions_of(tau_s)
        natural, gamma, omega = self.natural_rad_s, self.damping_per_s, self.damped_rad_s
        q, velocity = position_m - self.rest_m, velocity_m_s
        half_angle = (0.5 * omega) * tau_s
        half_sine = functions.sin(half_angle)
        sine = 2.0 * half_sine * functions.cos(half_angle)
        fall = 2.0 * half_sine * half_sine
        cosine = 1.0 - fall
        loss = functions.expm1(-gamma * tau_s)
        shrink = 1.0 + loss
        push = (velocity + gamma * q) / omega
        pull = natural * (natural / omega) * q + gamma * velocity / omega
        return q * (loss * cosine - fall) + shrink * push * sine, shrink * (
            velocity * cosine - pull * sine
        )

    def acceleration(self, position_m: float, velocity_m_s: float) -> float:
        """−ω₀² q − 2 γ v."""
        pull = self.natural_rad_s**2 * (position_m - self.rest_m)
        return float(-pull - 2.0 * self.damping_per_s * velocity_m_s)

    def bounds(self, position_m: float, velocity_m_s: float) -> tuple[float, float]:
        """|q''| ≤ ω₀² |C| and |q'''| ≤ ω₀³ |C|."""
        amplitude = abs(self.phasor(position_m, velocity_m_s))
        acceleration = amplitude * self.natural_rad_s * self.natural_rad_s
        return acceleration, acceleration * self.natural_rad_s

    def valid_for_s(self, velocity_m_s: float) -> float:
        """Two periods: the closed form holds on, but contacts are sought window by window."""
        return float(WINDOW_PERIODS * self.period_s)

    def turning_s(self, position_m: Number, velocity_m_s: Number) -> Number:
        """First zero with negative slope of v cos ωτ − p sin ωτ, where p = (ω₀² q + γ v)/ω.

        Its zeros with negative slope lie at ωτ = atan2(v, p) and whole turns from there; inf for a
        body at rest in its place.
        """
        q = position_m - self.rest_m
        pull = (self.natural_rad_s**2 * q + self.damping_per_s * velocity_m_s) / self.damped_rad_s
        angle = np.arctan2(velocity_m_s, pull)
        time_s = np.where(angle > 0.0, angle, angle + 2.0 * np.pi) / self.damped_rad_s
        time_s = np.where((velocity_m_s == 0.0) & (pull == 0.0), np.inf, time_s)
        return time_s if isinstance(velocity_m_s, np.ndarray) else float(time_s)

    def potential(self, position_m: float) -> float:
        """½ ω₀² q²."""
        return float(0.5 * (self.natural_rad_s * (position_m - self.rest_m)) ** 2)


def _functions_of(value: Any) -> Any:
    """Return the module whose functions take a value: ``math`` is the faster for one number."""
    return np if isinstance(value, np.ndarray) else math

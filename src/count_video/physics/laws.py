"""How a body moves between collisions, in closed form.

There is one law, x'' = a - w0² (x - rest) - 2 γ x': a pendulum or a spring, with or without
damping; a throw or an incline, where nothing draws the body back (w0 = 0); a free body (a = 0).
Displacements, not positions, are returned: two bodies in contact have gap 0 exactly, and the gap
of a hop much smaller than a rounding of the positions still comes out with full relative accuracy.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Law:
    """Motion of one body while it touches nothing new, or of n bodies side by side.

    Then the fields are arrays of shape (n,), and so are the arguments of all methods.
    """

    rest_m: Any = 0.0
    """Where the body would hang still."""
    natural_rad_s: Any = 0.0
    """w0, the root of pull over distance from the rest; 0 where nothing draws the body back."""
    damping_per_s: Any = 0.0
    """γ, the decay rate of the amplitude; below w0, and 0 where w0 is."""
    acceleration_m_s2: Any = 0.0
    """a, a constant acceleration."""

    @classmethod
    def hanging(cls, thread_m: Any, gravity_m_s2: Any, damping_per_s: Any, rest_m: Any) -> Law:
        """Small-angle pendulum on a thread."""
        return cls(rest_m, np.sqrt(gravity_m_s2 / thread_m), damping_per_s, 0.0 * rest_m)

    @cached_property
    def damped_rad_s(self) -> Any:
        """Angular frequency of the swing, w = √(w0² − γ²)."""
        return np.sqrt(self.natural_rad_s**2 - self.damping_per_s**2)

    @cached_property
    def _square(self) -> Any:
        return self.natural_rad_s**2

    @cached_property
    def _swings(self) -> Any:
        return self.damped_rad_s > 0.0

    @cached_property
    def _divisors(self) -> tuple[Any, Any]:
        """What to divide by for w and w0²: 1 where they are 0."""
        swings = self._swings
        return np.where(swings, self.damped_rad_s, 1.0), np.where(swings, self._square, 1.0)

    @cached_property
    def _damped(self) -> bool:
        return bool(np.any(self.damping_per_s))

    @property
    def period_s(self) -> Any:
        """Time of a full swing; inf where there is none."""
        with np.errstate(divide="ignore"):
            return 2.0 * np.pi / np.asarray(self.damped_rad_s)

    def take(self, rows: Any) -> Law:
        """Return some of n bodies, by a mask or by places."""
        columns = (self.rest_m, self.natural_rad_s, self.damping_per_s, self.acceleration_m_s2)
        return Law(*(column[rows] for column in columns))

    def advance(self, position_m: Any, velocity_m_s: Any, tau_s: Any) -> tuple[Any, Any]:
        """Displacement (m) and velocity (m/s) after ``tau_s``.

        With s(τ) = e^{−γτ} sin wτ / w, the answer to a push, and its integral u(τ), the answer to
        a steady force F = a − w0² (x − rest), the displacement is v s + F u and the velocity
        v s' + F s. u is written by expm1 and by 1 − cos wτ = 2 sin² wτ/2, so that nothing cancels
        at small τ.
        """
        half = 0.5 * self.damped_rad_s * tau_s
        sine, cosine = np.sin(half), np.cos(half)
        divisor, square = self._divisors
        half_sine = np.where(self._swings, sine / divisor, 0.5 * tau_s)
        push, steady = 2.0 * half_sine * cosine, 2.0 * half_sine * half_sine
        after_push = 1.0 - 2.0 * sine * sine
        if self._damped:
            gamma = self.damping_per_s
            loss = np.expm1(-gamma * tau_s)
            shrink = 1.0 + loss
            push = shrink * push
            steady = shrink * (1.0 - gamma**2 / square) * steady - (loss + gamma * push) / square
            after_push = shrink * after_push - gamma * push
        force = self.acceleration_m_s2 - self._square * (position_m - self.rest_m)
        return velocity_m_s * push + force * steady, velocity_m_s * after_push + force * push

    def acceleration(self, position_m: Any, velocity_m_s: Any) -> Any:
        """Acceleration at a place and a velocity, m/s²."""
        pull = self._square * (position_m - self.rest_m)
        return self.acceleration_m_s2 - pull - 2.0 * self.damping_per_s * velocity_m_s

    def phasor(self, position_m: Any, velocity_m_s: Any) -> tuple[Any, Any]:
        """C and λ in x'' = Re(C e^{λτ}), λ = i w − γ: accelerations swing as the body does."""
        now = self.acceleration(position_m, velocity_m_s)
        gamma = self.damping_per_s
        turned = -(self._square * velocity_m_s + gamma * now) / self._divisors[0]
        return now - 1j * turned, 1j * self.damped_rad_s - gamma

    def turning_s(self, position_m: Any, velocity_m_s: Any) -> Any:
        """Time until a swinging body turns from away to toward; inf if it never does.

        The velocity is v cos wτ − p sin wτ with p = (w0² q + γ v)/w, but for its decay. Its zeros
        with negative slope lie at wτ = atan2(v, p) and whole turns from there.
        """
        divisor = self._divisors[0]
        away = self._square * (position_m - self.rest_m)
        pull = (away + self.damping_per_s * velocity_m_s) / divisor
        angle = np.arctan2(velocity_m_s, pull)
        time_s = np.where(angle > 0.0, angle, angle + 2.0 * np.pi) / divisor
        return np.where(self._swings & ((velocity_m_s != 0.0) | (pull != 0.0)), time_s, np.inf)

    def potential(self, position_m: Any) -> Any:
        """Potential energy per unit mass, J/kg; 0 at the rest, or at the origin of a throw."""
        q = position_m - self.rest_m
        return 0.5 * (self.natural_rad_s * q) ** 2 - self.acceleration_m_s2 * position_m

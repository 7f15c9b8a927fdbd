"""How a body moves between collisions, in closed form, and when two bodies next touch.

Displacements, not positions, are returned: two bodies in contact have gap 0 exactly, and the gap
of a hop much smaller than a rounding of the positions still comes out with full relative accuracy.
"""

from __future__ import annotations

import math
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

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

    def turning_s(self, position_m: float, velocity_m_s: float) -> float:
        """Time until the velocity passes from positive to negative; inf if it never does."""
        return math.inf

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
    """A damped harmonic swing about ``rest_m``: q'' + 2 γ q' + ω₀² q = 0 with γ < ω₀."""

    rest_m: float
    natural_rad_s: float
    """ω₀ = √(g / thread length)."""
    damping_per_s: float
    """γ, the decay rate of the amplitude."""
    damped_rad_s: float
    """ω = √(ω₀² − γ²), the angular frequency of the swing."""

    @classmethod
    def from_thread(
        cls, thread_m: float, gravity_m_s2: float, damping_per_s: float, rest_m: float
    ) -> Pendulum:
        """Small-angle pendulum on a thread."""
        return cls.from_stiffness(gravity_m_s2 / thread_m, damping_per_s, rest_m)

    @classmethod
    def from_stiffness(
        cls, stiffness_per_s2: float, damping_per_s: float, rest_m: float
    ) -> Pendulum:
        """Pendulum from ω₀² and γ."""
        damped = math.sqrt(stiffness_per_s2 - damping_per_s**2)
        return cls(rest_m, math.sqrt(stiffness_per_s2), damping_per_s, damped)

    @property
    def period_s(self) -> float:
        """Time of a full swing."""
        return 2.0 * math.pi / self.damped_rad_s

    @property
    def rate_per_s(self) -> complex:
        """λ = iω − γ, of magnitude ω₀."""
        return complex(-self.damping_per_s, self.damped_rad_s)

    def phasor(self, position_m: float, velocity_m_s: float) -> complex:
        """C in q = Re(C e^{λτ})."""
        q = position_m - self.rest_m
        return complex(q, -(velocity_m_s + self.damping_per_s * q) / self.damped_rad_s)

    def advance(
        self, position_m: Number, velocity_m_s: Number, tau_s: Number
    ) -> tuple[Number, Number]:
        """Displacement and velocity after ``tau_s``."""
        functions = np if isinstance(tau_s, np.ndarray) else math
        return swing(functions, self, (position_m - self.rest_m, velocity_m_s), tau_s)

    def acceleration(self, position_m: float, velocity_m_s: float) -> float:
        """−ω₀² q − 2 γ v."""
        pull = self.natural_rad_s**2 * (position_m - self.rest_m)
        return -pull - 2.0 * self.damping_per_s * velocity_m_s

    def bounds(self, position_m: float, velocity_m_s: float) -> tuple[float, float]:
        """|q''| ≤ ω₀² |C| and |q'''| ≤ ω₀³ |C|."""
        amplitude = abs(self.phasor(position_m, velocity_m_s))
        acceleration = amplitude * self.natural_rad_s * self.natural_rad_s
        return acceleration, acceleration * self.natural_rad_s

    def valid_for_s(self, velocity_m_s: float) -> float:
        """Two periods: the closed form holds on, but contacts are sought window by window."""
        return WINDOW_PERIODS * self.period_s

    def turning_s(self, position_m: float, velocity_m_s: float) -> float:
        """First zero with negative slope of v cos ωτ − p sin ωτ, where p = (ω₀² q + γ v)/ω.

        Its zeros with negative slope lie at ωτ = atan2(v, p) and whole turns from there; inf for a
        body at rest in its place.
        """
        q = position_m - self.rest_m
        pull = (self.natural_rad_s**2 * q + self.damping_per_s * velocity_m_s) / self.damped_rad_s
        if velocity_m_s == 0.0 and pull == 0.0:
            return math.inf
        angle = math.atan2(velocity_m_s, pull)
        return (angle if angle > 0.0 else angle + 2.0 * math.pi) / self.damped_rad_s

    def potential(self, position_m: float) -> float:
        """½ ω₀² q²."""
        return 0.5 * (self.natural_rad_s * (position_m - self.rest_m)) ** 2


def swing(functions: Any, law: Any, start: tuple[Any, Any], tau: Any) -> tuple[Any, Any]:
    """Displacement and velocity of a pendulum, or of many side by side.

    q(τ) − q = q (e^{−γτ} cos ωτ − 1) + e^{−γτ} (v + γ q)/ω · sin ωτ, with the bracket written by
    expm1 and by 1 − cos ωτ = 2 sin² ωτ/2, so that nothing cancels at small τ.

    Parameters
    ----------
    functions
        The module ``math`` for numbers, ``numpy`` for arrays of shape (n,).
    law
        Has the frequencies and the damping of ``Pendulum`` under their names.
    start
        Distance q from the rest place (m) and velocity (m/s).
    tau
        Time after the start, in seconds.
    """
    q, velocity = start
    natural, gamma, omega = law.natural_rad_s, law.damping_per_s, law.damped_rad_s
    half_angle = (0.5 * omega) * tau
    half_sine = functions.sin(half_angle)
    sine = 2.0 * half_sine * functions.cos(half_angle)
    fall = 2.0 * half_sine * half_sine
    cosine = 1.0 - fall
    loss = functions.expm1(-gamma * tau)
    shrink = 1.0 + loss
    push = (velocity + gamma * q) / omega
    pull = natural * (natural / omega) * q + gamma * velocity / omega
    return q * (loss * cosine - fall) + shrink * push * sine, shrink * (
        velocity * cosine - pull * sine
    )


# ---- when two bodies next touch: the first zero of their gap, never a later one ------------------
# When two bodies next touch: the first zero of their gap, never a later one.
#
# The gap f(τ) of two bodies on known laws has |f''| ≤ B for a B known in advance. So
#
#     f(τ + s) ≥ f(τ) + f'(τ) s − B s²/2,
#
# and the first positive zero of that parabola is a step that cannot jump over a contact. Steps of
# that kind approach the first zero from the left; near a zero with f' < 0 it is Newton's step but
# for terms of second order, hence quadratic: from above, f is bounded by the same parabola with + B
# s²/2, so after a step the zero is no farther than about B s²/|f'|. For free bodies (B = 0) it is
# the closed form at once. At a grazing contact (a double zero) it is linear and still ends, at the
# rounding error of the gap.

STEP_TOLERANCE = 1e-14
"""Stop when the zero is known to be closer than this fraction of the flight time, or a step adds
no more than that."""

MAXIMUM = sys.float_info.max


class Mover(NamedTuple):
    """A body at the start of a flight."""

    law: Law
    position_m: float
    velocity_m_s: float


WALL = Mover(REST, 0.0, 0.0)

Signal = Callable[[float], tuple[float, float, float]]
"""Value, first and second derivative at a time; where the first is negative, the second is not
needed and may be 0."""


def safe_step(gap: float, slope: float, curvature: float) -> float:
    """First positive zero of gap + slope s − curvature s²/2; inf if there is none."""
    root = math.sqrt(slope * slope + 2.0 * curvature * gap)
    if slope < 0.0:
        return 2.0 * gap / (root - slope)  # the form without cancellation
    return (slope + root) / curvature if curvature > 0.0 else math.inf


def opening_step(bend: float, jerk: float) -> float:
    """Step that is safe while the gap opens, f ≥ 0 and f' ≥ 0, ever faster, f'' = bend > 0.

    The third derivative being within ± jerk, f(τ + s) ≥ bend s²/2 − jerk s³/6. Bodies that have
    just been pulled apart have no gap and no speed yet: only this step gets them off each other.
    """
    if bend <= 0.0:
        return 0.0
    return 3.0 * bend / jerk if jerk > 0.0 else math.inf


def first_zero(evaluate: Signal, start: float, bounds: tuple[float, float], window: float) -> float:
    """First τ ≥ ``start`` at which a positive function reaches 0; inf if beyond ``window``.

    ``bounds`` are those of the second and third derivative.
    """
    curvature, jerk = bounds
    tau = start
    window = min(window, MAXIMUM)  # an infinite step then ends the search
    while tau <= window:
        value, slope, bend = evaluate(tau)
        if value <= 0.0:  # rounding has led beyond it: one Newton step back
            return max(start, tau - value / slope) if slope < 0.0 else tau
        step = safe_step(value, slope, curvature)
        if slope >= 0.0:
            step = max(step, opening_step(bend, jerk))
        tau += step
        within = STEP_TOLERANCE * tau
        if step <= within or curvature * step * step <= -slope * within:
            return tau if tau <= window else math.inf
    return math.inf


def contact_s(upper: Mover, lower: Mover, window_s: float) -> float:
    """Time until ``upper`` (farther from the wall) meets ``lower``; inf if not within the window.

    Bodies that touch already (gap 0) and separate are first carried away from that contact.
    """
    upper_law, upper_position, upper_velocity = upper
    lower_law, lower_position, lower_velocity = lower
    gap = max(0.0, upper_position - lower_position)
    slope = upper_velocity - lower_velocity
    if gap == 0.0 and slope < 0.0:
        return 0.0
    curvature, jerk = _gap_bounds(upper, lower, window_s)
    start = safe_step(gap, slope, curvature)
    if gap == 0.0 and start <= window_s:
        start = max(start, opening_step(_pull(upper, lower), jerk))
    if start > window_s:
        return math.inf

    def evaluate(tau: float) -> tuple[float, float, float]:
        rise, upper_now = upper_law.advance(upper_position, upper_velocity, tau)
        fall, lower_now = lower_law.advance(lower_position, lower_velocity, tau)
        bend = 0.0
        if upper_now >= lower_now:
            bend = upper_law.acceleration(upper_position + rise, upper_now)
            bend -= lower_law.acceleration(lower_position + fall, lower_now)
        return gap + rise - fall, upper_now - lower_now, bend

    return first_zero(evaluate, start, (curvature, jerk), window_s)


def _pull(upper: Mover, lower: Mover) -> float:
    """Relative acceleration of two bodies at the start."""
    pull = upper.law.acceleration(upper.position_m, upper.velocity_m_s)
    return pull - lower.law.acceleration(lower.position_m, lower.velocity_m_s)


def _gap_bounds(upper: Mover, lower: Mover, window_s: float) -> tuple[float, float]:
    """Bounds of the second and third derivative of the gap within the window."""
    if isinstance(upper.law, Pendulum) and isinstance(lower.law, Pendulum):
        return difference_bounds(
            (upper.law.phasor(upper.position_m, upper.velocity_m_s), upper.law.rate_per_s),
            (lower.law.phasor(lower.position_m, lower.velocity_m_s), lower.law.rate_per_s),
            window_s,
        )
    curvature, jerk = upper.law.bounds(upper.position_m, upper.velocity_m_s)
    lower_curvature, lower_jerk = lower.law.bounds(lower.position_m, lower.velocity_m_s)
    if jerk == lower_jerk == 0.0:  # constant until a body stops: no bound but the thing itself
        return abs(_pull(upper, lower)), 0.0
    return curvature + lower_curvature, jerk + lower_jerk


def difference_bounds(
    upper: tuple[Any, Any], lower: tuple[Any, Any], window_s: Number
) -> tuple[Number, Number]:
    """Bounds for two pendulums, each given by its phasor and rate; they may nearly be alike.

    With q = Re(C e^{λτ}) the n-th derivative of the gap is Re(A e^{λτ} − B e^{μτ}), A = C λⁿ and
    likewise B. It is no larger than |A| + |B|, nor, as no motion grows, than
    |A − B| + |B| |λ − μ| τ. The second is by far the smaller where frequencies and motions are
    nearly equal, and spares a hundred thousand steps along a gap of nanometres. Numbers, or arrays
    of shape (n,) for many pairs.
    """
    least: Any = np.minimum if isinstance(window_s, np.ndarray) else min
    upper_rate, lower_rate = upper[1], lower[1]
    upper_term, lower_term = upper[0] * upper_rate**2, lower[0] * lower_rate**2
    drift = abs(upper_rate - lower_rate) * window_s
    bounds = []
    for _ in ("second", "third"):
        apart, near = abs(upper_term) + abs(lower_term), abs(upper_term - lower_term)
        bounds.append(least(apart, near + abs(lower_term) * drift))
        upper_term, lower_term = upper_term * upper_rate, lower_term * lower_rate
    return bounds[0], bounds[1]

"""How a body moves between collisions, in closed form, and when two bodies next touch.

There is one law, x'' = a - w0² (x - rest) - 2 γ x': a pendulum or a spring, with or without
damping; a throw or an incline, where nothing draws the body back (w0 = 0); a free body (a = 0).
Displacements, not positions, are returned: two bodies in contact have gap 0 exactly, and the gap
of a hop much smaller than a rounding of the positions still comes out with full relative accuracy.

The gap f(τ) of two bodies has |f''| ≤ B for a B known in advance. So

    f(τ + s) ≥ f(τ) + f'(τ) s − B s²/2,

and the first positive zero of that parabola is a step that cannot jump over a contact. Steps of
that kind approach the first zero from the left; near a zero with f' < 0 it is Newton's step but
for terms of second order, hence quadratic: from above, f is bounded by the same parabola with + B
s²/2, so after a step the zero is no farther than about B s²/|f'|. For free bodies (B = 0) it is
the closed form at once. At a grazing contact (a double zero) it is linear and still ends, at the
rounding error of the gap.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats

Whole = NDArray[np.int64]

STEP_TOLERANCE = 1e-14
"""Stop when the zero is known to be closer than this fraction of the flight time, or a step adds
no more than that."""


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
    def _terms(self) -> tuple[Any, Any, Any, Any]:
        """w0², whether the body swings, and what to divide by for w and w0²: 1 where they are 0."""
        square, swings = self.natural_rad_s**2, self.damped_rad_s > 0.0
        divisor = np.where(swings, self.damped_rad_s, 1.0)
        return square, swings, divisor, np.where(swings, square, 1.0)

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
        natural_square, swings, divisor, square = self._terms
        half = 0.5 * self.damped_rad_s * tau_s
        sine, cosine = np.sin(half), np.cos(half)
        half_sine = np.where(swings, sine / divisor, 0.5 * tau_s)
        push, steady = 2.0 * half_sine * cosine, 2.0 * half_sine * half_sine
        after_push = 1.0 - 2.0 * sine * sine
        if np.any(self.damping_per_s):
            gamma = self.damping_per_s
            loss = np.expm1(-gamma * tau_s)
            shrink = 1.0 + loss
            push = shrink * push
            steady = shrink * (1.0 - gamma**2 / square) * steady - (loss + gamma * push) / square
            after_push = shrink * after_push - gamma * push
        force = self.acceleration_m_s2 - natural_square * (position_m - self.rest_m)
        return velocity_m_s * push + force * steady, velocity_m_s * after_push + force * push

    def acceleration(self, position_m: Any, velocity_m_s: Any) -> Any:
        """Acceleration at a place and a velocity, m/s²."""
        pull = self.natural_rad_s**2 * (position_m - self.rest_m)
        return self.acceleration_m_s2 - pull - 2.0 * self.damping_per_s * velocity_m_s

    def phasor(self, position_m: Any, velocity_m_s: Any) -> tuple[Any, Any]:
        """C and λ in x'' = Re(C e^{λτ}), λ = i w − γ: accelerations swing as the body does."""
        square, _, divisor, _ = self._terms
        now, gamma = self.acceleration(position_m, velocity_m_s), self.damping_per_s
        turned = -(square * velocity_m_s + gamma * now) / divisor
        return now - 1j * turned, 1j * self.damped_rad_s - gamma

    def turning_s(self, position_m: Any, velocity_m_s: Any) -> Any:
        """Time until a swinging body turns from away to toward; inf if it never does.

        The velocity is v cos wτ − p sin wτ with p = (w0² q + γ v)/w, but for its decay. Its zeros
        with negative slope lie at wτ = atan2(v, p) and whole turns from there.
        """
        square, swings, divisor, _ = self._terms
        away = square * (position_m - self.rest_m)
        pull = (away + self.damping_per_s * velocity_m_s) / divisor
        angle = np.arctan2(velocity_m_s, pull)
        time_s = np.where(angle > 0.0, angle, angle + 2.0 * np.pi) / divisor
        return np.where(swings & ((velocity_m_s != 0.0) | (pull != 0.0)), time_s, np.inf)


class Mover(NamedTuple):
    """n bodies at the start of their flights; places and velocities have shape (n,)."""

    law: Law
    position_m: Floats
    velocity_m_s: Floats

    def take(self, rows: Any) -> Mover:
        """Return some of them, by a mask or by places."""
        return Mover(self.law.take(rows), self.position_m[rows], self.velocity_m_s[rows])

    def after(self, tau_s: Floats, rows: Whole | None = None) -> tuple[Floats, Floats]:
        """Displacement (m) and velocity (m/s) of all, or of some rows, after a time for each."""
        some = rows is not None and len(rows) < len(self.position_m)
        law, position_m, velocity_m_s = self.take(rows) if some else self
        return law.advance(position_m, velocity_m_s, tau_s)


def contact_s(upper: Mover, lower: Mover | None, window_s: Floats) -> Floats:
    """Time until ``upper`` (farther from the wall) meets ``lower``; inf if not within the window.

    Without a ``lower`` it meets a wall at 0. Bodies that touch already (gap 0) and separate are
    first carried away from that contact. All arrays have shape (n,).
    """
    gap, approach = upper.position_m, upper.velocity_m_s
    if lower is not None:
        gap, approach = gap - lower.position_m, approach - lower.velocity_m_s
    gap = np.maximum(0.0, gap)
    # An infinite step ends the search, so a window without end is the largest number.
    window_s = np.clip(window_s, 0.0, sys.float_info.max)
    curvature = _curvature(upper, lower, window_s)

    def evaluate(rows: Whole, tau_s: Floats) -> tuple[Floats, Floats]:
        rise, velocity = upper.after(tau_s, rows)
        if lower is None:
            return gap[rows] + rise, velocity
        climb, lower_velocity = lower.after(tau_s, rows)
        return gap[rows] + rise - climb, velocity - lower_velocity

    return first_zero(evaluate, safe_step(gap, approach, curvature), curvature, window_s)


def _curvature(upper: Mover, lower: Mover | None, window_s: Floats) -> Floats:
    """Bound of the second derivative of a gap within the window.

    It is Re(A e^{λτ} − B e^{μτ}), hence no larger than |A| + |B|, nor, as no motion grows, than
    |A − B| + |B| |λ − μ| τ. The second is by far the smaller where frequencies and motions are
    nearly equal, and spares a hundred thousand steps along a gap of nanometres.
    """
    one, rate = upper.law.phasor(upper.position_m, upper.velocity_m_s)
    if lower is None:
        return np.asarray(abs(one))
    other, other_rate = lower.law.phasor(lower.position_m, lower.velocity_m_s)
    drift = np.minimum(abs(rate - other_rate) * window_s, 2.0)  # the exponentials stay within 1
    near = abs(one - other) + abs(other) * drift
    return np.asarray(np.minimum(abs(one) + abs(other), near))


def safe_step(gap: Floats, slope: Floats, curvature: Floats) -> Floats:
    """First positive zero of gap + slope s − curvature s²/2; inf if there is none."""
    root = np.sqrt(slope * slope + 2.0 * curvature * gap)
    closes, bends = slope < 0.0, curvature > 0.0
    # Of the two forms of the root that in which nothing cancels.
    divisor = np.where(closes, root - slope, np.where(bends, curvature, 1.0))
    step = np.where(closes, 2.0 * gap, slope + root) / divisor
    return np.where(closes | bends, step, np.inf)


def first_zero(
    evaluate: Callable[[Whole, Floats], tuple[Floats, Floats]],
    start: Floats,
    curvature: Floats,
    window: Floats,
) -> Floats:
    """First τ ≥ start at which each of n positive functions reaches 0; inf if not in its window.

    ``evaluate`` gives the values and slopes of the functions of some rows, at a time for each.
    """
    zeros = np.full_like(start, np.inf)
    tau = start.copy()
    rows = np.flatnonzero(tau <= window)
    while rows.size:
        now, bound = tau[rows], curvature[rows]
        value, slope = evaluate(rows, now)
        crossed = value <= 0.0
        if crossed.any():  # rounding has led beyond it: one Newton step back
            falls = crossed & (slope < 0.0)
            back = np.divide(value, slope, out=np.zeros_like(value), where=falls)
            zeros[rows[crossed]] = np.maximum(start[rows], now - back)[crossed]
        step = safe_step(np.maximum(value, 0.0), slope, bound)
        after = now + step
        within = STEP_TOLERANCE * after
        near = ~crossed & ((step <= within) | (bound * step * step <= -slope * within))
        arrived = near & (after <= window[rows])
        zeros[rows[arrived]] = after[arrived]
        tau[rows] = after
        rows = rows[~crossed & ~near & (after <= window[rows])]
    return zeros

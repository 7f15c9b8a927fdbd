"""When two bodies next touch: the first zero of their gap, never a later one.

The gap f(τ) of two bodies on known laws has |f''| ≤ B for a B known in advance. So

    f(τ + s) ≥ f(τ) + f'(τ) s − B s²/2,

and the first positive zero of that parabola is a step that cannot jump over a contact. Steps of
that kind approach the first zero from the left; near a zero with f' < 0 it is Newton's step but
for terms of second order, hence quadratic: from above, f is bounded by the same parabola with + B
s²/2, so after a step the zero is no farther than about B s²/|f'|. For free bodies (B = 0) it is
the closed form at once. At a grazing contact (a double zero) it is linear and still ends, at the
rounding error of the gap.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from count_video.physics.flights import REST, Law, Number, Pendulum

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

"""When two bodies next touch: the first zero of their gap, never a later one.

The gap f(τ) of two bodies on known laws has |f''| ≤ B for a B known in advance. So

    f(τ + s) ≥ f(τ) + f'(τ) s − B s²/2,

and the first positive zero of that parabola is a step that cannot jump over a contact. Steps of
that kind approach the first zero from the left; near a zero with f' < 0 it is Newton's step but
for terms of second order, hence quadratic: from above, f is bounded by the same parabola with + B
s²/2, so after a step the zero is no farther than about B s²/|f'|. For free bodies (B = 0) it is
the closed form at once. At a grazing contact (a double zero) it is linear and still ends, at the
rounding error of the gap. All functions take n pairs side by side, in arrays of shape (n,).
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from count_video.physics.laws import Law
from count_video.records import Floats

Whole = NDArray[np.int64]

STEP_TOLERANCE = 1e-14
"""Stop when the zero is known to be closer than this fraction of the flight time, or a step adds
no more than that."""
_MAXIMUM = sys.float_info.max
"""Stands for a window without end: an infinite step ends the search."""

Signals = Callable[[Whole, Floats], tuple[Floats, Floats]]
"""Values and slopes of the functions of some rows, at a time for each."""


class Mover(NamedTuple):
    """Bodies at the start of their flights; places and velocities have shape (n,)."""

    law: Law
    position_m: Floats
    velocity_m_s: Floats

    def take(self, rows: Whole) -> Mover:
        """Return some of them."""
        return Mover(self.law.take(rows), self.position_m[rows], self.velocity_m_s[rows])

    def after(self, tau_s: Floats) -> tuple[Floats, Floats]:
        """Displacement (m) and velocity (m/s) after a time."""
        rise, velocity = self.law.advance(self.position_m, self.velocity_m_s, tau_s)
        return rise, velocity


def wall_contact_s(body: Mover, window_s: Floats) -> Floats:
    """Time until bodies meet a wall at 0; as :func:`contact_s`."""
    window_s = np.clip(window_s, 0.0, _MAXIMUM)
    gap = np.maximum(0.0, body.position_m)
    curvature = abs(body.law.phasor(body.position_m, body.velocity_m_s)[0])

    def evaluate(rows: Whole, tau_s: Floats) -> tuple[Floats, Floats]:
        rise, now = (body.take(rows) if len(rows) < len(gap) else body).after(tau_s)
        return gap[rows] + rise, now

    start = safe_step(gap, body.velocity_m_s, curvature)
    return first_zero(evaluate, start, curvature, window_s)


def contact_s(upper: Mover, lower: Mover, window_s: Floats) -> Floats:
    """Time until ``upper`` (farther from the wall) meets ``lower``; inf if not within the window.

    Bodies that touch already (gap 0) and separate are first carried away from that contact.
    """
    gap = np.maximum(0.0, upper.position_m - lower.position_m)
    window_s = np.clip(window_s, 0.0, _MAXIMUM)
    curvature = gap_curvature(upper, lower, window_s)

    def evaluate(rows: Whole, tau_s: Floats) -> tuple[Floats, Floats]:
        some = len(rows) < len(gap)
        rise, upper_now = (upper.take(rows) if some else upper).after(tau_s)
        climb, lower_now = (lower.take(rows) if some else lower).after(tau_s)
        return gap[rows] + rise - climb, upper_now - lower_now

    start = safe_step(gap, upper.velocity_m_s - lower.velocity_m_s, curvature)
    return first_zero(evaluate, start, curvature, window_s)


def gap_curvature(upper: Mover, lower: Mover, window_s: Floats) -> Floats:
    """Bound of the second derivative of a gap within the window; both may nearly be alike.

    It is Re(A e^{λτ} − B e^{μτ}), hence no larger than |A| + |B|, nor, as no motion grows, than
    |A − B| + |B| |λ − μ| τ. The second is by far the smaller where frequencies and motions are
    nearly equal, and spares a hundred thousand steps along a gap of nanometres.
    """
    one, rate = upper.law.phasor(upper.position_m, upper.velocity_m_s)
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


def first_zero(evaluate: Signals, start: Floats, curvature: Floats, window: Floats) -> Floats:
    """First τ ≥ start at which each positive function reaches 0; inf if not within its window."""
    zeros = np.full_like(start, np.inf)
    tau = start.copy()
    rows = np.flatnonzero(tau <= window)
    while rows.size:
        now, bound = tau[rows], curvature[rows]
        value, slope = evaluate(rows, now)
        crossed = value <= 0.0
        if crossed.any():  # rounding has led beyond it: one Newton step back
            there, falling = rows[crossed], np.minimum(slope[crossed], 0.0)
            back = np.where(
                falling < 0.0, value[crossed] / np.where(falling < 0.0, falling, 1.0), 0.0
            )
            zeros[there] = np.maximum(start[there], now[crossed] - back)
        step = safe_step(np.maximum(value, 0.0), slope, bound)
        after = now + step
        within = STEP_TOLERANCE * after
        near = ~crossed & ((step <= within) | (bound * step * step <= -slope * within))
        arrived = near & (after <= window[rows])
        zeros[rows[arrived]] = after[arrived]
        tau[rows] = after
        rows = rows[~crossed & ~near & (after <= window[rows])]
    return zeros

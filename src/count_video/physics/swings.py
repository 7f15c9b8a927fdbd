"""Pendulums side by side, in arrays: how they swing, and when bodies next touch.

The laws are those of `flights`, the contacts are found as in `contacts`: by steps that cannot jump
over the first zero of a gap, because its second derivative has a bound that is known in advance.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from count_video.physics.contacts import STEP_TOLERANCE
from count_video.physics.flights import swing
from count_video.records import Floats

Whole = NDArray[np.int64]
Flags = NDArray[np.bool_]
PERIODS_AT_REST = 1.01
"""Contacts with a cylinder that rests are sought for one swing of the ball and a rounding more."""
_Signals = Callable[[Whole, Floats], tuple[Floats, Floats]]
"""Values and slopes of the functions of some rows at a time for each."""


class Swings(NamedTuple):
    """Damped pendulums about a rest place; arrays of shape (n,), named as in ``Pendulum``."""

    rest_m: Floats
    natural_rad_s: Floats
    damping_per_s: Floats
    damped_rad_s: Floats

    def advance(self, place: Floats, velocity: Floats, tau: Floats) -> tuple[Floats, Floats]:
        """Displacement and velocity after ``tau``."""
        return swing(np, self, (place - self.rest_m, velocity), tau)

    def phasor(self, place: Floats, velocity: Floats) -> NDArray[np.complex128]:
        """C in q = Re(C e^{λτ})."""
        q = place - self.rest_m
        return np.asarray(q - 1j * (velocity + self.damping_per_s * q) / self.damped_rad_s)

    @property
    def rate(self) -> NDArray[np.complex128]:
        """λ = iω − γ."""
        return np.asarray(1j * self.damped_rad_s - self.damping_per_s)

    def turning_s(self, place: Floats, velocity: Floats) -> Floats:
        """Time until the velocity passes from positive to negative; inf for a body at rest."""
        q = place - self.rest_m
        pull = (self.natural_rad_s**2 * q + self.damping_per_s * velocity) / self.damped_rad_s
        angle = np.arctan2(velocity, pull)
        time = np.where(angle > 0.0, angle, angle + 2.0 * np.pi) / self.damped_rad_s
        return np.where((velocity == 0.0) & (pull == 0.0), np.inf, time)

    def take(self, rows: Flags | Whole) -> Swings:
        """Return some of them."""
        return Swings(*(column[rows] for column in self))


class States(NamedTuple):
    """Where all are after an event; ``heavy`` is the cylinder's face less a ball diameter."""

    time: Floats
    heavy: Floats
    heavy_velocity: Floats
    ball: Floats
    ball_velocity: Floats

    def take(self, rows: Flags | Whole) -> States:
        """Return some of them."""
        return States(*(column[rows] for column in self))


def next_contact(
    laws: tuple[Swings, Swings], state: States, window: Floats, lasting: Flags
) -> tuple[Floats, Flags]:
    """Time of flight to the next contact, inf if there is none before the cylinder turns.

    Also whether it is one with the wall. Beyond the turn nothing counts any more. Bodies that touch
    now seldom meet next: theirs is sought last, with the least to seek.
    """
    # A cylinder at rest never turns; the ball comes back to it within a swing, or stays away.
    swing_s = PERIODS_AT_REST * 2.0 * np.pi / laws[1].damped_rad_s
    window = np.where(lasting, np.where(np.isinf(window), swing_s, window), -np.inf)
    wall, bodies = np.full_like(window, np.inf), np.full_like(window, np.inf)
    touching = state.heavy == state.ball
    for rows, order in (
        (np.flatnonzero(~touching), ((bodies, _bodies_contact), (wall, _wall_contact))),
        (np.flatnonzero(touching), ((wall, _wall_contact), (bodies, _bodies_contact))),
    ):
        laws_here, state_here = (laws[0].take(rows), laws[1].take(rows)), state.take(rows)
        for times, search in order:
            limit = np.minimum(window, np.minimum(wall, bodies))[rows]
            times[rows] = search(laws_here, state_here, limit)
    return np.minimum(wall, bodies), wall < bodies


def _wall_contact(laws: tuple[Swings, Swings], state: States, window: Floats) -> Floats:
    """Time until the ball reaches the wall; inf if not within the window."""
    light = laws[1]
    curvature = light.natural_rad_s**2 * np.abs(light.phasor(state.ball, state.ball_velocity))

    def evaluate(rows: Whole, tau: Floats) -> tuple[Floats, Floats]:
        law, ball = light.take(rows), state.ball[rows]
        rise, velocity = law.advance(ball, state.ball_velocity[rows], tau)
        return ball + rise, velocity

    start = _safe_step(state.ball, state.ball_velocity, curvature)
    return _first_zeros(evaluate, start, curvature, window)


def _bodies_contact(laws: tuple[Swings, Swings], state: States, window: Floats) -> Floats:
    """Time until ball and cylinder meet; inf if not within the window."""
    heavy, light = laws
    gap = state.heavy - state.ball
    curvature = _gap_curvature(laws, state, window)

    def evaluate(rows: Whole, tau: Floats) -> tuple[Floats, Floats]:
        here = state.take(rows)
        rise, upper = heavy.take(rows).advance(here.heavy, here.heavy_velocity, tau)
        climb, lower = light.take(rows).advance(here.ball, here.ball_velocity, tau)
        return gap[rows] + rise - climb, upper - lower

    start = _safe_step(gap, state.heavy_velocity - state.ball_velocity, curvature)
    return _first_zeros(evaluate, start, curvature, window)


def _gap_curvature(laws: tuple[Swings, Swings], state: States, window: Floats) -> Floats:
    """Bound of the second derivative of the gap, as ``contacts`` has it for two pendulums."""
    heavy, light = laws
    upper = heavy.phasor(state.heavy, state.heavy_velocity) * heavy.rate**2
    lower = light.phasor(state.ball, state.ball_velocity) * light.rate**2
    drift = np.abs(heavy.rate - light.rate) * np.maximum(window, 0.0)
    apart = np.abs(upper) + np.abs(lower)
    near = np.abs(upper - lower) + np.abs(lower) * drift
    return np.asarray(np.minimum(apart, near))


def _safe_step(gap: Floats, slope: Floats, curvature: Floats) -> Floats:
    """First positive zero of gap + slope s − curvature s²/2; inf if there is none."""
    root = np.sqrt(slope * slope + 2.0 * curvature * gap)
    with np.errstate(divide="ignore", invalid="ignore"):
        closing = 2.0 * gap / (root - slope)  # the form without cancellation
        opening = (slope + root) / curvature
    return np.where(slope < 0.0, closing, np.where(curvature > 0.0, opening, np.inf))


def _first_zeros(evaluate: _Signals, start: Floats, curvature: Floats, window: Floats) -> Floats:
    """First τ ≥ start at which each positive function reaches 0; inf if beyond its window."""
    zeros = np.full_like(start, np.inf)
    tau = start.copy()
    rows = np.flatnonzero(tau <= window)
    while rows.size:
        now, bound = tau[rows], curvature[rows]
        value, slope = evaluate(rows, now)
        crossed = value <= 0.0  # rounding has carried it a hair beyond: one Newton step back
        with np.errstate(divide="ignore", invalid="ignore"):
            back = np.where(slope < 0.0, now - value / slope, now)
        zeros[rows[crossed]] = np.maximum(start[rows], back)[crossed]
        step = _safe_step(np.maximum(value, 0.0), slope, bound)
        after = now + step
        within = STEP_TOLERANCE * after
        near = ~crossed & ((step <= within) | (bound * step * step <= -slope * within))
        arrived = near & (after <= window[rows])
        zeros[rows[arrived]] = after[arrived]
        tau[rows] = after
        rows = rows[~crossed & ~near & (after <= window[rows])]
    return zeros

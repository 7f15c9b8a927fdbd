"""From one event to the next: flights and bounces of many trials side by side, in arrays.

The n-th step is the n-th event of every trial that is still followed. The state is exact at each
event and everything is computed from the last one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from count_video.physics.contacts import Mover, Whole, contact_s, wall_contact_s
from count_video.physics.laws import Law
from count_video.physics.setup import Setup, laws_of
from count_video.records import Floats

Flags = NDArray[np.bool_]
RESTING_FRACTION = 1e-9
"""A bounce that leaves with less than this fraction of the trial's speed is none: the bodies stay
together. It ends the ever smaller hops of inelastic bodies: the speed of the n-th hop falls as eⁿ,
so at most ln(1e-9) / ln(e) hops come before rest (404 for e = 0.95)."""
PERIODS_AT_REST = 1.01
"""Contacts with a cylinder that rests are sought for one swing of the ball and a rounding more."""
_BLOCK = 64
"""Random numbers are drawn so many at a time for each trial; it does not change their sequence."""
_COLUMNS = tuple(field.name for field in fields(Setup) if field.name != "mounting")


class States(NamedTuple):
    """Places and velocities after an event; ``heavy`` is the face less a ball diameter.

    0 ≤ ball ≤ heavy, and equality is contact, exactly.
    """

    time: Floats
    heavy: Floats
    heavy_velocity: Floats
    ball: Floats
    ball_velocity: Floats


@dataclass(frozen=True)
class Step:
    """One event of n trials; all arrays have shape (n,)."""

    arrived: States
    """Just before it."""
    after: States
    bounce: Floats
    """Restitution, where two bodies met."""
    at_wall: Flags
    """Whether they were ball and wall."""
    met: Flags
    """Whether two bodies met."""
    resting: Flags
    """Whether these stay together."""
    turned: Flags
    """Whether the cylinder turned toward the wall."""
    never: Flags
    """Whether nothing will ever happen."""


class Run:
    """Trials that are followed side by side."""

    def __init__(self, table: NDArray[np.void], seeds: Sequence[int]) -> None:
        self.rows: Whole = np.arange(len(table))
        """The trials that are followed, by their places in the table."""
        self.laws = laws_of(table)
        """Of cylinder and ball, for all trials of the table."""
        ball, release = table["wall_gap_m"], table["release_m"]
        zeros = np.zeros(len(table))
        velocity = table["heavy_velocity_m_s"]
        start = ball + np.maximum(0.0, table["bodies_gap_m"] + release)
        self.state = States(zeros, start, velocity.copy(), ball.copy(), zeros)
        speed = np.abs(velocity) + np.abs(release) * self.laws[0].natural_rad_s
        self._slow_m_s = RESTING_FRACTION * speed
        self._ratio = table["heavy_mass_kg"] / table["light_mass_kg"]
        self._bounces = np.zeros(len(table), np.int64)
        self._scatter = _Scatter(table, seeds)
        self._here = self.laws

    def keep(self, lasting: Flags) -> None:
        """Follow only some of the trials any further."""
        if not lasting.all():
            self.rows = self.rows[lasting]
            self.state = States(*(column[lasting] for column in self.state))
            self._here = (self._here[0].take(lasting), self._here[1].take(lasting))

    def step(self) -> Step:
        """Go on to the next event of each trial."""
        (heavy, light), state, rows = self._here, self.state, self.rows
        turn_s = heavy.turning_s(state.heavy, state.heavy_velocity)
        # A cylinder at rest never turns; the ball comes back to it within a swing, or stays away.
        window = np.where(np.isfinite(turn_s), turn_s, PERIODS_AT_REST * light.period_s)
        flight_s, at_wall = _next_contact(heavy, light, state, window)
        met = np.isfinite(flight_s)
        turned = ~met & np.isfinite(turn_s)
        flight_s = np.where(met, flight_s, np.where(turned, turn_s, 0.0))
        rise, heavy_velocity = heavy.advance(state.heavy, state.heavy_velocity, flight_s)
        climb, ball_velocity = light.advance(state.ball, state.ball_velocity, flight_s)
        # Bodies that touch are set to touch exactly.
        ball = np.where(met & at_wall, 0.0, np.maximum(0.0, state.ball + climb))
        place = np.where(met & ~at_wall, ball, np.maximum(ball, state.heavy + rise))
        heavy_velocity = np.where(turned, 0.0, heavy_velocity)
        arrived = States(state.time + flight_s, place, heavy_velocity, ball, ball_velocity)
        approach = np.where(at_wall, -ball_velocity, ball_velocity - heavy_velocity)
        bounce = self._scatter.restitution(rows, self._bounces[rows], at_wall)
        resting = met & (bounce * approach <= self._slow_m_s[rows])
        # Equal and opposite impulses, or the ball off the wall.
        push = np.where(met & ~at_wall, (1.0 + bounce) * approach / (self._ratio[rows] + 1.0), 0.0)
        off_wall = np.where(met & at_wall, -bounce * ball_velocity, ball_velocity)
        after = arrived._replace(
            heavy_velocity=heavy_velocity + push,
            ball_velocity=off_wall - self._ratio[rows] * push,
        )
        self._bounces[rows] += met
        self.state = after
        never = ~met & ~turned
        return Step(arrived, after, bounce, at_wall, met, resting, turned, never)


def _next_contact(heavy: Law, light: Law, state: States, window: Floats) -> tuple[Floats, Flags]:
    """Time of flight (s) to the next contact, inf if there is none within the window.

    Also whether it is one with the wall. Bodies that touch now seldom meet next: theirs is sought
    last, with the least to seek.
    """
    bodies = np.full_like(window, np.inf)
    cylinder = Mover(heavy, state.heavy, state.heavy_velocity)
    ball = Mover(light, state.ball, state.ball_velocity)
    touching = np.flatnonzero(state.heavy == state.ball)
    apart = np.flatnonzero(state.heavy != state.ball)
    if apart.size:
        bodies[apart] = contact_s(cylinder.take(apart), ball.take(apart), window[apart])
    wall = wall_contact_s(ball, np.minimum(window, bodies))
    if touching.size:
        limit = np.minimum(window, wall)[touching]
        bodies[touching] = contact_s(cylinder.take(touching), ball.take(touching), limit)
    return np.minimum(wall, bodies), wall < bodies


class _Scatter:
    """Restitution of each bounce: the n-th bounce of a trial gets its seed's n-th number."""

    def __init__(self, table: NDArray[np.void], seeds: Sequence[int]) -> None:
        # Both have the row of the bodies, and below it that of the wall.
        self._mean = np.stack([table["restitution_bodies"], table["restitution_wall"]])
        self._sd = np.stack([table["restitution_bodies_sd"], table["restitution_wall_sd"]])
        self._rngs = [np.random.default_rng(seed) for seed in seeds] if self._sd.any() else []
        self._numbers = np.empty((len(table), 0))

    def restitution(self, rows: Whole, number: Whole, at_wall: Flags) -> Floats:
        """Restitution of the bounce of each row, of which ``number`` have gone before."""
        place = at_wall.astype(np.intp), rows
        if not self._rngs:
            return np.asarray(self._mean[place])
        while number.max(initial=0) >= self._numbers.shape[1]:
            block = np.stack([rng.standard_normal(_BLOCK) for rng in self._rngs])
            self._numbers = np.concatenate([self._numbers, block], axis=1)
        drawn = self._mean[place] + self._sd[place] * self._numbers[rows, number]
        return np.asarray(np.clip(drawn, 0.0, 1.0))


def table_of(setups: Sequence[Setup]) -> NDArray[np.void]:
    """Return a structured array with a row for each set-up."""
    columns = [(name, np.float64) for name in _COLUMNS]
    return np.array(
        [(*attrgetter(*_COLUMNS)(setup), setup.mounting == "suspended") for setup in setups],
        [*columns, ("suspended", np.bool_)],
    )

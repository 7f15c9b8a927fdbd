"""From one event to the next: flights and bounces of many trials side by side, in arrays.

The n-th step is the n-th event of every trial that is still followed. The state is exact at each
event and everything is computed from the last one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from count_video.physics.laws import Law, Mover, Whole, contact_s
from count_video.physics.setup import Setup
from count_video.records import Floats, Mask

RESTING_FRACTION = 1e-9
"""A bounce that leaves with less than this fraction of the trial's speed is none: the bodies stay
together. It ends the ever smaller hops of inelastic bodies: the speed of the n-th hop falls as eⁿ,
so at most ln(1e-9) / ln(e) hops come before rest (404 for e = 0.95)."""


def _columns(setups: Sequence[Setup]) -> dict[str, NDArray[Any]]:
    """Return the fields of n set-ups, shape (n,) each."""
    return {one.name: np.array([getattr(s, one.name) for s in setups]) for one in fields(Setup)}


def laws_of(setups: Sequence[Setup]) -> tuple[Law, Law]:
    """Laws of cylinder and ball; the cylinder's place is that of its face less a ball diameter."""
    table = _columns(setups)
    hangs, ball_m = table["mounting"] == "suspended", table["wall_gap_m"]
    heavy, ball = (
        Law.hanging(
            table[f"{body}_thread_m"],
            np.where(hangs, table["gravity_m_s2"], 0.0),
            np.where(hangs, table[f"{body}_damping_per_s"], 0.0),
            rest_m,
        )
        for body, rest_m in (("heavy", ball_m + table["bodies_gap_m"]), ("light", ball_m))
    )
    return heavy, ball


class Step(NamedTuple):
    """One event of n trials; all arrays have shape (n,)."""

    met: Mask
    """Whether two bodies met, ..."""
    at_wall: Mask
    """... which were ball and wall."""
    restitution: Floats
    resting: Mask
    """Whether these stay together."""
    turned: Mask
    """Whether the cylinder turned toward the wall."""
    never: Mask
    """Whether nothing will ever happen."""
    heavy_before_m_s: Floats
    ball_before_m_s: Floats


class Run:
    """Trials that are followed side by side: the state after their last events.

    0 ≤ ball ≤ cylinder (its face less a ball diameter), and equality is contact, exactly.
    """

    def __init__(self, setups: Sequence[Setup], seeds: Sequence[int]) -> None:
        table = _columns(setups)
        self.rows: Whole = np.arange(len(setups))
        """The trials that are followed, by their places among all."""
        self.time_s = np.zeros(len(setups))
        release_m, velocity_m_s = table["release_m"], table["heavy_velocity_m_s"] + 0.0
        heavy_law, ball_law = laws_of(setups)
        ball_m = table["wall_gap_m"] + 0.0
        start_m = ball_m + np.maximum(0.0, table["bodies_gap_m"] + release_m)
        self.heavy = Mover(heavy_law, start_m, velocity_m_s)
        self.ball = Mover(ball_law, ball_m, np.zeros(len(setups)))
        speed_m_s = np.abs(velocity_m_s) + np.abs(release_m) * heavy_law.natural_rad_s
        self._slow_m_s = RESTING_FRACTION * speed_m_s
        self._ratio = table["heavy_mass_kg"] / table["light_mass_kg"]
        # Restitution by body (the cylinder's row, then the wall's) and trial.
        self._mean = np.stack([table["restitution_bodies"], table["restitution_wall"]])
        self._sd = np.stack([table["restitution_bodies_sd"], table["restitution_wall_sd"]])
        self._rngs = [np.random.default_rng(seed) for seed in seeds] if self._sd.any() else []
        self._numbers = np.empty((len(setups), 0))
        self._bounces = np.zeros(len(setups), np.int64)

    def events(self) -> Floats:
        """State as in ``Motion.events``, shape (trials, 5)."""
        return np.column_stack([self.time_s, *self.heavy[1:], *self.ball[1:]])

    def keep(self, lasting: Mask) -> None:
        """Follow only some of the trials any further."""
        if not lasting.all():
            self.rows, self.time_s = self.rows[lasting], self.time_s[lasting]
            self.heavy, self.ball = self.heavy.take(lasting), self.ball.take(lasting)

    def step(self) -> Step:
        """Go on to the next event of each trial."""
        heavy, ball, ratio = self.heavy, self.ball, self._ratio[self.rows]
        turn_s = heavy.law.turning_s(heavy.position_m, heavy.velocity_m_s)
        flight_s, at_wall = _next_contact(heavy, ball, turn_s)
        met = np.isfinite(flight_s)
        turned = ~met & np.isfinite(turn_s)
        flight_s = np.where(met, flight_s, np.where(turned, turn_s, 0.0))
        rise, heavy_m_s = heavy.after(flight_s)
        climb, ball_m_s = ball.after(flight_s)
        # Bodies that touch are set to touch exactly.
        ball_m = np.where(met & at_wall, 0.0, np.maximum(0.0, ball.position_m + climb))
        heavy_m = np.maximum(ball_m, heavy.position_m + rise)
        heavy_m = np.where(met & ~at_wall, ball_m, heavy_m)
        heavy_m_s = np.where(turned, 0.0, heavy_m_s)
        approach = np.where(at_wall, -ball_m_s, ball_m_s - heavy_m_s)
        bounce = self._restitution(at_wall)
        # Equal and opposite impulses, or the ball off the wall.
        push = np.where(met & ~at_wall, (1.0 + bounce) * approach / (ratio + 1.0), 0.0)
        off_wall = np.where(met & at_wall, -bounce * ball_m_s, ball_m_s)
        self.time_s = self.time_s + flight_s
        self.heavy = Mover(heavy.law, heavy_m, heavy_m_s + push)
        self.ball = Mover(ball.law, ball_m, off_wall - ratio * push)
        self._bounces[self.rows] += met
        resting = met & (bounce * approach <= self._slow_m_s[self.rows])
        return Step(met, at_wall, bounce, resting, turned, ~met & ~turned, heavy_m_s, ball_m_s)

    def _restitution(self, at_wall: Mask) -> Floats:
        """Restitution of each trial's next bounce: the n-th gets its seed's n-th number."""
        place, number = (at_wall.astype(np.intp), self.rows), self._bounces[self.rows]
        if not self._rngs:
            return np.asarray(self._mean[place])
        while number.max(initial=0) >= self._numbers.shape[1]:
            # Drawing many at a time does not change their sequence.
            block = np.stack([rng.standard_normal(64) for rng in self._rngs])
            self._numbers = np.concatenate([self._numbers, block], axis=1)
        drawn = self._mean[place] + self._sd[place] * self._numbers[self.rows, number]
        return np.asarray(np.clip(drawn, 0.0, 1.0))


def _next_contact(heavy: Mover, ball: Mover, turn_s: Floats) -> tuple[Floats, Mask]:
    """Time of flight (s) to the next contact before the cylinder turns; inf if there is none.

    Also whether it is one with the wall. A cylinder at rest never turns; the ball comes back to it
    within a swing, or stays away.
    """
    a_swing_s = 1.01 * ball.law.period_s  # and a rounding more
    window_s = np.where(np.isfinite(turn_s), turn_s, a_swing_s)
    wall_s = contact_s(ball, None, window_s)
    bodies_s = contact_s(heavy, ball, np.minimum(window_s, wall_s))
    return np.minimum(wall_s, bodies_s), wall_s < bodies_s

"""Many suspended trials at once: the bursts of `simulator`, for thousands of set-ups in a second.

`simulator` follows one trial through every oddity, event by event, in plain numbers. Here the same
events are followed for all set-ups side by side, in arrays: the n-th pass of the loop is the n-th
event of every set-up whose burst still lasts. Where bodies come to rest on each other, which ends
the alternation of flights and bounces, that set-up is left without a count.

The small-angle pendulums are linear, so that lengths scale: with gap and release multiplied by one
factor all times, counts and ratios of velocities stay the same.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from count_video.errors import UsageError
from count_video.physics.contacts import STEP_TOLERANCE, difference_bounds
from count_video.physics.flights import Pendulum
from count_video.physics.setup import RESTING_FRACTION, Setup, pendulums_of
from count_video.physics.simulator import LONGEST_BURST_PERIODS, MOST_COLLISIONS
from count_video.records import Floats

Whole = NDArray[np.int64]
Flags = NDArray[np.bool_]
NO_COUNT = -1
PERIODS_AT_REST = 1.01
"""Contacts with a cylinder that rests are sought for one swing of the ball and a rounding more."""
_Signals = Callable[[Whole, Floats], tuple[Floats, Floats]]
"""Values and slopes of the functions of some rows at a time for each."""
_BLOCK = 64
"""Random numbers are drawn so many at a time for each set-up; it does not change their sequence."""
_FINISHED_SHARE = 0.25
"""Finished set-ups are taken out of the arrays once they are this share of them."""
_COLUMNS = (
    *("heavy_mass_kg", "light_mass_kg", "heavy_thread_m", "light_thread_m"),
    *("heavy_damping_per_s", "light_damping_per_s", "wall_gap_m", "bodies_gap_m", "release_m"),
    *("restitution_bodies", "restitution_wall", "restitution_bodies_sd", "restitution_wall_sd"),
    "gravity_m_s2",
)
"""Fields of a set-up that the loop works with, each a column of a structured array."""


def varied(setup: Setup, **columns: ArrayLike) -> list[Setup]:
    """Return a set-up with other values of some fields: numbers, or arrays of one shape (n,).

    Raises
    ------
    UsageError
        If a value is out of its range.
    """
    rows = np.column_stack(np.broadcast_arrays(*map(np.atleast_1d, columns.values())))
    return [replace(setup, **dict(zip(columns, row, strict=True))) for row in rows.tolist()]


@dataclass(frozen=True)
class ManyBursts:
    """What became of each set-up; all arrays have shape (n,)."""

    count: Whole
    """Collisions of the burst; ``NO_COUNT`` where that is endless."""
    shortest_s: Floats
    """Shortest time from one of them to the next; inf if there are fewer than two, NaN without a
    count."""
    last_s: Floats
    """Time of the last one."""
    turn_s: Floats
    """When the cylinder, driven back, turns round; inf if it never does, NaN without a count."""
    endless: Flags
    """Whether bodies came to rest on each other in ever smaller bounces, or collided more often
    than was asked for."""


def simulate_many(
    setups: Sequence[Setup], most: int = MOST_COLLISIONS, seeds: Sequence[int] | None = None
) -> ManyBursts:
    """Run n suspended trials to the end of their bursts.

    Parameters
    ----------
    most
        Leave trials with more collisions than this, and those in which bodies come to rest on each
        other, without a count.
    seeds
        Of the scatter of the restitution, n of them; None: 0 for all.

    Raises
    ------
    UsageError
        If a trial is not one of a cylinder let go at rest and a ball that hangs off the wall.
    """
    for setup in setups:
        moving = setup.heavy_velocity_m_s or setup.release_m <= 0
        if setup.mounting != "suspended" or setup.wall_gap_m <= 0 or moving:
            raise UsageError("many trials at once need bodies on threads, gaps and a release")
    table = np.array(
        list(map(attrgetter(*_COLUMNS), setups)), [(name, np.float64) for name in _COLUMNS]
    )
    size = len(table)
    found = ManyBursts(
        count=np.zeros(size, np.int64),
        shortest_s=np.full(size, np.inf),
        last_s=np.full(size, np.nan),
        turn_s=np.full(size, np.inf),
        endless=np.zeros(size, np.bool_),
    )
    _follow(table, found, most, _Scatter(table, [0] * size if seeds is None else seeds))
    found.count[found.endless] = NO_COUNT
    for times in (found.shortest_s, found.turn_s):
        times[found.endless] = np.nan
    return found


def _follow(table: NDArray[np.void], found: ManyBursts, most: int, numbers: _Scatter) -> None:
    """Follow all rows from event to event; the arrays of ``found`` are filled in."""
    rows = np.arange(len(table))
    gap, ratio = table["wall_gap_m"], table["heavy_mass_kg"] / table["light_mass_kg"]
    heavy, light = pendulums_of(table.view(np.recarray))
    slow = RESTING_FRACTION * table["release_m"] * heavy.natural_rad_s
    limit = LONGEST_BURST_PERIODS * 2.0 * np.pi / heavy.damped_rad_s
    zeros = np.zeros(len(table))
    state = States(zeros, gap + table["bodies_gap_m"] + table["release_m"], zeros, gap, zeros)
    lasting = np.ones(len(table), np.bool_)
    while lasting.any():
        if lasting.mean() < 1.0 - _FINISHED_SHARE:
            rows, state, lasting = rows[lasting], state.take(lasting), lasting[lasting]
        laws = heavy.take(rows), light.take(rows)
        turn_s = laws[0].turning_s(state.heavy, state.heavy_velocity)
        flight_s, at_wall = _next_contact(laws, state, turn_s, lasting)
        met = np.isfinite(flight_s)
        ended = lasting & (~met | (state.time + flight_s > limit[rows]))
        found.turn_s[rows[ended]] = (state.time + turn_s)[ended]
        lasting &= ~ended
        arrived = _arrived(laws, state, np.where(lasting, flight_s, 0.0), at_wall)
        approach = np.where(
            at_wall, -arrived.ball_velocity, arrived.ball_velocity - arrived.heavy_velocity
        )
        resting = lasting & (approach <= slow[rows])
        bounce = numbers.restitution(rows, found.count[rows], at_wall)
        resting |= lasting & (bounce * approach <= slow[rows])
        resting |= lasting & (found.count[rows] >= most)
        found.endless[rows[resting]] = True
        lasting &= ~resting
        _note(found, rows[lasting], arrived.time[lasting])
        state = _bounced(ratio[rows], arrived, at_wall, approach, bounce)


def _note(found: ManyBursts, rows: Whole, time_s: Floats) -> None:
    """Count one collision more for some rows."""
    since = time_s - found.last_s[rows]
    known = np.where(np.isnan(since), np.inf, since)
    found.shortest_s[rows] = np.minimum(found.shortest_s[rows], known)
    found.last_s[rows] = time_s
    found.count[rows] += 1


class _Scatter:
    """Restitution of each bounce: the n-th bounce of a set-up gets its seed's n-th number."""

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


def _arrived(
    laws: tuple[Pendulum, Pendulum], state: States, flight_s: Floats, at_wall: Flags
) -> States:
    """State at the end of a flight; bodies that touch are set to touch exactly."""
    rise, heavy_velocity = laws[0].advance(state.heavy, state.heavy_velocity, flight_s)
    climb, ball_velocity = laws[1].advance(state.ball, state.ball_velocity, flight_s)
    ball = np.where(at_wall, 0.0, np.maximum(0.0, state.ball + climb))
    heavy = np.where(at_wall, np.maximum(ball, state.heavy + rise), ball)
    return States(state.time + flight_s, heavy, heavy_velocity, ball, ball_velocity)


def _bounced(
    ratio: Floats, arrived: States, at_wall: Flags, approach: Floats, bounce: Floats
) -> States:
    """State after a bounce: equal and opposite impulses, or the ball off the wall."""
    push = (1.0 + bounce) * approach / (ratio + 1.0)
    heavy_after = arrived.heavy_velocity + np.where(at_wall, 0.0, push)
    ball_after = np.where(
        at_wall, -bounce * arrived.ball_velocity, arrived.ball_velocity - ratio * push
    )
    return arrived._replace(heavy_velocity=heavy_after, ball_velocity=ball_after)


# ---- flights and contacts side by side, as in `contacts` --------------------------------------


class States(NamedTuple):
    """Places and velocities after an event; ``heavy`` is the face less a ball diameter."""

    time: Floats
    heavy: Floats
    heavy_velocity: Floats
    ball: Floats
    ball_velocity: Floats

    def take(self, rows: Flags | Whole) -> States:
        """Return some of them."""
        return States(*(column[rows] for column in self))


def _next_contact(
    laws: tuple[Pendulum, Pendulum], state: States, window: Floats, lasting: Flags
) -> tuple[Floats, Flags]:
    """Time of flight (s) to the next contact, inf if there is none before the cylinder turns.

    Also whether it is one with the wall; all arrays have shape (n,). Beyond the turn nothing counts
    any more. Bodies that touch now seldom meet next: theirs is sought last, with the least to seek.
    """
    # A cylinder at rest never turns; the ball comes back to it within a swing, or stays away.
    swing_s = PERIODS_AT_REST * 2.0 * np.pi / laws[1].damped_rad_s
    window = np.where(lasting, np.where(np.isinf(window), swing_s, window), -np.inf)
    wall, bodies = np.full_like(window, np.inf), np.full_like(window, np.inf)
    zeros = np.zeros_like(window)
    rest = Pendulum(zeros, zeros, zeros, np.ones_like(window))
    # The ball meets the wall as the cylinder meets the ball.
    of_ball = States(state.time, state.ball, state.ball_velocity, zeros, zeros)
    pairs = ((bodies, laws, state), (wall, (laws[1], rest), of_ball))
    touching = state.heavy == state.ball
    for some, order in ((~touching, pairs), (touching, pairs[::-1])):
        rows = np.flatnonzero(some)
        for times, (upper, lower), placed in order:
            limit = np.minimum(window, np.minimum(wall, bodies))[rows]
            times[rows] = _contact((upper.take(rows), lower.take(rows)), placed.take(rows), limit)
    return np.minimum(wall, bodies), wall < bodies


def _contact(laws: tuple[Pendulum, Pendulum], state: States, window: Floats) -> Floats:
    """Time until two bodies meet, of which the first is the cylinder, or the ball at the wall."""
    heavy, light = laws
    gap = state.heavy - state.ball
    curvature, _ = difference_bounds(
        (heavy.phasor(state.heavy, state.heavy_velocity), heavy.rate_per_s),
        (light.phasor(state.ball, state.ball_velocity), light.rate_per_s),
        np.maximum(window, 0.0),
    )

    def evaluate(rows: Whole, tau: Floats) -> tuple[Floats, Floats]:
        here = state.take(rows)
        rise, upper = heavy.take(rows).advance(here.heavy, here.heavy_velocity, tau)
        climb, lower = light.take(rows).advance(here.ball, here.ball_velocity, tau)
        return gap[rows] + rise - climb, upper - lower

    start = _safe_steps(gap, state.heavy_velocity - state.ball_velocity, curvature)
    return _first_zeros(evaluate, start, curvature, window)


def _safe_steps(gap: Floats, slope: Floats, curvature: Floats) -> Floats:
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
        crossed = value <= 0.0  # rounding has led beyond it: one Newton step back
        with np.errstate(divide="ignore", invalid="ignore"):
            back = np.where(slope < 0.0, now - value / slope, now)
        zeros[rows[crossed]] = np.maximum(start[rows], back)[crossed]
        step = _safe_steps(np.maximum(value, 0.0), slope, bound)
        after = now + step
        within = STEP_TOLERANCE * after
        near = ~crossed & ((step <= within) | (bound * step * step <= -slope * within))
        arrived = near & (after <= window[rows])
        zeros[rows[arrived]] = after[arrived]
        tau[rows] = after
        rows = rows[~crossed & ~near & (after <= window[rows])]
    return zeros

"""Many suspended trials at once: the bursts of `simulator`, for thousands of set-ups in a second.

`simulator` follows one trial through every oddity, event by event, in plain numbers. Here the same
events are followed for all set-ups side by side, in arrays: the n-th pass of the loop is the n-th
event of every set-up whose burst still lasts. Where bodies come to rest on each other, which ends
the alternation of flights and bounces, that set-up alone is handed to `simulator`, or left without
a count.

The small-angle pendulums are linear, so that lengths scale: with gap and release multiplied by one
factor all times, counts and ratios of velocities stay the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from count_video.errors import UsageError
from count_video.physics.contacts import Flags, States, Swings, Whole, next_contact
from count_video.physics.setup import RESTING_FRACTION, Setup
from count_video.physics.simulator import LONGEST_BURST_PERIODS, MOST_COLLISIONS, simulate
from count_video.records import Floats

GRAVITY_M_S2 = 9.81
NO_COUNT = -1
_BLOCK = 64
"""Random numbers are drawn so many at a time for each set-up; it does not change their sequence."""
_FINISHED_SHARE = 0.25
"""Finished set-ups are taken out of the arrays once they are this share of them."""


@dataclass(frozen=True)
class ManySetups:
    """Set-ups of suspended trials without a gap between the bodies; all arrays have shape (n,)."""

    mass_ratio: Floats
    """Heavy over light mass."""
    wall_gap_m: Floats
    release_m: Floats
    heavy_thread_m: Floats
    light_thread_m: Floats
    damping_per_s: Floats
    """Decay rate of both pendulums' amplitudes."""
    restitution_bodies: Floats
    restitution_wall: Floats
    restitution_sd: Floats
    """Standard deviation of both from collision to collision."""
    seed: Whole
    """Seed of the scatter of the restitution."""

    @classmethod
    def of(cls, **values: ArrayLike) -> ManySetups:
        """Make set-ups from numbers or arrays of one shape; what is left out is that of ``Setup``.

        Raises
        ------
        UsageError
            If a value is out of its range.
        """
        unknown = values.keys() - _DEFAULTS.keys()
        if unknown:
            raise UsageError(f"set-ups have no {min(unknown)}; they have {', '.join(_DEFAULTS)}")
        given = {**_DEFAULTS, **values}
        arrays = np.broadcast_arrays(*(np.atleast_1d(given[name]) for name in _DEFAULTS))
        columns = dict(zip(_DEFAULTS, arrays, strict=True))
        seed = np.array(columns.pop("seed"), np.int64)
        setups = cls(**{name: np.array(c, np.float64) for name, c in columns.items()}, seed=seed)
        _check(setups)
        return setups

    def __len__(self) -> int:
        return len(self.mass_ratio)

    def one(self, row: int) -> Setup:
        """Return one of them as ``simulator`` takes it."""
        return Setup(
            heavy_mass_kg=float(self.mass_ratio[row]),
            light_mass_kg=1.0,
            heavy_thread_m=float(self.heavy_thread_m[row]),
            light_thread_m=float(self.light_thread_m[row]),
            heavy_damping_per_s=float(self.damping_per_s[row]),
            light_damping_per_s=float(self.damping_per_s[row]),
            wall_gap_m=float(self.wall_gap_m[row]),
            release_m=float(self.release_m[row]),
            restitution_bodies=float(self.restitution_bodies[row]),
            restitution_wall=float(self.restitution_wall[row]),
            restitution_bodies_sd=float(self.restitution_sd[row]),
            restitution_wall_sd=float(self.restitution_sd[row]),
            gravity_m_s2=GRAVITY_M_S2,
        )


_DEFAULTS: dict[str, ArrayLike] = {  # in the order of the fields
    "mass_ratio": 100.0,
    "wall_gap_m": Setup.wall_gap_m,
    "release_m": Setup.release_m,
    "heavy_thread_m": Setup.heavy_thread_m,
    "light_thread_m": Setup.light_thread_m,
    "damping_per_s": 0.0,
    "restitution_bodies": 1.0,
    "restitution_wall": 1.0,
    "restitution_sd": 0.0,
    "seed": 0,
}


@dataclass(frozen=True)
class ManyBursts:
    """What became of each set-up; all arrays have shape (n,)."""

    count: Whole
    """Collisions of the burst."""
    shortest_s: Floats
    """Shortest time from one of them to the next; inf if there are fewer than two."""
    last_s: Floats
    """Time of the last one."""
    turn_s: Floats
    """When the cylinder, driven back, turns round; inf if it never does."""
    endless: Flags
    """Whether bodies came to rest on each other in ever smaller bounces, or collided more often
    than was asked for. Then ``simulator`` has followed them, or there is no count but -1."""


def simulate_many(setups: ManySetups, most: int | None = None) -> ManyBursts:
    """Run all trials to the end of their bursts.

    Parameters
    ----------
    most
        Leave trials with more collisions than this, and those in which bodies come to rest on each
        other, without a count. None to follow each, by ``simulator``, which takes long for many.

    Raises
    ------
    UsageError
        If a trial that is followed to its end has more than ``MOST_COLLISIONS``.
    """
    size = len(setups)
    found = ManyBursts(
        count=np.zeros(size, np.int64),
        shortest_s=np.full(size, np.inf),
        last_s=np.full(size, np.nan),
        turn_s=np.full(size, np.inf),
        endless=np.zeros(size, np.bool_),
    )
    _follow(setups, found, MOST_COLLISIONS if most is None else most)
    for row in np.flatnonzero(found.endless):
        if most is None:
            _follow_one(setups, found, int(row))
        else:
            found.count[row] = NO_COUNT
            found.shortest_s[row], found.turn_s[row] = np.nan, np.nan
    return found


def _check(setups: ManySetups) -> None:
    """Refuse what the loop cannot follow."""
    positive = ("mass_ratio", "wall_gap_m", "release_m", "heavy_thread_m", "light_thread_m")
    for name in positive:
        column = getattr(setups, name)
        if not (np.isfinite(column) & (column > 0)).all():
            raise UsageError(f"{name} must be a finite number greater than 0")
    for name in ("restitution_bodies", "restitution_wall"):
        column = getattr(setups, name)
        if not ((column >= 0) & (column <= 1)).all():
            raise UsageError(f"{name} must lie between 0 and 1")
    longest_m = np.maximum(setups.heavy_thread_m, setups.light_thread_m)
    swinging = (setups.damping_per_s >= 0) & (setups.damping_per_s**2 * longest_m < GRAVITY_M_S2)
    if not swinging.all():
        raise UsageError("damping_per_s must not be negative, nor so large that nothing swings")
    if not (np.isfinite(setups.restitution_sd) & (setups.restitution_sd >= 0)).all():
        raise UsageError("restitution_sd must not be negative")


def _follow_one(setups: ManySetups, found: ManyBursts, row: int) -> None:
    """Fill in a row by the event-driven simulator."""
    motion = simulate(setups.one(row), seed=int(setups.seed[row]))
    times = np.array([bounce.time_s for bounce in motion.burst])
    found.count[row] = motion.count
    found.shortest_s[row] = np.diff(times).min(initial=np.inf)
    found.last_s[row] = times[-1] if len(times) else np.nan
    found.turn_s[row] = motion.burst_end_s


def _follow(setups: ManySetups, found: ManyBursts, most: int) -> None:
    """Follow all rows from event to event; the arrays of ``found`` are filled in."""
    rows = np.arange(len(setups))
    heavy, light = _pendulums(setups)
    slow = RESTING_FRACTION * setups.release_m * heavy.natural_rad_s
    limit = LONGEST_BURST_PERIODS * 2.0 * np.pi / heavy.damped_rad_s
    numbers = _Scatter(setups)
    zeros = np.zeros(len(setups))
    state = States(zeros, setups.wall_gap_m + setups.release_m, zeros, setups.wall_gap_m, zeros)
    lasting = np.ones(len(setups), np.bool_)
    while lasting.any():
        if lasting.mean() < 1.0 - _FINISHED_SHARE:
            rows, state, lasting = rows[lasting], state.take(lasting), lasting[lasting]
        laws = heavy.take(rows), light.take(rows)
        turn_s = laws[0].turning_s(state.heavy, state.heavy_velocity)
        flight_s, at_wall = next_contact(laws, state, turn_s, lasting)
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
        state = _bounced(setups.mass_ratio[rows], arrived, at_wall, approach, bounce)


def _note(found: ManyBursts, rows: Whole, time_s: Floats) -> None:
    """Count one collision more for some rows."""
    since = time_s - found.last_s[rows]
    known = np.where(np.isnan(since), np.inf, since)
    found.shortest_s[rows] = np.minimum(found.shortest_s[rows], known)
    found.last_s[rows] = time_s
    found.count[rows] += 1


class _Scatter:
    """Restitution of each bounce: the n-th bounce of a set-up gets its seed's n-th number."""

    def __init__(self, setups: ManySetups) -> None:
        self._setups = setups
        self._scattered = bool(setups.restitution_sd.any())
        self._rngs: list[np.random.Generator] = []
        self._numbers = np.empty((len(setups), 0))
        if self._scattered:
            self._rngs = [np.random.default_rng(int(seed)) for seed in setups.seed]

    def restitution(self, rows: Whole, number: Whole, at_wall: Flags) -> Floats:
        """Restitution of the bounce of each row, of which ``number`` have gone before."""
        setups = self._setups
        mean = np.where(at_wall, setups.restitution_wall[rows], setups.restitution_bodies[rows])
        if not self._scattered:
            return mean
        while number.max(initial=0) >= self._numbers.shape[1]:
            block = np.stack([rng.standard_normal(_BLOCK) for rng in self._rngs])
            self._numbers = np.concatenate([self._numbers, block], axis=1)
        drawn = mean + setups.restitution_sd[rows] * self._numbers[rows, number]
        return np.asarray(np.clip(drawn, 0.0, 1.0))


def _pendulums(setups: ManySetups) -> tuple[Swings, Swings]:
    """Cylinder and ball, both of which hang straight where they touch: at the gap."""
    gamma = setups.damping_per_s
    pair: list[Swings] = []
    for thread_m in (setups.heavy_thread_m, setups.light_thread_m):
        stiffness = GRAVITY_M_S2 / thread_m
        omega = np.sqrt(stiffness - gamma * gamma)
        pair.append(Swings(setups.wall_gap_m, np.sqrt(stiffness), gamma, omega))
    return pair[0], pair[1]


def _arrived(
    laws: tuple[Swings, Swings], state: States, flight_s: Floats, at_wall: Flags
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

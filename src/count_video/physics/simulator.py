"""Whole trials: every collision, where the first burst ends, the state at any time.

Where bodies come to rest on each other, which would end the alternation of flights and bounces, a
trial ends and has no count.

The small-angle pendulums are linear, so that lengths scale: with gap and release multiplied by one
factor all times, counts and ratios of velocities stay the same.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from count_video.errors import UsageError
from count_video.physics.events import Run, Step, laws_of
from count_video.physics.laws import Whole
from count_video.physics.setup import Setup
from count_video.records import CollisionKind, Floats

NO_COUNT = -1
LONGEST_BURST_PERIODS = 10.0
"""A suspended trial whose burst has not ended after so many heavy periods is left there (the
cylinder never reaches the ball, or never turns)."""
MOST_COLLISIONS = 20_000
"""A trial with more is ended; at a mass ratio of a million there are 3141 without losses."""


@dataclass(frozen=True, slots=True)
class SimulatedCollision:
    """One bounce, exactly; velocities are positive away from the wall."""

    time_s: float
    kind: CollisionKind
    heavy_before_m_s: float
    heavy_after_m_s: float
    light_before_m_s: float
    light_after_m_s: float
    restitution: float
    """Relative speed after over before, as drawn for this bounce."""


@dataclass(frozen=True)
class Sample:
    """State at given times; all arrays have shape (n,)."""

    heavy_face_m: Floats
    """The cylinder's face turned to the ball."""
    heavy_velocity_m_s: Floats
    ball_far_face_m: Floats
    """The ball's wall-side face; 0 where it touches the wall."""
    ball_velocity_m_s: Floats
    ball_diameter_m: float

    @property
    def ball_near_face_m(self) -> Floats:
        """The ball's face turned to the cylinder; equal to ``heavy_face_m`` in contact."""
        return self.ball_far_face_m + self.ball_diameter_m


@dataclass(frozen=True)
class Motion:
    """A simulated trial."""

    setup: Setup
    seed: int
    until_s: float
    """Simulated up to here; inf when nothing more can ever happen."""
    collisions: tuple[SimulatedCollision, ...]
    """All bounces up to ``until_s``, in order of time."""
    burst_end_s: float
    """When the cylinder, driven back, turns round again; inf if not reached."""
    endless: bool
    """Whether bodies came to rest on each other in ever smaller bounces, or collided more often
    than was asked for, at ``until_s``."""
    events: Floats = field(compare=False, repr=False)
    """State after each event, the start first: time, the cylinder's face less a ball diameter, its
    velocity, the ball's wall-side face, its velocity; shape (events, 5)."""

    @property
    def burst(self) -> tuple[SimulatedCollision, ...]:
        """The collisions that count: those before the cylinder turns back toward the wall."""
        return tuple(bounce for bounce in self.collisions if bounce.time_s <= self.burst_end_s)

    @property
    def count(self) -> int:
        """Number of collisions of the burst; of an endless one those faster than a rest."""
        return len(self.burst)

    @property
    def shortest_s(self) -> float:
        """Shortest time from one collision of the burst to the next; inf if fewer than two."""
        times_s = [bounce.time_s for bounce in self.burst]
        return float(np.diff(times_s).min(initial=math.inf))

    def sample(self, times_s: Floats) -> Sample:
        """State at ``times_s``, shape (n,), exact; the run is continued if it is too short.

        Before time 0 a suspended trial is held at its start; a free cylinder comes in as it must
        have. At the very time of a collision the state after it is given. UsageError if a time is
        later than bodies came to rest on each other.
        """
        times = np.ascontiguousarray(times_s, dtype=np.float64)
        latest_s = float(times.max(initial=0.0))
        if latest_s > self.until_s:
            if self.endless:
                raise UsageError(
                    f"the bodies come to rest on each other after {self.until_s:g} s; show less of "
                    "the trial, or choose a higher restitution"
                )
            return simulate(self.setup, seed=self.seed, until_s=latest_s).sample(times)
        if self.setup.mounting == "suspended":
            times = np.maximum(times, 0.0)
        rows = np.maximum(np.searchsorted(self.events[:, 0], times, side="right") - 1, 0)
        start_s, heavy, heavy_velocity, ball, ball_velocity = self.events[rows].T
        heavy_law, ball_law = laws_of([self.setup])
        since_s, diameter_m = times - start_s, self.setup.ball_diameter_m
        rise, heavy_now = heavy_law.advance(heavy, heavy_velocity, since_s)
        climb, ball_now = ball_law.advance(ball, ball_velocity, since_s)
        return Sample(heavy + rise + diameter_m, heavy_now, ball + climb, ball_now, diameter_m)


@dataclass(frozen=True)
class ManyBursts:
    """What became of each of n trials; all arrays have shape (n,)."""

    count: Whole
    """Collisions of the burst; ``NO_COUNT`` where that is endless, as in ``Motion``."""
    shortest_s: Floats
    """Shortest time from one of them to the next; inf if there are fewer than two, NaN without a
    count."""


def simulate(
    setup: Setup, *, seed: int = 0, until_s: float | None = None, most: int = MOST_COLLISIONS
) -> Motion:
    """Run a trial from its start.

    ``seed`` is that of the scatter of the restitution. It stops after ``until_s``, which is finite
    for a suspended trial; by default that runs half a heavy period beyond the end of its burst, a
    free one until nothing more can happen. One with more than ``most`` collisions is endless.
    """
    run = Run([setup], [seed])
    period_s = float(run.heavy.law.period_s[0])
    limit_s = LONGEST_BURST_PERIODS * period_s if until_s is None else until_s
    events, collisions = [run.events()], list[SimulatedCollision]()
    burst_end_s, endless = math.inf, False
    while True:
        step = run.step()
        time_s = float(run.time_s[0])
        if step.never[0]:
            limit_s = math.inf
        if step.turned[0] and collisions and burst_end_s == math.inf and time_s <= limit_s:
            burst_end_s = time_s
            limit_s = time_s + 0.5 * period_s if until_s is None else limit_s
        if step.never[0] or time_s > limit_s:
            break
        if step.resting[0] or len(collisions) >= most:
            limit_s, endless = time_s, True
            break
        events.append(run.events())
        if step.met[0]:
            collisions.append(_collision(run, step))
    states = np.concatenate(events)
    return Motion(setup, seed, limit_s, tuple(collisions), burst_end_s, endless, states)


def simulate_many(
    setups: Sequence[Setup], most: int = MOST_COLLISIONS, seeds: Sequence[int] | None = None
) -> ManyBursts:
    """Run n suspended trials to the end of their bursts.

    Those with more than ``most`` collisions are endless. ``seeds`` are those of the scatter of the
    restitution, n of them; None: 0 for all.
    """
    size = len(setups)
    run = Run(setups, [0] * size if seeds is None else seeds)
    limit_s = LONGEST_BURST_PERIODS * run.heavy.law.period_s
    count = np.zeros(size, np.int64)
    shortest_s, last_s = np.full(size, np.inf), np.full(size, np.nan)
    while run.rows.size:
        rows, step = run.rows, run.step()
        late = ~step.never & (run.time_s > limit_s[rows])
        endless = ~late & (step.resting | (step.met & (count[rows] >= most)))
        ended = step.never | late | endless | (step.turned & (count[rows] > 0))
        hit = step.met & ~ended
        here, now_s = rows[hit], run.time_s[hit]
        shortest_s[here] = np.fmin(shortest_s[here], now_s - last_s[here])  # first: NaN
        last_s[here] = now_s
        count[here] += 1
        count[rows[endless]], shortest_s[rows[endless]] = NO_COUNT, np.nan
        run.keep(~ended)
    return ManyBursts(count, shortest_s)


def varied(setup: Setup, **columns: ArrayLike) -> list[Setup]:
    """Return a set-up with other values of some fields: numbers, or arrays of one shape (n,).

    UsageError if a value is out of its range.
    """
    rows = np.column_stack(np.broadcast_arrays(*map(np.atleast_1d, columns.values())))
    return [replace(setup, **dict(zip(columns, row, strict=True))) for row in rows.tolist()]


def _collision(run: Run, step: Step) -> SimulatedCollision:
    """Describe the bounce of a single trial."""
    return SimulatedCollision(
        time_s=float(run.time_s[0]),
        kind="wall" if step.at_wall[0] else "bodies",
        heavy_before_m_s=float(step.heavy_before_m_s[0]),
        heavy_after_m_s=float(run.heavy.velocity_m_s[0]),
        light_before_m_s=float(step.ball_before_m_s[0]),
        light_after_m_s=float(run.ball.velocity_m_s[0]),
        restitution=float(step.restitution[0]),
    )

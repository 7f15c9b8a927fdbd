"""A whole trial: every collision, where the first burst ends, and the state at any time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from count_video.errors import UsageError
from count_video.physics.engine import (
    Anchor,
    Restitution,
    SimulatedCollision,
    events,
    settle,
    states_at,
)
from count_video.physics.flights import Pendulum
from count_video.physics.setup import Apparatus, Hold, Setup, build_apparatus
from count_video.records import CollisionKind, Floats

LONGEST_BURST_PERIODS = 10.0
"""A suspended trial whose burst has not ended after so many heavy periods is left there (the
cylinder never reaches the ball, or leans on the wall and stays)."""
MOST_COLLISIONS = 1_000_000
"""A trial with more is refused before it fills the memory."""
CONTACT_AT_START_M = 1e-12
"""Bodies closer than this at time 0 touch: no more than a rounding of the sum of the gaps."""
_BLOCK = 256
"""Random numbers are drawn so many at a time; it does not change their sequence."""


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
    anchors: tuple[Anchor, ...]
    """State after each event, the start first."""

    @property
    def burst(self) -> tuple[SimulatedCollision, ...]:
        """The collisions that count: those before the cylinder turns back toward the wall."""
        return tuple(bounce for bounce in self.collisions if bounce.time_s <= self.burst_end_s)

    @property
    def after_burst(self) -> tuple[SimulatedCollision, ...]:
        """The collisions after that."""
        return tuple(bounce for bounce in self.collisions if bounce.time_s > self.burst_end_s)

    @property
    def count(self) -> int:
        """Number of collisions of the burst.

        Very inelastic bodies (free, 1:100: restitution below about 0.83) collapse onto the wall in
        infinitely many bounces; then this is how many were faster than a resting contact.
        """
        return len(self.burst)

    @property
    def shortest_s(self) -> float:
        """Shortest time from one collision of the burst to the next; inf if fewer than two."""
        times_s = [bounce.time_s for bounce in self.burst]
        return float(np.diff(times_s).min(initial=math.inf))

    def sample(self, times_s: Floats) -> Sample:
        """State at ``times_s``, shape (n,), exact; the run is continued if it is too short.

        Before time 0 a suspended trial is held at its start; a free or sliding cylinder comes in
        as it must have. At the very time of a collision the state after it is given.

        Raises
        ------
        UsageError
            If a time is not finite.
        """
        times = np.ascontiguousarray(times_s, dtype=np.float64)
        if not np.isfinite(times).all():
            raise UsageError("cannot sample a motion at a time that is not finite; drop those")
        latest_s = float(times.max(initial=0.0))
        if latest_s > self.until_s:
            return extend(self, latest_s).sample(times)
        if self.setup.mounting == "suspended":
            times = np.maximum(times, self.anchors[0].time_s)
        states = states_at(build_apparatus(self.setup), self.anchors, times)
        diameter_m = self.setup.ball_diameter_m
        return Sample(states[0] + diameter_m, states[1], states[2], states[3], diameter_m)


def simulate(setup: Setup, *, seed: int = 0, until_s: float | None = None) -> Motion:
    """Run a trial from its start.

    Parameters
    ----------
    setup
        The apparatus and the start.
    seed
        Of the scatter of the restitution; without scatter it changes nothing.
    until_s
        Stop after this time. By default a suspended trial runs half a heavy period beyond the end
        of its burst; a free or sliding one until nothing more can happen.

    Raises
    ------
    UsageError
        If ``until_s`` is not a time, or there are more than ``MOST_COLLISIONS`` until then.
    """
    ball_m = setup.ball_start_m
    heavy_m = setup.wall_gap_m + setup.bodies_gap_m + setup.release_m
    if abs(heavy_m - ball_m) < CONTACT_AT_START_M:
        heavy_m = ball_m
    start = Anchor(0.0, heavy_m, setup.heavy_velocity_m_s, ball_m, 0.0, Hold.APART)
    settled = settle(build_apparatus(setup), start)
    still = Motion(setup, seed, -math.inf, (), math.inf, (settled,))
    return _run(still, None) if until_s is None else extend(still, until_s)


def extend(motion: Motion, until_s: float) -> Motion:
    """Continue a trial to a later time; the result is the same to the bit as one long run.

    Raises
    ------
    UsageError
        As for ``simulate``.
    """
    endless = math.isinf(until_s) and motion.setup.mounting == "suspended"
    if math.isnan(until_s) or until_s < 0 or endless:
        raise UsageError(f"cannot simulate until {until_s} s; give a finite time from 0 on")
    return motion if until_s <= motion.until_s else _run(motion, until_s)


def _run(motion: Motion, until_s: float | None) -> Motion:
    """Follow the events from the last anchor to ``until_s`` or to the natural end."""
    setup = motion.setup
    apparatus = build_apparatus(setup)
    anchors, collisions = list(motion.anchors), list(motion.collisions)
    burst_end_s = motion.burst_end_s
    half_period_s = _half_period_s(apparatus)
    limit_s = 2.0 * LONGEST_BURST_PERIODS * half_period_s if until_s is None else until_s
    draw = draw_restitutions(setup, motion.seed, len(collisions))
    for anchor, impact in events(apparatus, anchors[-1], draw):
        if burst_end_s == math.inf and collisions:
            burst_end_s = _turning_s(apparatus, anchors[-1], min(anchor.time_s, limit_s))
            if until_s is None and burst_end_s < math.inf:
                limit_s = burst_end_s + half_period_s
        if anchor.time_s > limit_s:
            break
        anchors.append(anchor)
        if impact is not None:
            collisions.append(impact)
            _check_number(collisions)
    else:
        limit_s = math.inf
    return Motion(setup, motion.seed, limit_s, tuple(collisions), burst_end_s, tuple(anchors))


def _turning_s(apparatus: Apparatus, anchor: Anchor, limit_s: float) -> float:
    """When the cylinder turns toward the wall in the flight from ``anchor``; inf if not by then."""
    heavy_law, _ = apparatus.laws(anchor.hold)
    turn_s = anchor.time_s + heavy_law.turning_s(anchor.heavy_m, anchor.heavy_velocity_m_s)
    return turn_s if turn_s <= limit_s else math.inf


def draw_restitutions(setup: Setup, seed: int, skip: int) -> Restitution:
    """Return a function that draws one restitution a bounce, going on after ``skip`` bounces.

    One normal number is used for each bounce whatever its kind, so the n-th bounce gets the n-th
    number of the seed's sequence however the run is cut into pieces.
    """
    mean = {"bodies": setup.restitution_bodies, "wall": setup.restitution_wall}
    scatter = {"bodies": setup.restitution_bodies_sd, "wall": setup.restitution_wall_sd}
    if not any(scatter.values()):
        return mean.__getitem__
    rng = np.random.default_rng(seed)
    rng.standard_normal(skip)
    numbers: list[float] = []

    def draw(kind: CollisionKind) -> float:
        if not numbers:
            numbers.extend(rng.standard_normal(_BLOCK)[::-1].tolist())
        return min(1.0, max(0.0, mean[kind] + scatter[kind] * numbers.pop()))

    return draw


def _check_number(collisions: list[SimulatedCollision]) -> None:
    if len(collisions) > MOST_COLLISIONS:
        raise UsageError(
            f"more than {MOST_COLLISIONS} collisions within {collisions[-1].time_s:g} s; "
            "choose a smaller mass ratio, a lower restitution or an earlier until_s"
        )


def _half_period_s(apparatus: Apparatus) -> float:
    """Half a swing of the cylinder; inf where nothing swings."""
    heavy = apparatus.heavy
    return 0.5 * heavy.period_s if isinstance(heavy, Pendulum) else math.inf

"""A whole trial: every collision, where the first burst ends, and the state at any time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from count_video.errors import UsageError
from count_video.physics.engine import Anchor, Impact, events, settle
from count_video.physics.flights import Pendulum
from count_video.physics.mountings import Apparatus, Hold, build_apparatus
from count_video.physics.scatter import draw_restitutions
from count_video.physics.setup import Setup
from count_video.records import CollisionKind, Floats

LONGEST_BURST_PERIODS = 10.0
"""A suspended trial whose burst has not ended after so many heavy periods is left there (the
cylinder never reaches the ball, or leans on the wall and stays)."""
MOST_COLLISIONS = 1_000_000
"""A trial with more is refused before it fills the memory."""
CONTACT_AT_START_M = 1e-12
"""Bodies closer than this at time 0 touch: no more than a rounding of the sum of the gaps."""


@dataclass(frozen=True, slots=True)
class SimulatedCollision:
    """One bounce, exactly; velocities are positive away from the wall."""

    time_s: float
    kind: CollisionKind
    heavy_before_m_s: float
    heavy_after_m_s: float
    light_before_m_s: float
    light_after_m_s: float
    energy_after_j: float
    """Kinetic energy of both bodies and, on threads, their potential energy above rest."""
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
        rows = np.maximum(np.searchsorted(self._anchor_times_s, times, side="right") - 1, 0)
        tau_s = times - self._anchor_times_s[rows]
        if self.setup.mounting == "suspended":
            tau_s = np.maximum(tau_s, 0.0)
        states, holds = self._anchor_states[:, rows], self._anchor_holds[rows]
        apparatus = build_apparatus(self.setup)
        for hold in self._holds_used:
            part = holds == hold
            states[:, part] = _advance_states(apparatus, hold, states[:, part], tau_s[part])
        diameter_m = self.setup.ball_diameter_m
        return Sample(states[0] + diameter_m, states[1], states[2], states[3], diameter_m)

    @cached_property
    def _anchor_times_s(self) -> Floats:
        return np.array([anchor.time_s for anchor in self.anchors])

    @cached_property
    def _anchor_states(self) -> Floats:
        """Shape (4, anchors): position and velocity of the cylinder, then of the ball."""
        return np.array([anchor[1:5] for anchor in self.anchors], dtype=np.float64).T.copy()

    @cached_property
    def _holds_used(self) -> tuple[Hold, ...]:
        return tuple({anchor.hold for anchor in self.anchors})

    @cached_property
    def _anchor_holds(self) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
        return np.array([int(anchor.hold) for anchor in self.anchors], dtype=np.int64)


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
            collisions.append(_record(apparatus, anchor, impact))
            _check_number(collisions)
    else:
        limit_s = math.inf
    return Motion(setup, motion.seed, limit_s, tuple(collisions), burst_end_s, tuple(anchors))


def _advance_states(apparatus: Apparatus, hold: Hold, states: Floats, tau_s: Floats) -> Floats:
    """Carry states, shape (4, n), along their flights by ``tau_s``, shape (n,)."""
    heavy_law, ball_law = apparatus.laws(hold)
    heavy_m, heavy_velocity, ball_m, ball_velocity = states
    heavy_rise, heavy_now = heavy_law.advance_many(heavy_m, heavy_velocity, tau_s)
    ball_rise, ball_now = ball_law.advance_many(ball_m, ball_velocity, tau_s)
    return np.stack([heavy_m + heavy_rise, heavy_now, ball_m + ball_rise, ball_now])


def _turning_s(apparatus: Apparatus, anchor: Anchor, limit_s: float) -> float:
    """When the cylinder turns toward the wall in the flight from ``anchor``; inf if not by then."""
    heavy_law, _ = apparatus.laws(anchor.hold)
    turn_s = anchor.time_s + heavy_law.turning_s(anchor.heavy_m, anchor.heavy_velocity_m_s)
    return turn_s if turn_s <= limit_s else math.inf


def _record(apparatus: Apparatus, anchor: Anchor, impact: Impact) -> SimulatedCollision:
    heavy_after, ball_after = impact.heavy_after_m_s, impact.ball_after_m_s
    return SimulatedCollision(
        time_s=anchor.time_s,
        kind=impact.kind,
        heavy_before_m_s=impact.heavy_before_m_s,
        heavy_after_m_s=heavy_after,
        light_before_m_s=impact.ball_before_m_s,
        light_after_m_s=ball_after,
        energy_after_j=apparatus.energy_j(anchor.heavy_m, heavy_after, anchor.ball_m, ball_after),
        restitution=impact.restitution,
    )


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

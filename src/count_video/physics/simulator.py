"""A whole trial: every collision, where the first burst ends, and the state at any time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from count_video.physics.engine import Anchor, Impact, Restitution, events, settle
from count_video.physics.mountings import Apparatus, Hold, build_apparatus
from count_video.physics.setup import Setup
from count_video.records import CollisionKind, Floats

LONGEST_BURST_PERIODS = 10.0
"""A suspended trial whose burst has not ended after so many heavy periods is left there (the
cylinder never reaches the ball, or leans on the wall and stays)."""
_BLOCK = 256


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
        return tuple(c for c in self.collisions if c.time_s <= self.burst_end_s)

    @property
    def after_burst(self) -> tuple[SimulatedCollision, ...]:
        """The collisions after that."""
        return tuple(c for c in self.collisions if c.time_s > self.burst_end_s)

    @property
    def count(self) -> int:
        """Number of collisions of the burst."""
        return len(self.burst)

    def sample(self, times_s: Floats) -> Sample:
        """State at ``times_s``, shape (n,), exact; the run is continued if it is too short.

        Before time 0 a suspended trial is held at its start; a free or sliding cylinder comes in
        on a straight line. At the very time of a collision the state after it is given.
        """
        times = np.ascontiguousarray(times_s, dtype=np.float64)
        if times.size and float(times.max()) > self.until_s:
            return extend(self, float(times.max())).sample(times)
        rows = np.maximum(np.searchsorted(self._anchor_times_s, times, side="right") - 1, 0)
        tau_s = times - self._anchor_times_s[rows]
        if self.setup.mounting == "suspended":
            tau_s = np.maximum(tau_s, 0.0)
        heavy_m, heavy_v, ball_m, ball_v = self._anchor_states[:, rows]
        apparatus = build_apparatus(self.setup)
        holds = self._anchor_holds[rows]
        for hold in set(holds.tolist()):
            part = holds == hold
            heavy_law, ball_law = apparatus.laws(Hold(hold))
            rise, heavy_v[part] = heavy_law.advance_many(heavy_m[part], heavy_v[part], tau_s[part])
            fall, ball_v[part] = ball_law.advance_many(ball_m[part], ball_v[part], tau_s[part])
            heavy_m[part] += rise
            ball_m[part] += fall
        diameter_m = self.setup.ball_diameter_m
        return Sample(heavy_m + diameter_m, heavy_v, ball_m, ball_v, diameter_m)

    @cached_property
    def _anchor_times_s(self) -> Floats:
        return np.array([anchor.time_s for anchor in self.anchors])

    @cached_property
    def _anchor_states(self) -> Floats:
        """Shape (4, anchors): position and velocity of the cylinder, then of the ball."""
        return np.array([anchor[1:5] for anchor in self.anchors], dtype=np.float64).T.copy()

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
    """
    start = settle(
        build_apparatus(setup),
        Anchor(
            0.0,
            setup.heavy_start_m - setup.ball_diameter_m,
            setup.heavy_velocity_m_s,
            setup.ball_start_m,
            0.0,
            Hold.APART,
        ),
    )
    still = Motion(setup, seed, 0.0, (), math.inf, (start,))
    return extend(still, until_s)


def extend(motion: Motion, until_s: float | None = None) -> Motion:
    """Continue a trial to a later time; the result is the same to the bit as one long run."""
    if until_s is not None and until_s <= motion.until_s:
        return motion
    setup = motion.setup
    apparatus = build_apparatus(setup)
    anchors, collisions = list(motion.anchors), list(motion.collisions)
    burst_end_s = motion.burst_end_s
    draw = _restitutions(setup, motion.seed, len(collisions))
    half_period_s = _half_period_s(setup)
    limit_s = 2.0 * LONGEST_BURST_PERIODS * half_period_s if until_s is None else until_s
    for anchor, impact in events(apparatus, anchors[-1], draw):
        before = anchors[-1]
        if burst_end_s == math.inf and collisions:
            burst_end_s = _turning_s(apparatus, before, min(anchor.time_s, limit_s))
            if until_s is None and burst_end_s < math.inf:
                limit_s = burst_end_s + half_period_s
        if anchor.time_s > limit_s:
            break
        anchors.append(anchor)
        if impact is not None:
            collisions.append(_record(apparatus, anchor, impact))
    else:
        limit_s = math.inf
    return Motion(setup, motion.seed, limit_s, tuple(collisions), burst_end_s, tuple(anchors))


def _turning_s(apparatus: Apparatus, anchor: Anchor, limit_s: float) -> float:
    """When the cylinder turns toward the wall in the flight from ``anchor``; inf if not by then."""
    heavy_law, _ = apparatus.laws(anchor.hold)
    turn_s = anchor.time_s + heavy_law.turning_s(anchor.heavy_m, anchor.heavy_velocity_m_s)
    return turn_s if turn_s <= limit_s else math.inf


def _record(apparatus: Apparatus, anchor: Anchor, impact: Impact) -> SimulatedCollision:
    time_s, heavy_m, heavy_v, ball_m, ball_v, _ = anchor
    return SimulatedCollision(
        time_s=time_s,
        kind=impact.kind,
        heavy_before_m_s=impact.heavy_before_m_s,
        heavy_after_m_s=heavy_v,
        light_before_m_s=impact.ball_before_m_s,
        light_after_m_s=ball_v,
        energy_after_j=apparatus.energy_j(heavy_m, heavy_v, ball_m, ball_v),
        restitution=impact.restitution,
    )


def _half_period_s(setup: Setup) -> float:
    """Half a swing of the cylinder; inf where nothing swings."""
    if setup.mounting != "suspended":
        return math.inf
    natural = math.sqrt(setup.gravity_m_s2 / setup.heavy_thread_m)
    return math.pi / math.sqrt(natural**2 - setup.heavy_damping_per_s**2)


def _restitutions(setup: Setup, seed: int, skip: int) -> Restitution:
    """Draws one restitution a bounce, continuing after ``skip`` bounces.

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

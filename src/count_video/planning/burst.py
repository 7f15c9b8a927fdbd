"""One planned trial, event by event: what it counts and where and when things happen."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from count_video.errors import UsageError
from count_video.physics.many import simulate_many
from count_video.physics.simulator import Motion, simulate
from count_video.physics.theory import collision_count
from count_video.planning.request import PlanRequest, most_collisions, setups_at


@dataclass(frozen=True)
class PlannedBurst:
    """The burst of a planned trial; times in seconds from the release."""

    count: int
    theory: int
    """Exact count of free bodies without losses."""
    bodies: int
    """Collisions between the bodies; the others are with the wall."""
    shortest_s: float
    """Shortest time from one collision to the next; inf if there are fewer than two."""
    first_s: float
    last_s: float
    turn_s: float
    """When the cylinder, driven back, turns round and the count ends."""
    swing_back_m: float
    """How far beyond its rest the cylinder swings back."""
    last_m: float
    """From the wall to the ball's far face at the last collision."""
    last_speed_m_s: float
    """Speed at which the two close in on each other there."""
    smallest_hop_m: float
    """Shortest way of the ball between cylinder and wall; inf if it does not reach the wall."""
    intervals_s: tuple[float, ...]
    """From each collision to the next."""


def planned_motion(request: PlanRequest) -> Motion:
    """Simulate the planned trial, once, without scatter.

    Raises
    ------
    UsageError
        If the bodies lose so much that they come to rest on each other in ever smaller bounces.
    """
    theory = collision_count(request.heavy, request.light)
    gap, release = np.array([request.gap_m]), np.array([request.release_m])
    if simulate_many(setups_at(request, gap, release), most_collisions(theory)).endless[0]:
        raise UsageError(
            f"with a restitution of {request.restitution:g} the ball comes to rest between "
            "cylinder and wall in ever smaller bounces, of which there is no count; plan harder "
            "bodies or a smaller mass ratio"
        )
    return simulate(request.setup())


def planned_burst(request: PlanRequest, motion: Motion) -> PlannedBurst:
    """Read the answer off the simulated trial."""
    burst = motion.burst
    times = np.array([bounce.time_s for bounce in burst])
    turn_s = motion.burst_end_s
    sample = motion.sample(np.append(times, turn_s if np.isfinite(turn_s) else times[-1]))
    places = sample.ball_far_face_m[:-1]
    crossed = np.array([a.kind != b.kind for a, b in pairwise(burst)], dtype=bool)
    last = burst[-1]
    other = 0.0 if last.kind == "wall" else last.heavy_before_m_s
    return PlannedBurst(
        count=len(burst),
        theory=collision_count(request.heavy, request.light),
        bodies=sum(bounce.kind == "bodies" for bounce in burst),
        shortest_s=float(np.diff(times).min(initial=np.inf)),
        first_s=float(times[0]),
        last_s=float(times[-1]),
        turn_s=turn_s,
        swing_back_m=float(sample.heavy_face_m[-1]) - motion.setup.heavy_rest_m,
        last_m=float(places[-1]),
        last_speed_m_s=abs(last.light_before_m_s - other),
        smallest_hop_m=float(np.abs(np.diff(places))[crossed].min(initial=np.inf)),
        intervals_s=tuple(float(b - a) for a, b in pairwise(times)),
    )

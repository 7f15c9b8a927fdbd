from __future__ import annotations

import numpy as np
import pytest
from made_collisions import collision

from count_video.motion.burst import Burst
from count_video.motion.gaps import Gaps
from count_video.motion.reasons import Cause, Reason
from count_video.motion.resolution import (
    LONG_FLIGHT,
    UNEXPLAINED_SIGMAS,
    long_flights,
    shortest_interval,
    unexplained,
    unresolved,
)
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.records import Collision


def candidates_at(frames: list[float]) -> list[Collision]:
    return [collision(("bodies", "wall")[n % 2], frame) for n, frame in enumerate(frames)]


def burst_frames(seed: int, fps: float = 6000.0) -> list[float]:
    rng = np.random.default_rng(seed)
    setup = Setup(
        heavy_mass_kg=0.0105 * float(rng.uniform(30, 250)),
        wall_gap_m=float(rng.uniform(0.01, 0.07)),
        restitution_bodies=float(rng.uniform(0.9, 1.0)),
        restitution_wall=float(rng.uniform(0.9, 1.0)),
    )
    return [collision.time_s * fps for collision in simulate(setup, seed=seed).burst]


@pytest.mark.parametrize("seed", range(40))
def test_in_a_whole_burst_no_flight_is_long(seed: int) -> None:
    assert long_flights(candidates_at(burst_frames(seed))) == []


@pytest.mark.parametrize("seed", range(40))
def test_two_collisions_missed_in_the_middle_leave_a_long_flight(seed: int) -> None:
    frames = burst_frames(seed)
    middle = int(np.argmin(np.diff(frames)))
    left = frames[:middle] + frames[middle + 2 :]

    ((before, after),) = long_flights(candidates_at(left))

    assert (before.frame, after.frame) == (frames[middle - 1], frames[middle + 2])
    assert after.frame - before.frame > LONG_FLIGHT * shortest_interval(candidates_at(left))


def test_too_few_flights_are_not_judged() -> None:
    assert long_flights(candidates_at([10.0, 50.0, 60.0])) == []
    assert long_flights([]) == []


def test_a_sharp_turn_without_a_contact_leaves_a_doubt() -> None:
    inside = candidates_at([10.0, 50.0, 60.0])
    clear, faint = (55.0, 2 * UNEXPLAINED_SIGMAS), (56.0, UNEXPLAINED_SIGMAS / 2)

    stated = unexplained([clear, faint], inside, Burst(3, None, np.inf, ()), 1.0)
    assert stated == [Reason(Cause.JUMPS_ELSEWHERE, (55.0,))]
    assert unexplained([faint], inside, Burst(3, None, np.inf, ()), 1.0) == []


def test_sharp_turns_before_the_burst_or_after_it_leave_none() -> None:
    inside = candidates_at([10.0, 50.0, 60.0])
    outside = [(5.0, 2 * UNEXPLAINED_SIGMAS), (95.0, 2 * UNEXPLAINED_SIGMAS)]

    assert unexplained(outside, inside, Burst(3, None, 90.0, ()), 1.0) == []


def swinging_back(seen: bool) -> Gaps:
    """A ball that leaves the wall, turns and comes back; the cylinder is far off, or not seen."""
    frame = np.arange(100.0)
    ball = 20.0 + 30.0 * np.abs(np.sin(np.pi * (frame - 20.0) / 60.0))
    touching = np.abs(frame - 50.0) > 45.0
    heavy = np.where(touching, ball + 20.0, 200.0 if seen else np.nan)
    zero = np.zeros(100)
    return Gaps(frame, ball, heavy, heavy - ball - 20.0, zero, zero, 1)


@pytest.mark.parametrize("seen", [True, False])
def test_a_turn_between_two_wall_collisions_counts_if_the_cylinder_is_seen_far_off(
    seen: bool,
) -> None:
    walls = [collision("wall", frame) for frame in (20.0, 80.0)]

    missing = unresolved(walls, swinging_back(seen), 1.0)

    assert all(reason.cause is Cause.BODY_MISSED for reason in missing)
    assert bool(missing) is not seen

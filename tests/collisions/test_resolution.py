from __future__ import annotations

import numpy as np
import pytest

from count_video.collisions.candidates import Candidate
from count_video.collisions.resolution import LONG_FLIGHT, long_flights, shortest_interval
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate


def candidates_at(frames: list[float]) -> list[Candidate]:
    kinds = ("bodies", "wall")
    return [Candidate(kinds[n % 2], f, f, 0.1, None) for n, f in enumerate(frames)]


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

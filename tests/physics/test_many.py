"""Many set-ups side by side, against one at a time."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from count_video.physics.setup import Setup
from count_video.physics.simulator import NO_COUNT, ManyBursts, simulate, simulate_many, varied
from tiers import rest_slow

ROUNDING = 1e-9
"""Times are sums of some dozens of flights, each found to 1e-14 of itself; near a graze the root of
a rounding of the gap remains, 1e-8 of a flight."""


def random_setups(number: int, seed: int) -> tuple[list[Setup], list[int]]:
    """Draw set-ups of all kinds, threads alike or not, with and without losses, and their seeds."""
    rng = np.random.default_rng(seed)

    def between(least: float, most: float) -> np.ndarray:
        return rng.uniform(least, most, number)

    def sometimes(plain: float, drawn: np.ndarray) -> np.ndarray:
        return np.where(rng.random(number) < 0.3, plain, drawn)

    release = between(0.02, 0.2)
    setups = varied(
        Setup(light_mass_kg=1.0),
        heavy_mass_kg=np.exp(between(0.0, np.log(250.0))),
        release_m=release,
        wall_gap_m=release * between(0.02, 1.0),
        bodies_gap_m=sometimes(0.0, release * between(-0.2, 0.5)),
        heavy_thread_m=sometimes(1.0, between(0.3, 2.0)),
        light_thread_m=sometimes(1.0, between(0.3, 2.0)),
        heavy_damping_per_s=sometimes(0.0, between(0.0, 0.5)),
        light_damping_per_s=sometimes(0.0, between(0.0, 0.5)),
        restitution_bodies=sometimes(1.0, between(0.85, 1.0)),
        restitution_wall=sometimes(1.0, between(0.85, 1.0)),
        restitution_bodies_sd=sometimes(0.0, between(0.0, 0.02)),
        restitution_wall_sd=sometimes(0.0, between(0.0, 0.02)),
    )
    return setups, rng.integers(2**40, size=number).tolist()


@pytest.mark.parametrize("number", rest_slow([200, 10_000]))
def test_random_set_ups_come_out_as_one_at_a_time(number: int) -> None:
    setups, seeds = random_setups(number, 1)
    found = simulate_many(setups, seeds=seeds)
    assert len(np.unique(found.count)) > 30  # they are of all kinds indeed
    assert np.mean(found.count == NO_COUNT) < 0.02
    for row in np.flatnonzero(found.count != NO_COUNT):
        motion = simulate(setups[row], seed=seeds[row])
        times = [bounce.time_s for bounce in motion.burst]
        assert found.count[row] == motion.count, setups[row]
        shortest = min((b - a for a, b in pairwise(times)), default=np.inf)
        assert found.shortest_s[row] == pytest.approx(shortest, rel=1e-6, abs=ROUNDING)


def test_it_does_not_matter_who_stands_beside_whom() -> None:
    setups, seeds = random_setups(300, 2)
    together = simulate_many(setups, seeds=seeds)
    turned = simulate_many(setups[::-1], seeds=seeds[::-1])
    assert same(together, turned, slice(None, None, -1))


def same(one: ManyBursts, other: ManyBursts, order: slice) -> bool:
    """Whether two runs are alike to the bit, in another order."""
    return all(
        np.array_equal(getattr(one, name), getattr(other, name)[order], equal_nan=True)
        for name in ManyBursts.__dataclass_fields__
    )


@pytest.mark.parametrize("factor", [0.1, 0.5, 3.0])
def test_lengths_scale_and_times_stay(factor: float) -> None:
    setups, seeds = random_setups(500, 3)
    scaled = [
        replace(
            setup,
            wall_gap_m=factor * setup.wall_gap_m,
            bodies_gap_m=factor * setup.bodies_gap_m,
            release_m=factor * setup.release_m,
        )
        for setup in setups
    ]
    before, after = (simulate_many(each, seeds=seeds) for each in (setups, scaled))
    assert np.array_equal(before.count, after.count)
    assert after.shortest_s == pytest.approx(before.shortest_s, rel=1e-6, abs=ROUNDING, nan_ok=True)


@pytest.mark.parametrize("light_thread_m", [0.3, 1.0, 2.0])
@pytest.mark.parametrize("gap_m", [0.03, 0.0899, 0.0901])
def test_a_cylinder_that_is_stopped_where_it_hangs_is_met_again(
    gap_m: float, light_thread_m: float
) -> None:
    # Equal bodies without losses exchange their velocities: the cylinder rests until the ball,
    # which may turn before the wall, comes back.
    setups = varied(
        Setup(heavy_mass_kg=1.0, light_mass_kg=1.0),
        heavy_thread_m=[1.0, 2.0],
        light_thread_m=light_thread_m,
        wall_gap_m=gap_m,
        release_m=0.09,
    )
    found = simulate_many(setups)
    assert found.count.tolist() == [simulate(setup).count for setup in setups]


def test_bodies_that_come_to_rest_on_each_other_are_left_without_a_count() -> None:
    # Cylinder and wall squeeze the ball to rest: (1 - e)^2 / 4 e exceeds m / M.
    found = simulate_many([Setup(restitution_bodies=0.7, restitution_wall=0.7)])
    assert found.count.tolist() == [NO_COUNT]
    assert np.isnan(found.shortest_s).all()


def test_more_collisions_than_asked_for_are_left_without_a_count() -> None:
    setups = varied(Setup(light_mass_kg=1.0, wall_gap_m=0.03), heavy_mass_kg=[16.0, 100.0])
    found = simulate_many(setups, most=20)
    assert found.count.tolist() == [12, NO_COUNT]
    assert np.isnan(found.shortest_s).tolist() == [False, True]

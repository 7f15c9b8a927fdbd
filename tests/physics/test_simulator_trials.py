from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from random_setups import free, sliding, suspended

from count_video.errors import UsageError
from count_video.physics import simulator
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate

TABLE_1 = Setup()
FREE = Setup(mounting="free", heavy_velocity_m_s=-1.0)
POSITION_ROUNDING = 1e-15
"""Of positions below a metre, after one flight."""


@pytest.mark.parametrize(
    ("wall_gap_m", "count"),
    [(0.01, 31), (0.02, 31), (0.03, 31), (0.04, 30), (0.05, 29), (0.07, 27)],
)
def test_equal_pendulums_count_less_the_farther_the_wall(wall_gap_m: float, count: int) -> None:
    assert simulate(replace(TABLE_1, wall_gap_m=wall_gap_m)).count == count


@pytest.mark.parametrize(("restitution", "count"), [(1.0, 31), (0.95, 32), (0.93, 33), (0.9, 37)])
def test_restitution_alone_raises_the_count_of_free_bodies(restitution: float, count: int) -> None:
    lossy = replace(FREE, restitution_bodies=restitution, restitution_wall=restitution)
    assert simulate(lossy).count == count


def test_the_default_setup_is_that_of_table_1() -> None:
    assert TABLE_1.heavy_mass_kg == pytest.approx(100 * TABLE_1.light_mass_kg)
    assert (TABLE_1.bodies_gap_m, TABLE_1.release_m, TABLE_1.wall_gap_m) == (0.0, 0.09, 0.07)
    start = simulate(TABLE_1).sample(np.zeros(1))
    assert start.heavy_face_m - start.ball_near_face_m == pytest.approx(0.09)
    assert start.ball_far_face_m == pytest.approx(0.07)


def test_the_first_collision_comes_after_a_quarter_of_a_swing() -> None:
    first = simulate(TABLE_1).collisions[0]
    natural = math.sqrt(TABLE_1.gravity_m_s2 / TABLE_1.heavy_thread_m)
    assert first.time_s == pytest.approx(math.pi / 2 / natural, rel=1e-12)
    assert first.heavy_before_m_s == pytest.approx(-TABLE_1.release_m * natural, rel=1e-12)
    assert (first.kind, first.light_before_m_s) == ("bodies", 0.0)


@given(suspended())
def test_the_burst_ends_where_the_cylinder_turns_back_to_the_wall(setup: Setup) -> None:
    motion = simulate(setup)
    assume(motion.burst_end_s < math.inf)
    # Where resonance puts a collision on the turn itself, the turn lasts no time.
    assume(all(abs(bounce.time_s - motion.burst_end_s) > 1e-6 for bounce in motion.collisions))
    around_s = motion.burst_end_s + np.array([-1e-7, 0.0, 1e-7])
    before, at, after = motion.sample(around_s).heavy_velocity_m_s
    assert before > 0 > after
    assert at == pytest.approx(0.0, abs=1e-14)
    between_s = np.linspace(motion.collisions[0].time_s, motion.burst_end_s, 2000)
    velocities = motion.sample(between_s).heavy_velocity_m_s
    driven_back = np.flatnonzero(velocities > 1e-12)[0]
    assert (velocities[driven_back:] > -1e-12).all()


@given(suspended())
def test_collisions_after_the_burst_are_kept_apart(setup: Setup) -> None:
    motion = simulate(setup)
    assert motion.burst + motion.after_burst == motion.collisions
    assert motion.count == len(motion.burst)
    assert all(bounce.time_s <= motion.burst_end_s for bounce in motion.burst)
    assert all(bounce.time_s > motion.burst_end_s for bounce in motion.after_burst)


def test_a_trial_runs_half_a_period_beyond_its_burst_by_default() -> None:
    motion = simulate(TABLE_1)
    half_period = math.pi / math.sqrt(TABLE_1.gravity_m_s2 / TABLE_1.heavy_thread_m)
    assert motion.until_s == pytest.approx(motion.burst_end_s + half_period)
    assert motion.after_burst


@given(suspended() | sliding() | free())
def test_collisions_are_seen_as_contacts_in_the_samples(setup: Setup) -> None:
    motion = simulate(setup)
    for kind in ("bodies", "wall"):
        times = np.array([bounce.time_s for bounce in motion.collisions if bounce.kind == kind])
        sample = motion.sample(times)
        gap = sample.ball_far_face_m
        if kind == "bodies":
            gap = sample.heavy_face_m - sample.ball_near_face_m
        # Two events closer than a rounding of the time share their time; 3 m/s is never passed.
        assert (np.abs(gap) <= POSITION_ROUNDING + 3.0 * np.spacing(times)).all()


def test_a_sample_at_a_collision_is_the_state_after_it() -> None:
    motion = simulate(TABLE_1)
    sample = motion.sample(np.array([bounce.time_s for bounce in motion.collisions]))
    after = [(bounce.heavy_after_m_s, bounce.light_after_m_s) for bounce in motion.collisions]
    np.testing.assert_array_equal(
        np.column_stack([sample.heavy_velocity_m_s, sample.ball_velocity_m_s]), after
    )


@given(suspended() | sliding() | free())
def test_bodies_never_pass_through_each_other_or_the_wall(setup: Setup) -> None:
    motion = simulate(setup)
    end = min(motion.until_s, motion.anchors[-1].time_s + 1.0)
    sample = motion.sample(np.linspace(0.0, end, 5000))
    assert (sample.heavy_face_m - sample.ball_near_face_m).min() > -POSITION_ROUNDING
    assert sample.ball_far_face_m.min() > -POSITION_ROUNDING


@given(free())
def test_a_ball_diameter_only_moves_the_cylinder_aside(setup: Setup) -> None:
    bigger = replace(setup, ball_diameter_m=setup.ball_diameter_m + 0.5)
    assert simulate(bigger).anchors == simulate(setup).anchors
    times = np.linspace(-0.1, 1.0, 50)
    sample, wide = simulate(setup).sample(times), simulate(bigger).sample(times)
    np.testing.assert_allclose(wide.heavy_face_m - sample.heavy_face_m, 0.5, rtol=1e-14)
    np.testing.assert_array_equal(wide.ball_far_face_m, sample.ball_far_face_m)


@given(free())
def test_a_floor_without_friction_is_no_floor(setup: Setup) -> None:
    assert simulate(replace(setup, mounting="floor")).anchors == simulate(setup).anchors


def test_friction_on_the_floor_costs_collisions() -> None:
    floor = replace(FREE, mounting="floor", heavy_velocity_m_s=-1.0, wall_gap_m=0.2)
    rough = replace(floor, heavy_friction=0.3, light_friction=0.3)
    assert simulate(rough).count < simulate(floor).count


def test_before_time_zero_a_free_cylinder_comes_in_and_a_hung_one_waits() -> None:
    times = np.array([-0.5, 0.0])
    free_sample = simulate(FREE).sample(times)
    assert free_sample.heavy_face_m[0] - free_sample.heavy_face_m[1] == pytest.approx(0.5)
    hung = simulate(TABLE_1).sample(times)
    assert hung.heavy_face_m[0] == hung.heavy_face_m[1] == pytest.approx(TABLE_1.heavy_start_m)


def test_a_cylinder_that_does_not_reach_the_ball_gives_no_burst() -> None:
    motion = simulate(replace(TABLE_1, bodies_gap_m=0.2))
    assert (motion.count, motion.burst_end_s) == (0, math.inf)


@given(st.integers(0, 2**32 - 1))
def test_the_seed_alone_decides_the_scatter(seed: int) -> None:
    setup = replace(TABLE_1, restitution_bodies=0.95, restitution_bodies_sd=0.02)
    drawn = [bounce.restitution for bounce in simulate(setup, seed=seed).collisions]
    assert drawn == [bounce.restitution for bounce in simulate(setup, seed=seed).collisions]
    assert drawn != [bounce.restitution for bounce in simulate(setup, seed=seed + 1).collisions]
    assert all(0.0 <= restitution <= 1.0 for restitution in drawn)


def test_the_scatter_has_the_asked_mean_and_spread() -> None:
    setup = replace(
        FREE,
        heavy_mass_kg=1e4,
        light_mass_kg=1.0,
        restitution_bodies=0.998,
        restitution_wall=0.9995,
    )
    mean, spread, trials = 0.998, 0.0004, 20
    setup = replace(setup, restitution_bodies_sd=spread)
    drawn = np.array(
        [
            bounce.restitution
            for seed in range(trials)
            for bounce in simulate(setup, seed=seed).collisions
            if bounce.kind == "bodies"
        ]
    )
    error = spread / math.sqrt(len(drawn))  # five standard errors of mean and of spread
    assert drawn.mean() == pytest.approx(mean, abs=5 * error)
    assert drawn.std() == pytest.approx(spread, abs=5 * error)
    walls = {bounce.restitution for bounce in simulate(setup).collisions if bounce.kind == "wall"}
    assert walls == {0.9995}


def test_too_many_collisions_are_refused_with_advice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulator, "MOST_COLLISIONS", 10)
    with pytest.raises(UsageError, match=r"more than 10 collisions within .* s; choose"):
        simulate(TABLE_1)

"""Trials as a whole: their counts, their ends, and their states between the collisions."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_trials import all_trials, trials

from count_video.errors import UsageError
from count_video.physics.events import RESTING_FRACTION
from count_video.physics.laws import Law
from count_video.physics.setup import Setup
from count_video.physics.simulator import Sample, simulate

TABLE_1 = Setup()
FREE = Setup(mounting="free", heavy_velocity_m_s=-1.0)


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


def test_the_burst_ends_where_the_cylinder_turns_back_to_the_wall() -> None:
    ended = [motion for motion in trials(hung=True, lossy=True) if motion.burst_end_s < math.inf]
    assert len(ended) > 30
    for motion in ended:
        around_s = motion.burst_end_s + np.array([-1e-7, 0.0, 1e-7])
        before, at, after = motion.sample(around_s).heavy_velocity_m_s
        assert before > 0 > after
        assert at == pytest.approx(0.0, abs=1e-14)
        between_s = np.linspace(motion.collisions[0].time_s, motion.burst_end_s, 2000)
        velocities = motion.sample(between_s).heavy_velocity_m_s
        driven_back = np.flatnonzero(velocities > 1e-12)[0]
        assert (velocities[driven_back:] > -1e-12).all()


def test_collisions_after_the_burst_are_kept_apart() -> None:
    for motion in trials(hung=True, lossy=True):
        after = motion.collisions[motion.count :]
        assert motion.burst + after == motion.collisions
        assert motion.count == len(motion.burst)
        assert all(bounce.time_s <= motion.burst_end_s for bounce in motion.burst)
        assert all(bounce.time_s > motion.burst_end_s for bounce in after)


def test_a_trial_runs_half_a_period_beyond_its_burst_by_default() -> None:
    motion = simulate(TABLE_1)
    half_period = math.pi / math.sqrt(TABLE_1.gravity_m_s2 / TABLE_1.heavy_thread_m)
    assert motion.until_s == pytest.approx(motion.burst_end_s + half_period)
    assert len(motion.collisions) > motion.count


def test_a_sample_at_a_collision_is_the_state_after_it() -> None:
    motion = simulate(TABLE_1)
    sample = motion.sample(np.array([bounce.time_s for bounce in motion.collisions]))
    after = [(bounce.heavy_after_m_s, bounce.light_after_m_s) for bounce in motion.collisions]
    np.testing.assert_array_equal(
        np.column_stack([sample.heavy_velocity_m_s, sample.ball_velocity_m_s]), after
    )


def test_before_time_zero_a_free_cylinder_comes_in_and_a_hung_one_waits() -> None:
    times = np.array([-0.5, 0.0])
    free_sample = simulate(FREE).sample(times)
    assert free_sample.heavy_face_m[0] - free_sample.heavy_face_m[1] == pytest.approx(0.5)
    hung = simulate(TABLE_1).sample(times)
    start_m = TABLE_1.heavy_rest_m + TABLE_1.release_m
    assert hung.heavy_face_m[0] == hung.heavy_face_m[1] == pytest.approx(start_m)


def test_a_cylinder_that_does_not_reach_the_ball_gives_no_burst() -> None:
    motion = simulate(replace(TABLE_1, bodies_gap_m=0.2))
    assert (motion.count, motion.burst_end_s) == (0, math.inf)


def test_everything_at_rest_stays_at_rest() -> None:
    still = simulate(Setup(release_m=0.0), until_s=100.0)
    assert (still.collisions, still.until_s) == ((), math.inf)


# ---- ends and pieces -----------------------------------------------------------------------------


def bits(*samples: Sample) -> bytes:
    """Every number of samples in a row, as it stands in memory."""
    names = ("heavy_face_m", "heavy_velocity_m_s", "ball_far_face_m", "ball_velocity_m_s")
    parts = [np.concatenate([getattr(each, name) for each in samples]) for name in names]
    return np.stack(parts).tobytes()


def test_a_later_end_does_not_change_what_came_before() -> None:
    for motion in all_trials()[::4]:
        whole = simulate(motion.setup, seed=motion.seed, until_s=1.5)
        for stop_s in (0.0, 0.4, 0.9):
            part = simulate(motion.setup, seed=motion.seed, until_s=stop_s)
            assert part.collisions == tuple(c for c in whole.collisions if c.time_s <= stop_s)
            assert part.burst_end_s in (whole.burst_end_s, math.inf)
            assert part.events.tobytes() == whole.events[: len(part.events)].tobytes()


def test_sampling_beyond_the_run_continues_it() -> None:
    times = np.linspace(0.0, 1.5, 100)
    for motion in all_trials()[::8]:
        short = simulate(motion.setup, seed=motion.seed, until_s=0.3)
        whole = simulate(motion.setup, seed=motion.seed, until_s=1.5)
        assert bits(short.sample(times)) == bits(whole.sample(times))


@given(st.lists(st.floats(0.0, 1.5), max_size=300), st.data())
@settings(max_examples=30)
def test_sampling_in_pieces_gives_the_same_bits(times: list[float], data: st.DataObject) -> None:
    motion = data.draw(st.sampled_from(all_trials()))
    cuts = data.draw(st.lists(st.integers(0, len(times)), max_size=5).map(sorted))
    pieces = [motion.sample(piece) for piece in np.split(np.array(times), cuts)]
    assert bits(*pieces) == bits(motion.sample(np.array(times)))


def test_a_collision_at_time_zero_belongs_to_the_shortest_run() -> None:
    touching = Setup(mounting="free", heavy_velocity_m_s=-1.0, release_m=0.0)
    first = simulate(touching, until_s=0.0).collisions
    assert [bounce.time_s for bounce in first] == [0.0]


def test_free_bodies_run_to_the_end_of_time() -> None:
    setup = Setup(mounting="free", heavy_velocity_m_s=-1.0)
    assert simulate(setup, until_s=math.inf) == simulate(setup)
    assert simulate(setup).until_s == math.inf


# ---- losses --------------------------------------------------------------------------------------


@pytest.mark.parametrize("mounting", ["free", "suspended"])
def test_bodies_that_come_to_rest_on_each_other_end_the_trial(mounting: str) -> None:
    # Cylinder and wall squeeze the ball to rest: (1 - e)^2 / 4 e exceeds m / M.
    speed = 0.0 if mounting == "suspended" else -1.0
    setup = Setup(
        mounting=mounting,  # type: ignore[arg-type]
        heavy_velocity_m_s=speed,
        restitution_bodies=0.6,
        restitution_wall=0.6,
    )
    motion = simulate(setup)
    assert motion.endless
    assert motion.until_s < 2.0
    assert motion.sample(np.array([motion.until_s])).ball_far_face_m < 1e-6
    with pytest.raises(UsageError, match="come to rest on each other after"):
        motion.sample(np.array([motion.until_s + 0.1]))


def test_a_bouncing_ball_rests_after_the_hops_that_the_geometric_law_allows() -> None:
    # A ball beside a cylinder as heavy as a wall, whose thread keeps it there.
    setup = Setup(heavy_mass_kg=1e12, light_mass_kg=1.0, wall_gap_m=0.05, restitution_bodies=0.5)
    setup = replace(setup, bodies_gap_m=-0.02, release_m=0.02, heavy_thread_m=1e6)
    motion = simulate(setup, until_s=60.0)
    assert motion.endless
    speeds = np.array([hit.light_before_m_s - hit.heavy_before_m_s for hit in motion.collisions])
    # It comes back as fast as it left, but for the cylinder's own crawl.
    assert speeds[1:8] == pytest.approx(0.5 * speeds[:7], rel=1e-3)


def test_a_collision_faster_than_a_resting_contact_always_counts() -> None:
    motion = simulate(Setup(restitution_bodies=0.5, restitution_wall=0.5))
    slowest = min(
        abs(bounce.light_before_m_s - (bounce.kind == "bodies") * bounce.heavy_before_m_s)
        for bounce in motion.collisions
    )
    speed = Setup().release_m * Law.hanging(1.0, 9.81, 0.0, 0.0).natural_rad_s
    assert slowest > RESTING_FRACTION * speed


def test_a_trial_with_more_collisions_than_asked_for_is_ended() -> None:
    motion = simulate(TABLE_1, most=10)
    assert motion.endless
    assert motion.count == 10


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_the_seed_alone_decides_the_scatter(seed: int) -> None:
    setup = replace(TABLE_1, restitution_bodies=0.95, restitution_bodies_sd=0.02)
    drawn = [bounce.restitution for bounce in simulate(setup, seed=seed).collisions]
    assert drawn == [bounce.restitution for bounce in simulate(setup, seed=seed).collisions]
    assert drawn != [bounce.restitution for bounce in simulate(setup, seed=seed + 1).collisions]
    assert all(0.0 <= restitution <= 1.0 for restitution in drawn)


def test_the_scatter_has_the_asked_mean_and_spread() -> None:
    mean, spread, trials_run = 0.998, 0.0004, 10
    setup = replace(
        FREE,
        heavy_mass_kg=1e3,
        light_mass_kg=1.0,
        restitution_bodies=mean,
        restitution_wall=0.9995,
        restitution_bodies_sd=spread,
    )
    drawn = np.array(
        [
            bounce.restitution
            for seed in range(trials_run)
            for bounce in simulate(setup, seed=seed).collisions
            if bounce.kind == "bodies"
        ]
    )
    error = spread / math.sqrt(len(drawn))  # five standard errors of mean and of spread
    assert drawn.mean() == pytest.approx(mean, abs=5 * error)
    assert drawn.std() == pytest.approx(spread, abs=5 * error)
    walls = {bounce.restitution for bounce in simulate(setup).collisions if bounce.kind == "wall"}
    assert walls == {0.9995}

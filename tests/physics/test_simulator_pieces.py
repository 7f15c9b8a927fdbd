from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_setups import free, sliding, suspended

from count_video.errors import UsageError
from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion, Sample, extend, simulate

SCATTERED = st.builds(
    lambda setup, spread: replace(
        setup, restitution_bodies_sd=spread, restitution_wall_sd=spread / 2
    ),
    suspended() | sliding() | free(),
    st.just(0.0) | st.floats(0.001, 0.02),
)
STOPS = st.lists(st.floats(0.0, 3.0), min_size=1, max_size=6).map(sorted)


def bits(sample: Sample) -> bytes:
    """Every number of a sample, as it stands in memory."""
    return np.stack(
        [
            sample.heavy_face_m,
            sample.heavy_velocity_m_s,
            sample.ball_far_face_m,
            sample.ball_velocity_m_s,
        ]
    ).tobytes()


def joined(pieces: list[Sample]) -> bytes:
    """The same for samples in a row."""
    return bits(
        Sample(
            np.concatenate([piece.heavy_face_m for piece in pieces]),
            np.concatenate([piece.heavy_velocity_m_s for piece in pieces]),
            np.concatenate([piece.ball_far_face_m for piece in pieces]),
            np.concatenate([piece.ball_velocity_m_s for piece in pieces]),
            pieces[0].ball_diameter_m,
        )
    )


@given(SCATTERED, STOPS, st.integers(0, 1000))
def test_one_long_run_is_many_short_ones_to_the_bit(
    setup: Setup, stops_s: list[float], seed: int
) -> None:
    motion = simulate(setup, seed=seed, until_s=0.0)
    for stop_s in stops_s:
        motion = extend(motion, stop_s)
    whole = simulate(setup, seed=seed, until_s=stops_s[-1])
    # A short run may already know that nothing more will happen; all that happened is the same.
    assert motion == replace(whole, until_s=motion.until_s)


@given(SCATTERED, st.integers(0, 1000))
def test_stopping_at_a_collision_changes_nothing(setup: Setup, seed: int) -> None:
    whole = simulate(setup, seed=seed, until_s=2.0)
    motion: Motion = simulate(setup, seed=seed, until_s=0.0)
    for bounce in whole.collisions[:40]:
        motion = extend(motion, bounce.time_s)
        assert motion.collisions[-1].time_s == bounce.time_s
    assert extend(motion, 2.0) == replace(whole, until_s=extend(motion, 2.0).until_s)


@given(SCATTERED, st.lists(st.floats(0.0, 3.0), max_size=300), st.data())
def test_sampling_in_pieces_gives_the_same_bits(
    setup: Setup, times: list[float], data: st.DataObject
) -> None:
    motion = simulate(setup)
    cuts = data.draw(st.lists(st.integers(0, len(times)), max_size=5).map(sorted))
    pieces = [motion.sample(piece) for piece in np.split(np.array(times), cuts)]
    assert joined(pieces) == bits(motion.sample(np.array(times)))


@given(SCATTERED, st.floats(0.0, 3.0))
def test_sampling_beyond_the_run_continues_it(setup: Setup, stop_s: float) -> None:
    times = np.linspace(0.0, 3.0, 100)
    short, whole = simulate(setup, until_s=stop_s), simulate(setup, until_s=3.0)
    assert bits(short.sample(times)) == bits(whole.sample(times))


@given(SCATTERED, st.floats(0.0, 3.0))
def test_the_default_end_does_not_change_what_came_before(setup: Setup, stop_s: float) -> None:
    whole = simulate(setup)
    part = simulate(setup, until_s=min(stop_s, whole.until_s))
    assert part.collisions == tuple(c for c in whole.collisions if c.time_s <= stop_s)
    assert part.burst_end_s in (whole.burst_end_s, math.inf)


def test_a_collision_at_time_zero_belongs_to_the_shortest_run() -> None:
    touching = Setup(mounting="free", heavy_velocity_m_s=-1.0, release_m=0.0)
    first = simulate(touching, until_s=0.0).collisions
    assert [bounce.time_s for bounce in first] == [0.0]


def test_an_earlier_end_leaves_a_motion_as_it_is() -> None:
    motion = simulate(Setup())
    assert extend(motion, 0.1) is motion


@pytest.mark.parametrize("until_s", [-1.0, math.nan, math.inf])
def test_an_end_that_is_no_time_is_refused(until_s: float) -> None:
    with pytest.raises(UsageError, match="cannot simulate until"):
        simulate(Setup(), until_s=until_s)


@pytest.mark.parametrize("time_s", [math.nan, math.inf])
def test_a_sample_at_no_time_is_refused(time_s: float) -> None:
    with pytest.raises(UsageError, match="not finite"):
        simulate(Setup()).sample(np.array([0.0, time_s]))


def test_free_bodies_run_to_the_end_of_time() -> None:
    setup = Setup(mounting="free", heavy_velocity_m_s=-1.0)
    assert simulate(setup, until_s=math.inf) == simulate(setup)
    assert simulate(setup).until_s == math.inf

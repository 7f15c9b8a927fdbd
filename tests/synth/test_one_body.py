from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.errors import UsageError
from count_video.physics.laws import Law
from synth_video.experiments import one_body
from synth_video.experiments.course import free_run
from synth_video.experiments.one_body import OneBody, Stops, run_one_body

ROUNDED = 1e-11
"""Relative: some ten operations a bounce, each rounded to 1e-16, over at most a few dozen bounces
whose later times are sums of the earlier ones."""
GRAVITY = 9.81

heights = st.floats(0.05, 2.0)
restitutions = st.floats(0.5, 0.98)


def falling(acceleration_m_s2: float) -> Law:
    return Law(acceleration_m_s2=acceleration_m_s2)


def dropped(height_m: float, restitution: float, until_s: float = 3.0) -> OneBody:
    stops = Stops(restitution=restitution, slow_m_s=0.02)
    return run_one_body(falling(-GRAVITY), height_m, 0.0, stops, until_s)


@given(heights, restitutions)
def test_a_dropped_ball_bounces_at_the_times_of_the_geometric_series(
    height_m: float, restitution: float
) -> None:
    fall_s = math.sqrt(2 * height_m / GRAVITY)
    found = [impact.time_s for impact in dropped(height_m, restitution).impacts]
    rises = np.cumsum([restitution**k for k in range(1, len(found))])
    expected = fall_s * (1 + 2 * np.concatenate([[0.0], rises]))
    assert found == pytest.approx(expected, rel=ROUNDED)


@given(heights, restitutions)
def test_every_bounce_keeps_the_square_of_the_restitution_of_the_energy(
    height_m: float, restitution: float
) -> None:
    motion = dropped(height_m, restitution)
    energies = [GRAVITY * height_m, *(0.5 * hit.after_m_s**2 for hit in motion.impacts)]
    for before, after in pairwise(energies):
        assert after == pytest.approx(restitution**2 * before, rel=ROUNDED)


@given(heights, restitutions)
def test_the_ball_rises_to_the_square_of_the_restitution_of_its_height(
    height_m: float, restitution: float
) -> None:
    motion = dropped(height_m, restitution)
    first, second = motion.impacts[0].time_s, motion.impacts[1].time_s
    top_m = motion.sample(np.array([(first + second) / 2]))[0][0]
    assert top_m == pytest.approx(restitution**2 * height_m, rel=1e-9)


def test_a_ball_that_bounces_too_slowly_rests_on_the_table() -> None:
    motion = dropped(0.3, 0.7, until_s=5.0)
    last = motion.impacts[-1]
    assert -last.before_m_s > 0.02
    assert motion.events[-1].tolist() == [motion.rests_s, 0.0, 0.0]
    late_m, late_m_s = motion.sample(np.array([4.0, 5.0]))
    assert (late_m == 0).all()
    assert (late_m_s == 0).all()


def test_a_cart_between_two_stops_slows_by_the_restitution_at_each() -> None:
    stops = Stops(0.4, restitution=0.9)
    motion = run_one_body(Law(), 0.1, -0.5, stops, 6.0)
    assert [hit.kind for hit in motion.impacts[:4]] == ["wall", "bodies", "wall", "bodies"]
    speeds = 0.5 * 0.9 ** np.arange(len(motion.impacts))
    expected = 0.1 / 0.5 + np.concatenate([[0.0], np.cumsum(0.4 / speeds[1:])])
    assert [hit.time_s for hit in motion.impacts] == pytest.approx(expected, rel=ROUNDED)


def test_a_pendulum_that_hangs_against_the_wall_strikes_every_half_period() -> None:
    law = Law.hanging(1.0, GRAVITY, 0.0, 0.0)
    motion = run_one_body(law, 0.1, 0.0, Stops(restitution=0.8), 10.0)
    half_s = law.period_s / 2
    expected = half_s * (0.5 + np.arange(len(motion.impacts)))
    assert len(motion.impacts) == 10
    assert [hit.time_s for hit in motion.impacts] == pytest.approx(expected, rel=ROUNDED)


def test_a_body_that_meets_nothing_follows_its_law() -> None:
    law = Law.hanging(1.0, GRAVITY, 0.0, 0.0)
    times_s = np.linspace(-1, 10, 12)
    expected = 0.1 * np.cos(law.natural_rad_s * np.maximum(times_s, 0.0))
    assert free_run(law, 0.1)(times_s) == pytest.approx(expected, abs=1e-12)
    fall_m = 0.5 * GRAVITY * np.maximum(times_s, 0.0) ** 2
    assert free_run(falling(-GRAVITY), 2.0)(times_s) == pytest.approx(2.0 - fall_m, rel=ROUNDED)


def test_a_body_that_is_stopped_too_slowly_goes_where_its_law_draws_it() -> None:
    law = Law.hanging(1.0, GRAVITY, 0.0, rest_m=0.05)
    motion = run_one_body(law, 0.1, -1e-3, Stops(slow_m_s=0.1), 4.0)
    assert motion.impacts == ()
    stopped_s = motion.events[1, 0]
    after_s = stopped_s + np.linspace(0, 0.4 * law.period_s, 50)
    expected_m = 0.05 * (1 - np.cos(law.natural_rad_s * (after_s - stopped_s)))
    assert motion.sample(after_s)[0] == pytest.approx(expected_m, abs=1e-12)


def test_the_body_never_leaves_its_stops_and_its_path_has_no_jump() -> None:
    motion = dropped(0.5, 0.8)
    times_s = np.linspace(0, 3, 30001)
    position_m, _ = motion.sample(times_s)
    assert position_m.min() >= -1e-15
    fastest_m_s = math.sqrt(2 * GRAVITY * 0.5)
    assert np.abs(np.diff(position_m)).max() <= 1.001 * fastest_m_s * (times_s[1] - times_s[0])


def test_a_body_is_held_until_time_zero() -> None:
    position_m, velocity_m_s = dropped(0.5, 0.8).sample(np.array([-1.0, -1e-9, 0.0]))
    assert (position_m == 0.5).all()
    assert (velocity_m_s == 0).all()


@pytest.mark.parametrize("unit_s", [0.5, 2.0])
def test_time_scales_with_the_root_of_gravity(unit_s: float) -> None:
    stops = Stops(restitution=0.9, slow_m_s=0.0)
    plain = run_one_body(falling(-4.0), 1.0, 0.0, stops, 4.0)
    scaled = run_one_body(falling(-4.0 / unit_s**2), 1.0, 0.0, stops, 4.0 * unit_s)
    assert len(plain.impacts) == len(scaled.impacts)
    for here, there in zip(plain.impacts, scaled.impacts, strict=True):
        assert there.time_s == pytest.approx(unit_s * here.time_s, rel=ROUNDED)


def test_what_cannot_be_run_is_refused() -> None:
    with pytest.raises(UsageError, match="above 0"):
        Stops(high_m=0.0)
    with pytest.raises(UsageError, match="restitution"):
        Stops(restitution=1.2)
    with pytest.raises(UsageError, match="slow_m_s"):
        Stops(slow_m_s=-1.0)
    with pytest.raises(UsageError, match="not between its stops"):
        run_one_body(Law(), -1.0, 0.0, Stops(), 1.0)
    with pytest.raises(UsageError, match="until"):
        run_one_body(Law(), 1.0, 0.0, Stops(), math.inf)
    with pytest.raises(UsageError, match="simulate it longer"):
        dropped(0.5, 0.8).sample(np.array([3.1]))


def test_a_run_with_far_too_many_impacts_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(one_body, "MOST_IMPACTS", 20)
    with pytest.raises(UsageError, match="more than 20 impacts"):
        run_one_body(Law(), 0.1, -1.0, Stops(0.2), 10.0)

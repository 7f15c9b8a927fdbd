from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.physics.flights import REST, Law, Pendulum, Sliding

POSITIONS = st.floats(-0.2, 0.2)
VELOCITIES = st.floats(-2.0, 2.0)
TIMES = st.floats(0.0, 4.0)
PENDULUMS = st.builds(
    Pendulum.from_thread,
    thread_m=st.floats(0.2, 2.0),
    gravity_m_s2=st.just(9.81),
    damping_per_s=st.just(0.0) | st.floats(0.0, 2.0),
    rest_m=st.floats(-0.1, 0.1),
)
SLIDERS = st.builds(Sliding, st.just(0.0) | st.floats(0.01, 9.81))
LAWS = PENDULUMS | SLIDERS

# Angles of up to 4 s · 7 rad/s carry a rounding of 28 · 2⁻⁵³; positions and velocities of order 1
# (velocities up to 7 rad/s · 0.2 m) carry it on.
ROUNDING = 100 * 2.0**-52


@given(LAWS, POSITIONS, VELOCITIES, TIMES, TIMES)
def test_two_flights_in_a_row_are_one_long_flight(
    law: Law, position: float, velocity: float, first: float, second: float
) -> None:
    rise, halfway = law.advance(position, velocity, first)
    further, end = law.advance(position + rise, halfway, second)
    whole_rise, whole_end = law.advance(position, velocity, first + second)
    assert rise + further == pytest.approx(whole_rise, abs=ROUNDING)
    assert end == pytest.approx(whole_end, abs=ROUNDING)


@given(LAWS, POSITIONS, VELOCITIES.filter(lambda v: v == 0 or abs(v) > 1e-3))
def test_a_flight_starts_with_its_velocity_and_acceleration(
    law: Law, position: float, velocity: float
) -> None:
    tau = 1e-5
    rise, later = law.advance(position, velocity, tau)
    acceleration, jerk = law.acceleration(position, velocity), law.bounds(position, velocity)[1]
    expected = velocity * tau + 0.5 * acceleration * tau**2
    assert rise == pytest.approx(expected, rel=0, abs=jerk * tau**3 / 6 + ROUNDING * tau)
    assert later == pytest.approx(velocity + acceleration * tau, abs=jerk * tau**2 / 2 + ROUNDING)


@given(LAWS, POSITIONS, VELOCITIES, st.lists(TIMES, min_size=1, max_size=20))
def test_arrays_and_numbers_fly_alike(
    law: Law, position: float, velocity: float, times: list[float]
) -> None:
    filled = np.full(len(times), position), np.full(len(times), velocity)
    rises, velocities = law.advance(*filled, np.array(times))
    one_by_one = np.array([law.advance(position, velocity, tau) for tau in times])
    np.testing.assert_allclose(rises, one_by_one[:, 0], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(velocities, one_by_one[:, 1], rtol=0, atol=ROUNDING)


@given(PENDULUMS, POSITIONS, VELOCITIES, TIMES)
def test_accelerations_and_their_change_stay_within_their_bounds(
    law: Pendulum, position: float, velocity: float, tau: float
) -> None:
    most, most_change = law.bounds(position, velocity)
    rise, now = law.advance(position, velocity, tau)
    acceleration = law.acceleration(position + rise, now)
    change = -(law.natural_rad_s**2) * now - 2 * law.damping_per_s * acceleration
    slack = 1 + 1e-12
    noise = ROUNDING * law.natural_rad_s**3
    assert abs(acceleration) <= most * slack + noise
    assert abs(change) <= most_change * slack + noise


@given(PENDULUMS, POSITIONS, VELOCITIES.filter(lambda v: abs(v) > 1e-6))
def test_a_pendulum_turns_at_its_first_maximum(
    law: Pendulum, position: float, velocity: float
) -> None:
    turn = law.turning_s(position, velocity)
    assert 0 < turn <= law.period_s
    _, at_turn = law.advance(position, velocity, turn)
    assert at_turn == pytest.approx(0, abs=ROUNDING)
    times = np.linspace(0, turn, 200)[:-1]
    _, velocities = law.advance(np.full(len(times), position), np.full(len(times), velocity), times)
    falls_back = (velocities[:-1] > ROUNDING) & (velocities[1:] < -ROUNDING)
    assert not falls_back.any()
    assert velocities[-1] > -ROUNDING


def test_a_pendulum_let_go_outside_its_rest_turns_after_a_whole_period() -> None:
    law = Pendulum.from_thread(1.0, 9.81, 0.0, rest_m=0.0)
    assert law.turning_s(0.1, 0.0) == pytest.approx(law.period_s)
    assert law.turning_s(-0.1, 0.0) == pytest.approx(law.period_s / 2)
    assert law.turning_s(0.0, 0.0) == math.inf


@given(PENDULUMS.filter(lambda law: law.damping_per_s == 0), POSITIONS, VELOCITIES, TIMES)
def test_an_undamped_pendulum_keeps_its_energy(
    law: Pendulum, position: float, velocity: float, tau: float
) -> None:
    rise, now = law.advance(position, velocity, tau)
    before = 0.5 * velocity**2 + law.potential(position)
    assert 0.5 * now**2 + law.potential(position + rise) == pytest.approx(
        before, rel=1e-12, abs=ROUNDING
    )


@given(PENDULUMS, POSITIONS)
def test_the_amplitude_decays_at_the_damping_rate(law: Pendulum, position: float) -> None:
    start = position - law.rest_m
    rise, _ = law.advance(position, 0.0, law.period_s)
    left = start * math.exp(-law.damping_per_s * law.period_s)
    assert start + rise == pytest.approx(left, abs=ROUNDING)


@given(st.floats(0.01, 9.81), VELOCITIES.filter(lambda v: abs(v) > 1e-3))
def test_a_sliding_body_stops_where_its_energy_is_spent(brake: float, velocity: float) -> None:
    law = Sliding(brake)
    stop = law.valid_for_s(velocity)
    for tau in (stop, 2 * stop):
        rise, now = law.advance(0.0, velocity, tau)
        assert now == 0.0
        assert abs(rise) == pytest.approx(velocity**2 / (2 * brake), rel=ROUNDING)
        assert math.copysign(1, rise) == math.copysign(1, velocity)
    assert law.bounds(0.0, 0.0) == (0.0, 0.0)
    assert law.acceleration(0.0, 0.0) == 0.0


def test_a_held_body_stays_for_ever() -> None:
    assert REST.advance(0.3, 0.0, 1e6) == (0.0, 0.0)
    assert REST.valid_for_s(0.0) == math.inf
    assert REST.turning_s(0.3, 0.0) == math.inf

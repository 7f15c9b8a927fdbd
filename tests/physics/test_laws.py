from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.physics.laws import Law

POSITIONS = st.floats(-0.2, 0.2)
VELOCITIES = st.floats(-2.0, 2.0)
TIMES = st.floats(0.0, 4.0)
PENDULUMS = st.builds(
    Law.hanging,
    thread_m=st.floats(0.2, 2.0),
    gravity_m_s2=st.just(9.81),
    damping_per_s=st.just(0.0) | st.floats(0.0, 2.0),
    rest_m=st.floats(-0.1, 0.1),
)
THROWS = st.builds(Law, acceleration_m_s2=st.just(0.0) | st.floats(-9.81, 9.81))
LAWS = PENDULUMS | THROWS

# Angles of up to 4 s · 7 rad/s carry a rounding of 28 · 2⁻⁵³; positions and velocities of order 1
# (velocities up to 7 rad/s · 0.2 m, falls up to 80 m) carry it on.
ROUNDING = 100 * 2.0**-52


def rounding(law: Law) -> float:
    return ROUNDING * (1.0 + 8.0 * abs(float(law.acceleration_m_s2)))


@given(LAWS, POSITIONS, VELOCITIES, TIMES, TIMES)
def test_two_flights_in_a_row_are_one_long_flight(
    law: Law, position: float, velocity: float, first: float, second: float
) -> None:
    rise, halfway = law.advance(position, velocity, first)
    further, end = law.advance(position + rise, halfway, second)
    whole_rise, whole_end = law.advance(position, velocity, first + second)
    assert rise + further == pytest.approx(whole_rise, abs=rounding(law))
    assert end == pytest.approx(whole_end, abs=rounding(law))


@given(LAWS, POSITIONS, VELOCITIES.filter(lambda v: v == 0 or abs(v) > 1e-3))
def test_a_flight_starts_with_its_velocity_and_acceleration(
    law: Law, position: float, velocity: float
) -> None:
    tau = 1e-5
    rise, later = law.advance(position, velocity, tau)
    acceleration = law.acceleration(position, velocity)
    swing, rate = law.phasor(position, velocity)
    jerk = abs(swing) * abs(rate)
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
    np.testing.assert_allclose(rises, one_by_one[:, 0], rtol=0, atol=rounding(law))
    np.testing.assert_allclose(velocities, one_by_one[:, 1], rtol=0, atol=rounding(law))


@given(LAWS, POSITIONS, VELOCITIES, TIMES)
def test_the_acceleration_is_that_of_its_phasor(
    law: Law, position: float, velocity: float, tau: float
) -> None:
    swing, rate = law.phasor(position, velocity)
    rise, now = law.advance(position, velocity, tau)
    expected = (swing * np.exp(rate * tau)).real
    scale = (1 + float(law.natural_rad_s) ** 2) * rounding(law)
    assert law.acceleration(position + rise, now) == pytest.approx(expected, abs=10 * scale)


@given(PENDULUMS, POSITIONS, VELOCITIES.filter(lambda v: abs(v) > 1e-6))
def test_a_pendulum_turns_at_its_first_maximum(law: Law, position: float, velocity: float) -> None:
    turn = float(law.turning_s(position, velocity))
    assert 0 < turn <= law.period_s
    _, at_turn = law.advance(position, velocity, turn)
    assert at_turn == pytest.approx(0, abs=ROUNDING)
    times = np.linspace(0, turn, 200)[:-1]
    _, velocities = law.advance(position, velocity, times)
    falls_back = (velocities[:-1] > ROUNDING) & (velocities[1:] < -ROUNDING)
    assert not falls_back.any()
    assert velocities[-1] > -ROUNDING


def test_a_pendulum_let_go_outside_its_rest_turns_after_a_whole_period() -> None:
    law = Law.hanging(1.0, 9.81, 0.0, rest_m=0.0)
    assert law.turning_s(0.1, 0.0) == pytest.approx(law.period_s)
    assert law.turning_s(-0.1, 0.0) == pytest.approx(law.period_s / 2)
    assert law.turning_s(0.0, 0.0) == math.inf


def potential(law: Law, position_m: float) -> float:
    """Potential energy per unit mass, J/kg; 0 at the rest, or at the origin of a throw."""
    swing = 0.5 * (law.natural_rad_s * (position_m - law.rest_m)) ** 2
    return float(swing - law.acceleration_m_s2 * position_m)


@given(LAWS.filter(lambda law: law.damping_per_s == 0), POSITIONS, VELOCITIES, TIMES)
def test_without_damping_the_energy_stays(
    law: Law, position: float, velocity: float, tau: float
) -> None:
    rise, now = law.advance(position, velocity, tau)
    before = 0.5 * velocity**2 + potential(law, position)
    after = 0.5 * now**2 + potential(law, position + rise)
    fastest = 2.0 + 4.0 * abs(float(law.acceleration_m_s2))
    assert after == pytest.approx(before, rel=1e-12, abs=ROUNDING * fastest**2)


@given(PENDULUMS, POSITIONS)
def test_the_amplitude_decays_at_the_damping_rate(law: Law, position: float) -> None:
    start = position - law.rest_m
    rise, _ = law.advance(position, 0.0, law.period_s)
    left = start * math.exp(-law.damping_per_s * law.period_s)
    assert start + rise == pytest.approx(left, abs=ROUNDING)


def test_a_free_body_goes_straight_on_for_ever() -> None:
    assert Law().advance(0.3, 0.5, 1e6) == (5e5, 0.5)
    assert Law().turning_s(0.3, 0.5) == math.inf
    assert Law().period_s == math.inf

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from count_video.physics import contacts
from count_video.physics.contacts import WALL, Mover, contact_s, first_zero, safe_step
from count_video.physics.flights import Pendulum, Sliding

WINDOW_S = 8.0
TIME_TOLERANCE = 1e-12
"""Promised relative accuracy of a contact time."""

PENDULUMS = st.builds(
    Pendulum.from_thread,
    thread_m=st.floats(0.2, 2.0),
    gravity_m_s2=st.just(9.81),
    damping_per_s=st.just(0.0) | st.floats(0.0, 2.0),
    rest_m=st.floats(-0.1, 0.1),
)
SLIDERS = st.builds(Sliding, st.just(0.0) | st.floats(0.01, 2.0))
PLACES = st.floats(0.0, 0.2)
SPEEDS = st.floats(-2.0, 2.0)
LOWER = st.builds(Mover, PENDULUMS, PLACES, SPEEDS)


@st.composite
def pairs(draw: st.DrawFn) -> tuple[Mover, Mover]:
    """Two pendulums, alike or not, apart or touching and then separating."""
    lower = draw(LOWER)
    law: Pendulum = draw(PENDULUMS)
    if draw(st.booleans()):
        stiffness = lower.law.natural_rad_s**2 * (1 + draw(st.floats(-1e-3, 1e-3)))
        rest_m = lower.law.rest_m + draw(st.just(0.0) | st.floats(-1e-3, 1e-3))
        law = Pendulum.from_stiffness(stiffness, lower.law.damping_per_s, rest_m)
    gap = draw(st.just(0.0) | st.floats(1e-6, 0.1))
    separation = draw(st.floats(1e-3, 3.0)) if gap == 0.0 else draw(st.floats(-3.0, 3.0))
    return Mover(law, lower.position_m + gap, lower.velocity_m_s + separation), lower


def gap_and_slope(upper: Mover, lower: Mover, tau: Any) -> tuple[Any, Any]:
    """Gap and its rate in 50 digits, from the differential equation's textbook solution."""
    states = []
    for law, position, velocity in (upper, lower):
        gamma, omega = mpmath.mpf(law.damping_per_s), mpmath.mpf(law.damped_rad_s)
        q = mpmath.mpf(position) - law.rest_m
        sine_part = (velocity + gamma * q) / omega
        shrink, c, s = mpmath.exp(-gamma * tau), mpmath.cos(omega * tau), mpmath.sin(omega * tau)
        swing = shrink * (q * c + sine_part * s)
        rate = shrink * omega * (sine_part * c - q * s) - gamma * swing
        states.append((law.rest_m + swing, rate))
    return states[0][0] - states[1][0], states[0][1] - states[1][1]


@given(pairs())
@settings(max_examples=200)
def test_a_contact_of_two_pendulums_is_exact_to_twelve_digits(pair: tuple[Mover, Mover]) -> None:
    upper, lower = pair
    tau = contact_s(upper, lower, WINDOW_S)
    assume(tau < math.inf)
    with mpmath.workdps(50):
        gap, slope = gap_and_slope(upper, lower, mpmath.mpf(tau))
        assume(abs(slope) > 1e-3)  # a grazing contact has no sharp time
        assert abs(gap / slope) <= TIME_TOLERANCE * tau


@given(pairs())
@settings(max_examples=200)
def test_no_contact_comes_before_the_one_found(pair: tuple[Mover, Mover]) -> None:
    upper, lower = pair
    tau = min(contact_s(upper, lower, WINDOW_S), WINDOW_S)
    times = np.linspace(0, tau, 4001)[1:-1]
    filled = np.ones_like(times)
    places = [
        mover.position_m
        + mover.law.advance(mover.position_m * filled, mover.velocity_m_s * filled, times)[0]
        for mover in pair
    ]
    rounding = 1e-15  # of positions below 1 m
    assert (places[0] - places[1]).min() > -rounding


@given(st.floats(1e-6, 1.0), SPEEDS, SPEEDS)
def test_free_bodies_meet_after_gap_over_approach(gap: float, upper: float, lower: float) -> None:
    approach = lower - upper
    assume(abs(approach) > 1e-9)
    found = contact_s(Mover(Sliding(), gap, upper), Mover(Sliding(), 0.0, lower), math.inf)
    expected = gap / approach if approach > 0 else math.inf
    assert found == pytest.approx(expected, rel=4 * 2.0**-52)


@given(st.floats(0.01, 2.0), st.floats(1e-3, 0.5), st.floats(0.1, 3.0))
def test_a_braked_body_reaches_the_wall_or_stops_before(
    brake: float, distance: float, speed: float
) -> None:
    assume(abs(speed**2 - 2 * brake * distance) > 1e-6)
    ball = Mover(Sliding(brake), distance, -speed)
    found = contact_s(ball, WALL, ball.law.valid_for_s(-speed))
    left = speed**2 - 2 * brake * distance
    expected = 2 * distance / (speed + math.sqrt(left)) if left > 0 else math.inf
    assert found == pytest.approx(expected, rel=TIME_TOLERANCE)


def test_an_undamped_pendulum_returns_to_the_wall_after_half_a_period() -> None:
    law = Pendulum.from_thread(1.0, 9.81, 0.0, rest_m=0.0)
    back = contact_s(Mover(law, 0.0, 0.5), WALL, WINDOW_S)
    assert back == pytest.approx(law.period_s / 2, rel=TIME_TOLERANCE)


@pytest.mark.parametrize("speed", [1e-8, 1e-6, 1e-3])
def test_a_hop_far_smaller_than_a_rounding_of_the_position_is_timed(speed: float) -> None:
    law = Pendulum.from_thread(1.0, 9.81, 0.0, rest_m=-0.05)  # pulled to the wall
    hop = contact_s(Mover(law, 0.0, speed), WALL, WINDOW_S)
    expected = 2 * math.atan2(speed / law.natural_rad_s, 0.05) / law.natural_rad_s
    assert hop == pytest.approx(expected, rel=TIME_TOLERANCE)


@given(st.floats(-1e-6, 1e-6), st.floats(1e-9, 1e-6))
def test_pendulums_in_nearly_one_motion_are_not_followed_at_a_crawl(
    difference: float, separation: float
) -> None:
    lower_law = Pendulum.from_thread(1.0, 9.81, 0.0, rest_m=0.07)
    upper_law = Pendulum.from_thread(1.0 + difference, 9.81, 0.0, rest_m=0.07)
    steps = 0

    def counted(gap: float, slope: float, curvature: float) -> float:
        nonlocal steps
        steps += 1
        return safe_step(gap, slope, curvature)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contacts, "safe_step", counted)
        contact_s(Mover(upper_law, 0.0, separation), Mover(lower_law, 0.0, 0.0), 1.0)
    assert steps < 1000  # with the bounds of each pendulum by itself some hundred thousand


def test_touching_bodies_that_approach_meet_at_once() -> None:
    assert contact_s(Mover(Sliding(), 0.1, -1.0), Mover(Sliding(), 0.1, 0.0), 1.0) == 0.0


@given(PENDULUMS, PENDULUMS, PLACES, SPEEDS)
def test_bodies_pulled_apart_from_a_common_motion_have_left_each_other(
    upper_law: Pendulum, lower_law: Pendulum, place: float, speed: float
) -> None:
    upper, lower = Mover(upper_law, place, speed), Mover(lower_law, place, speed)
    pull = upper_law.acceleration(place, speed) - lower_law.acceleration(place, speed)
    jerk = upper_law.bounds(place, speed)[1] + lower_law.bounds(place, speed)[1]
    assume(pull > 1e-6)
    assert contact_s(upper, lower, WINDOW_S) >= 3 * pull / jerk


def test_touching_bodies_pulled_apart_from_rest_do_not_meet() -> None:
    still = Mover(Sliding(), 0.0, 0.0)
    pulled = Mover(Pendulum.from_thread(1.0, 9.81, 0.0, rest_m=0.05), 0.0, 0.0)
    # It swings out and is back at rest, grazing, after a period; half of one is clear.
    assert contact_s(pulled, still, pulled.law.period_s / 2) == math.inf


def test_a_contact_beyond_the_window_is_never() -> None:
    ball = Mover(Sliding(), 1.0, -1.0)
    assert contact_s(ball, WALL, 0.999) == math.inf
    assert contact_s(ball, WALL, 1.001) == pytest.approx(1.0)


def test_a_double_zero_is_found_to_the_square_root_of_rounding() -> None:
    def grazing(tau: float) -> tuple[float, float, float]:
        return (tau - 1.0) ** 2, 2.0 * (tau - 1.0), 2.0

    assert first_zero(grazing, 0.0, (2.0, 0.0), 3.0) == pytest.approx(1.0, abs=1e-7)


def test_a_near_miss_is_passed_and_the_next_zero_found() -> None:
    def wave(tau: float) -> tuple[float, float, float]:  # dips to 1e-9 at π, is 0 after 2π
        late = max(0.0, tau - 2 * math.pi)
        return 1.0 + math.cos(tau) + 1e-9 - late**2, -math.sin(tau) - 2 * late, 0.0

    zero = first_zero(wave, 0.0, (3.0, 0.0), 100.0)
    assert zero > 2 * math.pi
    assert wave(zero)[0] == pytest.approx(0.0, abs=1e-12)


@given(st.floats(0.0, 1.0), st.floats(-2.0, 2.0), st.floats(0.01, 10.0))
def test_a_safe_step_ends_where_the_parabola_does(
    gap: float, slope: float, curvature: float
) -> None:
    step = safe_step(gap, slope, curvature)
    scale = gap + abs(slope) * step + curvature * step**2
    assert step >= 0.0
    assert gap + slope * step - curvature * step**2 / 2 == pytest.approx(0, abs=1e-14 * scale)


def test_a_straight_gap_that_opens_has_no_step() -> None:
    assert safe_step(0.1, 0.5, 0.0) == math.inf
    assert safe_step(0.1, -0.5, 0.0) == pytest.approx(0.2)

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from count_video.physics import laws
from count_video.physics.laws import Law, Mover, first_zero, safe_step
from count_video.records import Floats

WINDOW_S = 8.0
TIME_TOLERANCE = 1e-12
"""Promised relative accuracy of a contact time."""

PENDULUMS = st.builds(
    Law.hanging,
    thread_m=st.floats(0.2, 2.0),
    gravity_m_s2=st.just(9.81),
    damping_per_s=st.just(0.0) | st.floats(0.0, 2.0),
    rest_m=st.floats(-0.1, 0.1),
)
PLACES = st.floats(0.0, 0.2)
SPEEDS = st.floats(-2.0, 2.0)


def mover(law: Law, position_m: float, velocity_m_s: float) -> Mover:
    return Mover(law, np.array([position_m]), np.array([velocity_m_s]))


def contact_s(upper: Mover, lower: Mover, window_s: float) -> float:
    return float(laws.contact_s(upper, lower, np.array([window_s]))[0])


def wall_s(body: Mover, window_s: float) -> float:
    return float(laws.contact_s(body, None, np.array([window_s]))[0])


LOWER = st.builds(mover, PENDULUMS, PLACES, SPEEDS)


@st.composite
def pairs(draw: st.DrawFn) -> tuple[Mover, Mover]:
    """Two pendulums, alike or not, apart or touching and then separating."""
    lower = draw(LOWER)
    law: Law = draw(PENDULUMS)
    if draw(st.booleans()):
        stiffness = lower.law.natural_rad_s**2 * (1 + draw(st.floats(-1e-3, 1e-3)))
        rest_m = lower.law.rest_m + draw(st.just(0.0) | st.floats(-1e-3, 1e-3))
        law = Law(rest_m, math.sqrt(stiffness), lower.law.damping_per_s)
    gap = draw(st.just(0.0) | st.floats(1e-6, 0.1))
    separation = draw(st.floats(1e-3, 3.0)) if gap == 0.0 else draw(st.floats(-3.0, 3.0))
    return Mover(law, lower.position_m + gap, lower.velocity_m_s + separation), lower


def gap_and_slope(upper: Mover, lower: Mover, tau: Any) -> tuple[Any, Any]:
    """Gap and its rate in 50 digits, from the differential equation's textbook solution."""
    states = []
    for law, (position,), (velocity,) in (upper, lower):
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
        one.position_m + one.law.advance(one.position_m * filled, one.velocity_m_s, times)[0]
        for one in pair
    ]
    rounding = 1e-15  # of positions below 1 m
    assert (places[0] - places[1]).min() > -rounding


@given(st.floats(1e-6, 1.0), SPEEDS, SPEEDS)
def test_free_bodies_meet_after_gap_over_approach(gap: float, upper: float, lower: float) -> None:
    approach = lower - upper
    assume(abs(approach) > 1e-9)
    found = contact_s(mover(Law(), gap, upper), mover(Law(), 0.0, lower), math.inf)
    expected = gap / approach if approach > 0 else math.inf
    assert found == pytest.approx(expected, rel=4 * 2.0**-52)


@given(st.floats(0.01, 2.0), st.floats(1e-3, 0.5), st.floats(0.1, 3.0))
def test_a_cart_that_rolls_up_reaches_the_stop_or_turns_before(
    pull: float, distance: float, speed: float
) -> None:
    left = speed**2 - 2 * pull * distance
    assume(abs(left) > 1e-6)
    stop = mover(Law(), distance, 0.0)
    found = contact_s(stop, mover(Law(acceleration_m_s2=-pull), 0.0, speed), 100.0)
    expected = 2 * distance / (speed + math.sqrt(left)) if left > 0 else math.inf
    assert found == pytest.approx(expected, rel=TIME_TOLERANCE)


def test_an_undamped_pendulum_returns_to_the_wall_after_half_a_period() -> None:
    law = Law.hanging(1.0, 9.81, 0.0, rest_m=0.0)
    back = wall_s(mover(law, 0.0, 0.5), WINDOW_S)
    assert back == pytest.approx(law.period_s / 2, rel=TIME_TOLERANCE)


@pytest.mark.parametrize("speed", [1e-8, 1e-6, 1e-3])
def test_a_hop_far_smaller_than_a_rounding_of_the_position_is_timed(speed: float) -> None:
    law = Law.hanging(1.0, 9.81, 0.0, rest_m=-0.05)  # pulled to the wall
    hop = wall_s(mover(law, 0.0, speed), WINDOW_S)
    expected = 2 * math.atan2(speed / law.natural_rad_s, 0.05) / law.natural_rad_s
    assert hop == pytest.approx(expected, rel=TIME_TOLERANCE)


@given(st.floats(-1e-6, 1e-6), st.floats(1e-9, 1e-6))
def test_pendulums_in_nearly_one_motion_are_not_followed_at_a_crawl(
    difference: float, separation: float
) -> None:
    lower_law = Law.hanging(1.0, 9.81, 0.0, rest_m=0.07)
    upper_law = Law.hanging(1.0 + difference, 9.81, 0.0, rest_m=0.07)
    steps = 0

    def counted(gap: Floats, slope: Floats, curvature: Floats) -> Floats:
        nonlocal steps
        steps += 1
        return safe_step(gap, slope, curvature)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(laws, "safe_step", counted)
        contact_s(mover(upper_law, 0.0, separation), mover(lower_law, 0.0, 0.0), 1.0)
    assert steps < 1000  # with the bounds of each pendulum by itself some hundred thousand


def test_touching_bodies_that_approach_meet_at_once() -> None:
    assert contact_s(mover(Law(), 0.1, -1.0), mover(Law(), 0.1, 0.0), 1.0) == 0.0


def test_a_contact_beyond_the_window_is_never() -> None:
    ball = mover(Law(), 1.0, -1.0)
    assert wall_s(ball, 0.999) == math.inf
    assert wall_s(ball, 1.001) == pytest.approx(1.0)


def zero_of(function: Any, curvature: float, window: float) -> float:
    def evaluate(rows: Any, tau: Floats) -> tuple[Floats, Floats]:
        values, slopes = zip(*map(function, tau.tolist()), strict=True)
        return np.array(values), np.array(slopes)

    found = first_zero(evaluate, np.zeros(1), np.array([curvature]), np.array([window]))
    return float(found[0])


def test_a_double_zero_is_found_to_the_square_root_of_rounding() -> None:
    def grazing(tau: float) -> tuple[float, float]:
        return (tau - 1.0) ** 2, 2.0 * (tau - 1.0)

    assert zero_of(grazing, 2.0, 3.0) == pytest.approx(1.0, abs=1e-7)


def test_a_near_miss_is_passed_and_the_next_zero_found() -> None:
    def wave(tau: float) -> tuple[float, float]:  # dips to 1e-9 at π, is 0 after 2π
        late = max(0.0, tau - 2 * math.pi)
        return 1.0 + math.cos(tau) + 1e-9 - late**2, -math.sin(tau) - 2 * late

    zero = zero_of(wave, 3.0, 100.0)
    assert zero > 2 * math.pi
    assert wave(zero)[0] == pytest.approx(0.0, abs=1e-12)


@given(st.floats(0.0, 1.0), st.floats(-2.0, 2.0), st.floats(0.01, 10.0))
def test_a_safe_step_ends_where_the_parabola_does(
    gap: float, slope: float, curvature: float
) -> None:
    step = float(safe_step(*map(np.array, (gap, slope, curvature))))
    scale = gap + abs(slope) * step + curvature * step**2
    assert step >= 0.0
    # Below the smallest normal number rounding is no share of a number any more.
    rounding = 1e-14 * scale + np.finfo(np.float64).tiny
    assert gap + slope * step - curvature * step**2 / 2 == pytest.approx(0, abs=rounding)


def test_a_straight_gap_that_opens_has_no_step() -> None:
    gaps, slopes = np.array([0.1, 0.1]), np.array([0.5, -0.5])
    assert safe_step(gaps, slopes, np.zeros(2)) == pytest.approx([math.inf, 0.2])

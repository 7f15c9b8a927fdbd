from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from phase_circle import count_by_phase_circle, in_stopping_region, velocities_by_collision

from count_video.physics.theory import WHOLE_QUOTIENTS, collision_count, state_points

RATIOS = st.fractions(Fraction(1, 100), Fraction(10**4), max_denominator=100) | st.sampled_from(
    list(WHOLE_QUOTIENTS)
)
# An angle is a float near π at most, its sine and cosine a rounding more.
POINT_ROUNDING = 4 * 2.0**-52


@given(RATIOS)
@settings(max_examples=150)
def test_both_routes_and_a_run_collision_by_collision_agree(ratio: Fraction) -> None:
    exact = collision_count(ratio)
    assert count_by_phase_circle(ratio) == exact
    assert len(velocities_by_collision(ratio)) - 1 == exact


@pytest.mark.parametrize("digits", range(21))
def test_both_routes_agree_at_a_hundred_to_the_n(digits: int) -> None:
    assert count_by_phase_circle(100**digits) == collision_count(100**digits)


@given(RATIOS)
@settings(max_examples=50)
def test_state_points_are_the_scaled_velocities_of_the_run(ratio: Fraction) -> None:
    scale = 1 / math.sqrt(ratio)  # V₂/V₁ per v₂/v₁, the cylinder's first speed being 1
    run = [(float(heavy), float(light) * scale) for heavy, light in velocities_by_collision(ratio)]
    np.testing.assert_allclose(state_points(ratio), run, rtol=0, atol=POINT_ROUNDING)


@given(RATIOS)
@settings(max_examples=50)
def test_only_the_last_state_point_lies_in_the_stopping_region(ratio: Fraction) -> None:
    inside = [in_stopping_region(*point, ratio) for point in state_points(ratio)]
    assert inside == [False] * (len(inside) - 1) + [True]


@given(RATIOS)
@settings(max_examples=50)
def test_steps_follow_the_momentum_line_and_the_mirror_at_the_axis(ratio: Fraction) -> None:
    points = state_points(ratio)
    steps = np.diff(points, axis=0)
    bodies, wall = steps[0::2], steps[1::2]
    slope = -math.sqrt(ratio)
    rounding = 2 * POINT_ROUNDING * (1 + abs(slope))  # of two points, one weighed by the slope
    np.testing.assert_allclose(bodies[:, 1], slope * bodies[:, 0], rtol=0, atol=rounding)
    np.testing.assert_array_equal(wall[:, 0], 0.0)
    np.testing.assert_array_equal(points[1:-1:2, 1][: len(wall)], -points[2::2, 1])
    np.testing.assert_allclose(np.hypot(*points.T), 1.0, rtol=POINT_ROUNDING)


def test_the_papers_numbers_at_one_to_a_hundred_come_out() -> None:
    points = state_points(100)
    assert len(points) == 32
    np.testing.assert_allclose(points[1], [-99 / 101, -20 / 101], atol=POINT_ROUNDING)
    np.testing.assert_allclose(points[2], [-99 / 101, 20 / 101], atol=POINT_ROUNDING)
    assert math.atan2(points[30, 1], points[30, 0]) == pytest.approx(0.1515, abs=5e-5)
    assert not in_stopping_region(*points[30], 100)

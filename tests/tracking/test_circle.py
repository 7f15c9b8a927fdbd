from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from count_video.tracking.circle import circle_through

SHAPE = (60, 100)
PLACED_PX = 0.5
"""Edge points are whole pixels: a circle through dozens of them is right to half of one."""

Points = tuple[np.ndarray, np.ndarray]


def ring(x: float, y: float, radius: float, arc: tuple[float, float] = (0.0, 360.0)) -> Points:
    angle = np.radians(np.linspace(*arc, 200))
    points = np.unique(
        np.round([x + radius * np.cos(angle), y + radius * np.sin(angle)]), axis=1
    ).astype(np.intp)
    return points[0], points[1]


def together(*parts: Points) -> Points:
    return (
        np.concatenate([part[0] for part in parts]),
        np.concatenate([part[1] for part in parts]),
    )


def clutter(count: int, seed: int) -> Points:
    rng = np.random.default_rng(seed)
    return rng.integers(40, 60, count), rng.integers(0, SHAPE[0], count)


@settings(max_examples=60)
@given(st.floats(45.0, 55.0), st.floats(28.0, 32.0), st.floats(19.0, 26.0), st.integers(0, 100))
def test_a_ball_is_found_by_its_outline_in_spite_of_its_ring_and_clutter(
    x: float, y: float, radius: float, seed: int
) -> None:
    points = together(ring(x, y, radius), ring(x, y, radius / 2), clutter(15, seed))

    circle = circle_through(*points, SHAPE)

    assert circle is not None
    assert circle.x_px == pytest.approx(x, abs=PLACED_PX)
    assert circle.y_px == pytest.approx(y, abs=PLACED_PX)
    assert circle.radius_px == pytest.approx(radius, abs=PLACED_PX)


@pytest.mark.parametrize("seed", range(5))
def test_a_large_ball_covered_with_print_is_found_by_its_outline(seed: int) -> None:
    rng = np.random.default_rng(seed)
    print_on_it = rng.integers(70, 130, 700), rng.integers(40, 80, 700)

    circle = circle_through(*together(ring(100, 60, 49), print_on_it), (120, 250))

    assert circle is not None
    assert circle.radius_px == pytest.approx(49.0, abs=PLACED_PX)


def test_two_arcs_left_and_right_are_enough() -> None:
    points = together(ring(50, 30, 24, (-55, 55)), ring(50, 30, 24, (125, 235)))

    circle = circle_through(*points, SHAPE)

    assert circle is not None
    assert circle.radius_px == pytest.approx(24.0, abs=PLACED_PX)


def test_the_left_arc_alone_is_no_ball() -> None:
    assert circle_through(*ring(50, 30, 24, (100, 260)), SHAPE) is None


@pytest.mark.parametrize("half", [16, 20, 25])
def test_a_square_is_no_circle(half: int) -> None:
    side = np.arange(-half, half + 1)
    low, high = np.full_like(side, -half), np.full_like(side, half)
    x = 50 + np.concatenate([side, side, low, high])
    y = 30 + np.concatenate([low, high, side, side])

    assert circle_through(x, y, SHAPE) is None


def test_two_upright_edges_are_no_circle() -> None:
    rows = np.arange(5, 55)
    x = np.concatenate([np.full(50, 20), np.full(50, 80)])

    assert circle_through(x, np.concatenate([rows, rows]), SHAPE) is None


@pytest.mark.parametrize("radius", [5, 50])
def test_circles_far_smaller_or_larger_than_the_area_are_left_out(radius: int) -> None:
    assert circle_through(*ring(50, 30, radius), SHAPE) is None


@pytest.mark.parametrize("count", [0, 3, 15])
def test_a_few_points_are_no_circle(count: int) -> None:
    x, y = ring(50, 30, 24)

    assert circle_through(x[:count], y[:count], SHAPE) is None


def test_points_in_one_place_are_no_circle() -> None:
    same = np.full(40, 7)

    assert circle_through(same, same, SHAPE) is None


def test_the_answer_is_the_same_every_time() -> None:
    points = together(ring(50, 30, 22), clutter(40, 1))

    assert circle_through(*points, SHAPE) == circle_through(*points, SHAPE)

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from count_video.tracking.circle import Circle, Edges, circle_through

HEIGHT_PX = 60
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
    return rng.integers(40, 60, count), rng.integers(0, HEIGHT_PX, count)


def found(
    points: Points, clarity: np.ndarray | float = 1.0, height: int = HEIGHT_PX
) -> Circle | None:
    places = np.stack(points, axis=1).astype(np.float64)
    return circle_through(Edges(places, np.broadcast_to(clarity, len(places))), height)


@settings(max_examples=60)
@given(st.floats(45.0, 55.0), st.floats(28.0, 32.0), st.floats(19.0, 26.0), st.integers(0, 100))
def test_a_ball_is_found_by_its_outline_in_spite_of_its_ring_and_clutter(
    x: float, y: float, radius: float, seed: int
) -> None:
    points = together(ring(x, y, radius), ring(x, y, radius / 2), clutter(15, seed))

    circle = found(points)

    assert circle is not None
    assert circle.x_px == pytest.approx(x, abs=PLACED_PX)
    assert circle.y_px == pytest.approx(y, abs=PLACED_PX)
    assert circle.radius_px == pytest.approx(radius, abs=PLACED_PX)


@pytest.mark.parametrize("seed", range(5))
def test_a_large_ball_covered_with_print_is_found_by_its_outline(seed: int) -> None:
    rng = np.random.default_rng(seed)
    print_on_it = rng.integers(70, 130, 700), rng.integers(40, 80, 700)

    circle = found(together(ring(100, 60, 49), print_on_it), height=120)

    assert circle is not None
    assert circle.radius_px == pytest.approx(49.0, abs=PLACED_PX)


def test_two_arcs_left_and_right_are_enough() -> None:
    points = together(ring(50, 30, 24, (-55, 55)), ring(50, 30, 24, (125, 235)))

    circle = found(points)

    assert circle is not None
    assert circle.radius_px == pytest.approx(24.0, abs=PLACED_PX)


def test_the_left_arc_alone_is_no_ball() -> None:
    assert found(ring(50, 30, 24, (112, 248))) is None


@pytest.mark.parametrize("half", [16, 20, 25])
def test_a_square_is_no_circle(half: int) -> None:
    side = np.arange(-half, half + 1)
    low, high = np.full_like(side, -half), np.full_like(side, half)
    x = 50 + np.concatenate([side, side, low, high])
    y = 30 + np.concatenate([low, high, side, side])

    assert found((x, y)) is None


def test_two_upright_edges_are_no_circle() -> None:
    rows = np.arange(5, 55)
    x = np.concatenate([np.full(50, 20), np.full(50, 80)])

    assert found((x, np.concatenate([rows, rows]))) is None


@pytest.mark.parametrize("radius", [5, 50])
def test_circles_far_smaller_or_larger_than_the_area_are_left_out(radius: int) -> None:
    assert found(ring(50, 30, radius)) is None


@pytest.mark.parametrize("count", [0, 3, 15])
def test_a_few_points_are_no_circle(count: int) -> None:
    x, y = ring(50, 30, 24)

    assert found((x[:count], y[:count])) is None


def test_points_in_one_place_are_no_circle() -> None:
    same = np.full(40, 7)

    assert found((same, same)) is None


def test_the_answer_is_the_same_every_time() -> None:
    points = together(ring(50, 30, 22), clutter(40, 1))

    assert found(points) == found(points)


def test_a_ball_beside_its_shadow_is_found_though_the_shadow_is_as_clear() -> None:
    shadow = np.array(ring(58, 36, 20))
    shown = np.hypot(shadow[0] - 48, shadow[1] - 28) > 20

    circle = found(together(ring(48, 28, 20), (shadow[0, shown], shadow[1, shown])))

    assert circle is not None
    assert (circle.x_px, circle.y_px) == pytest.approx((48.0, 28.0), abs=PLACED_PX)
    assert circle.radius_px == pytest.approx(20.0, abs=PLACED_PX)


@pytest.mark.parametrize("seed", range(5))
def test_a_faint_outline_is_found_about_texture_that_is_everywhere(seed: int) -> None:
    rng = np.random.default_rng(seed)
    texture = rng.integers(26, 74, 600), rng.integers(4, 56, 600)
    within = np.hypot(texture[0] - 50, texture[1] - 30) < 22
    points = together(ring(50, 30, 22), (texture[0][within], texture[1][within]))
    clarity = np.where(np.arange(len(points[0])) < len(ring(50, 30, 22)[0]), 1.0, 0.4)

    circle = found(points, clarity)

    assert circle is not None
    assert circle.radius_px == pytest.approx(22.0, abs=PLACED_PX)

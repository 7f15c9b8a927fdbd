from __future__ import annotations

import numpy as np
import pytest

from count_video.tracking.beside import changes, has_face, turning_side


def strip(face: int | None, body: int) -> np.ndarray:
    """What lies ahead of a body that ends at a place, with a wall that begins at another."""
    picture = np.full((21, 80), 100.0)
    picture[:, :body] = 40.0
    if face is not None:
        picture[:, face:] = 120.0
    return picture


def test_a_wall_ahead_is_seen_and_the_edge_of_the_body_itself_is_not() -> None:
    assert has_face(strip(60, 20), strip(60, 30))
    assert not has_face(strip(None, 20), strip(None, 30))


def test_what_is_lower_than_the_body_is_no_wall() -> None:
    before, after = strip(60, 20), strip(60, 30)
    for picture in (before, after):
        picture[:10] = np.where(np.arange(80) < 30, picture[:10], 100.0)

    assert not has_face(before, after)


def strips(ball_at: list[int | None], light: list[float]) -> np.ndarray:
    """A textured wall in some pictures, each in its own light, with a ball at a place in front."""
    wall = 100.0 + 10.0 * np.random.default_rng(0).normal(size=(21, 40))
    pictures = []
    for place, factor in zip(ball_at, light, strict=True):
        picture = wall.copy()
        if place is not None:
            picture[5:16, place : place + 10] = 160.0
        pictures.append(factor * picture)
    return np.array(pictures)


STILL, STEADY = [None] * 8, [1.0] * 8


def test_a_ball_that_comes_and_goes_moves_and_a_lamp_that_flickers_does_not() -> None:
    coming = [None, None, None, 30, 20, 10, None, None]
    flicker = [1.0, 1.2, 0.8, 1.1, 0.9, 1.2, 0.8, 1.0]

    assert changes(strips(coming, STEADY))
    assert changes(strips(coming, flicker))
    assert not changes(strips(STILL, flicker))


@pytest.mark.parametrize("unseen", [range(0), range(37, 45)], ids=["seen", "hidden"])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_body_that_is_hidden_where_it_turns_turns_at_that_end(unseen: range, side: int) -> None:
    frames = np.arange(100.0)
    place = side * (200.0 - 2 * np.abs(frames - 41.3))
    place[list(unseen)] = np.nan

    assert turning_side(frames, place, 41.3) == side


def test_a_title_is_no_motion_and_neither_is_what_is_covered() -> None:
    titled = strips(STILL, STEADY)
    titled[0] = 40.0
    titled[0, 5:10] = 200.0
    covered = strips([None, 30, 20, 10, None, None, None, None], STEADY)
    covered[1:4, 5:16] = np.nan

    assert not changes(titled)
    assert not changes(covered)
    assert not changes(np.full((8, 21, 40), np.nan))

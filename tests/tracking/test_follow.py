from __future__ import annotations

import numpy as np
import pytest
from drawn import background, paint_ball, to_luma

from count_video.records import Floats
from count_video.tracking.follow import Follower
from count_video.tracking.learning import Body
from count_video.tracking.sprite import look, make_sprite

SHAPE = (170, 520)
RADIUS_PX = 55.0
ROW = 84.0
FOLLOWED_PX = 0.1
"""RMS over frames with a noise of one grey level, and with the ball between pixels."""


def picture(x: float, seed: int) -> np.ndarray:
    canvas = background(SHAPE)
    paint_ball(canvas, x, ROW, RADIUS_PX)
    return to_luma(canvas, 1.0, np.random.default_rng(seed))


def ball(x: float) -> Body:
    half = int(RADIUS_PX) + 6
    left, top = x - half, ROW - half
    appearance = look(picture(x, 99), left, top, (2 * half + 1, 2 * half + 1))
    rows, columns = np.indices(appearance.shape)
    weight = np.hypot(columns - half, rows - half) < RADIUS_PX + 2
    sprite = make_sprite(appearance, weight.astype(np.float32))
    edges = half - RADIUS_PX, half + RADIUS_PX
    return Body(sprite, *edges, True, {0: (left, top)}, 0.98)


def followed(path: Floats) -> Floats:
    """How far off each place is, about their mean."""
    follower = Follower(ball(float(path[0])), 0.0)
    for index, x in enumerate(path):
        follower.see(index, picture(float(x), index))
    found = np.array(follower.x_px) - path
    return np.asarray(found - np.nanmean(found))


@pytest.mark.parametrize("speed", [3.0, 11.0, 27.0])
def test_a_ball_that_turns_at_a_wall_is_not_lost(speed: float) -> None:
    frames = np.arange(8.0)
    path = 100.0 + speed * np.abs(frames - 3.4) + 40.0

    error = followed(path)

    assert np.isfinite(error).all()
    assert float(np.sqrt(np.mean(error**2))) < FOLLOWED_PX


def test_a_ball_that_is_struck_in_flight_is_found_again() -> None:
    path = np.array([400.0, 385.0, 370.0, 355.0, 340.0, 325.0, 333.0, 365.0, 397.0, 429.0])

    assert np.isfinite(followed(path)).all()

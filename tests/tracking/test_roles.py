from __future__ import annotations

import numpy as np
import pytest

from count_video.tracking.pairing import far_side_jump, wall_side

FRAME = np.arange(120.0)
NAN = float("nan")


def bouncing(noise: float = 0.0) -> np.ndarray:
    """Distance of a ball that bounces off the wall three times."""
    rng = np.random.default_rng(0)
    return 50.0 + 2.0 * np.abs((FRAME + 20) % 40 - 20) + rng.normal(0.0, noise, len(FRAME))


def swinging(noise: float = 0.0) -> np.ndarray:
    """Distance of a heavy body that turns round smoothly."""
    rng = np.random.default_rng(1)
    return 180.0 + 0.005 * (FRAME - 60.0) ** 2 + rng.normal(0.0, noise, len(FRAME))


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_the_wall_stands_beside_the_body_that_bounces(noise: float) -> None:
    ball, heavy = bouncing(noise), swinging(noise)

    assert wall_side(ball, heavy) == "left"
    assert wall_side(-heavy, -ball) == "right"


def test_a_place_far_away_makes_no_difference() -> None:
    assert wall_side(bouncing() + 5000.0, swinging() + 5000.0) == "left"


@pytest.mark.parametrize("still", [np.full(120, 50.0), np.full(120, NAN)])
def test_bodies_that_do_not_bounce_show_no_wall(still: np.ndarray) -> None:
    assert wall_side(still, still + 100.0) is None


def test_frames_not_seen_do_not_hide_the_wall() -> None:
    ball = bouncing()
    ball[[5, 17, 50, 51]] = NAN

    assert wall_side(ball, swinging()) == "left"


def test_the_jumps_at_a_wall_add_up() -> None:
    # Reversals from -2 to +2 px a frame, fully seen at frames 20+40k that lie inside.
    inside = np.sum((FRAME % 40 == 0) & (FRAME > 3) & (FRAME < 116))

    assert far_side_jump(bouncing()) == pytest.approx(4.0 * inside)


def test_jitter_at_rest_is_no_bounce() -> None:
    noise = np.random.default_rng(2).normal(0.0, 0.05, 2000)

    assert far_side_jump(100.0 + noise) == 0.0

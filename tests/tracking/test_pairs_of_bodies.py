"""Which two of the things that move are the bodies."""

from __future__ import annotations

import numpy as np
import pytest

from count_video.tracking.pairs.bodies import on_their_own

PLACES = 100.0 - 30.0 * np.abs(np.sin(np.arange(60) / 9.0))
NEIGHBOUR = 180.0 - 0.6 * np.arange(60)
STRAY_PX = 0.3
"""A shine in polished brass creeps by so much along the body that it seems a part of."""


def test_a_ball_and_its_neighbour_move_each_on_its_own() -> None:
    assert on_their_own(PLACES, NEIGHBOUR)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_parts_of_one_body_and_its_mirror_image_do_not(sign: float) -> None:
    stray = STRAY_PX * np.sin(np.arange(60) / 5.0)

    assert not on_their_own(PLACES, 250.0 + sign * PLACES + stray)

"""Which pictures a template is learnt from."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.tracking.paths import PICTURES, PLACE_BIN_PX, choose

FAR_PX = 10 * PLACE_BIN_PX


@given(st.integers(0, PICTURES // 2), st.integers(PICTURES, 300))
def test_as_many_pictures_are_chosen_as_are_asked_for_however_rare_some_are(
    moving: int, resting: int
) -> None:
    places = [0.0] * resting + [FAR_PX * (1 + k) for k in range(moving)]
    path = np.array([(x, 0.0) for x in places])

    chosen = choose(path, [])

    assert len(chosen) == min(PICTURES, len(path))
    assert set(range(resting, resting + moving)) <= set(chosen.tolist())


@pytest.mark.parametrize("rests_for", [PICTURES, 10 * PICTURES])
def test_rest_takes_no_more_pictures_than_are_left_over(rests_for: int) -> None:
    moving = 3 * PICTURES
    places = [0.0] * rests_for + [FAR_PX * (1 + k) for k in range(moving)]
    path = np.array([(x, 0.0) for x in places])

    of_rest = [frame for frame in choose(path, []) if frame < rests_for]

    # All of its pictures weigh together as much as one that shows a place of its own.
    assert len(of_rest) <= 1

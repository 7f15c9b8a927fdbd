"""Runs are cut in two to find bodies that turn within them."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import as_frames

from count_video.tracking.pairs.features import FRAMES_AT_LEAST
from count_video.tracking.pairs.finding import halves


@pytest.mark.parametrize("length", range(1, 26))
def test_halves_hold_every_frame_and_enough_of_them_to_show_a_motion(length: int) -> None:
    run = as_frames([np.zeros((2, 2), dtype=np.uint8)] * length)

    parts = halves(run)

    assert {frame.index for part in parts for frame in part} == set(range(length))
    assert all(len(part) >= min(length, FRAMES_AT_LEAST) for part in parts)
    if length >= 2 * FRAMES_AT_LEAST:
        assert sum(map(len, parts)) == length

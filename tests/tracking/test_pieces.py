"""Pieces of pictures keep their brightness, however dark the lamp was."""

from __future__ import annotations

import numpy as np
import pytest

from count_video.tracking.background import Background
from count_video.tracking.composite import STEPS, Source, cut_pieces
from count_video.tracking.light import Light

SIZE = 60, 80
DIM = 0.3
"""Share of the usual light: what is white is brightened beyond the steps that a piece holds."""


@pytest.mark.parametrize("luma", [30, 255])
def test_a_dim_picture_is_brightened_up_to_white_at_most(luma: int) -> None:
    behind = Background(np.full(SIZE, 100, np.uint8), {}, {0: Light(DIM)})
    source = Source({0: np.full(SIZE, luma, np.uint8)}, behind, ())

    seen = cut_pieces(source, {0: (20.0, 20.0)}, ((16, 24), (2, 2))).seen

    brightest = np.iinfo(seen.dtype).max
    assert seen == pytest.approx(min(luma / DIM * STEPS, brightest), abs=1)

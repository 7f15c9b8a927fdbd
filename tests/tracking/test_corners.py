"""Corners are followed with the body they lie on, also where a busy picture lies behind it."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import Luma, texture, to_luma

from count_video.tracking.corners import follow_corners
from count_video.tracking.samples import references

SIZE = 120, 400
SAMPLES = np.arange(24)
BODY, LEFT_PX, TOP_PX = (44, 60), 80, 40
LEVELS = 85, 165
"""The body's pattern is fainter than what lies behind it, and half as coarse."""
FOLLOWED_PX = 1.5
"""Corners that keep their distance from the body so well are its own."""
OFTEN, CORNERS_AT_LEAST = 20, 10
"""So many corners are followed through so many of the samples; by reduced pictures alone, which mix
the body with what lies behind it, three are if it moves by 8 px from one to the next."""


def left_px(step_px: int) -> list[int]:
    return (LEFT_PX + step_px * SAMPLES).tolist()


def pictures(step_px: int) -> list[Luma]:
    body, behind = texture(2, BODY, *LEVELS, 6), texture(1, SIZE, 30, 220, 12)
    seen, rng = [], np.random.default_rng(2)
    for left in left_px(step_px):
        picture = behind.copy()
        picture[TOP_PX : TOP_PX + BODY[0], left : left + BODY[1]] = body
        seen.append(to_luma(picture.astype(np.float64), 1.0, rng))
    return seen


@pytest.mark.parametrize("step_px", [3, 5, 8])
def test_a_faint_pattern_is_followed_before_a_strong_one(step_px: int) -> None:
    moved = np.ones((len(references(len(SAMPLES))), *SIZE), np.bool_)

    places = follow_corners(pictures(step_px), moved).places_px

    away = np.ma.masked_invalid(places[:, :, 0] - np.array(left_px(step_px)))
    often = np.count_nonzero(~np.ma.getmaskarray(away), axis=1) >= OFTEN
    own = np.ptp(away, axis=1).filled(np.inf) < FOLLOWED_PX
    assert np.count_nonzero(often & own) >= CORNERS_AT_LEAST

"""A rail on which blocks and carts run, and the stops at its ends."""

from __future__ import annotations

from synth_video.appearance import BallSettings
from synth_video.paint_block import WHEEL_BELOW
from synth_video.pixels import Pixels
from synth_video.raster import Raster, over

STEEL = (104.0, 106.0, 110.0)
RAIL = (158.0, 160.0, 164.0)
SHINE = (200.0, 202.0, 206.0)
POST_M = 0.016
"""Thickness of the stops."""


def paint_rail(ball: BallSettings, length_m: float, raster: Raster, sheet: Pixels) -> float:
    """Paint the rail under a body of this length, in place, and return the height of its top."""
    half_m = (ball.height_m or length_m) / 2
    wheels_m = 2 * WHEEL_BELOW * half_m if ball.shape == "cart" else 0.0
    top_m = -half_m - wheels_m
    over(sheet, raster.box(-5.0, 5.0, top_m - 0.4 * half_m, top_m), RAIL)
    over(sheet, raster.box(-5.0, 5.0, top_m - 0.4 * half_m, top_m - 0.3 * half_m), STEEL)
    return top_m


def paint_post(left_m: float, foot_m: float, top_m: float, raster: Raster, sheet: Pixels) -> None:
    """Paint a stop that stands on the rail, in place."""
    over(sheet, raster.box(left_m, left_m + POST_M, foot_m, top_m), STEEL)
    face = raster.box(left_m + 0.3 * POST_M, left_m + 0.5 * POST_M, foot_m, top_m)
    over(sheet, 0.6 * face, SHINE)

"""What stands still beside the bodies: the clear plate with its holder, and rails with stops."""

from __future__ import annotations

import numpy as np

from synth_video.appearance import BallSettings, WallSettings
from synth_video.body_picture import Pixels
from synth_video.moving_layers import Standing, standing
from synth_video.paint_background import TABLE_DEPTH_M
from synth_video.paint_bodies import WHEEL_BELOW
from synth_video.raster import Raster, over

# ---- plate ---------------------------------------------------------------------------------------
# The clear plate that the ball strikes, its holder, and what the plate does to the picture.

EDGE_M = 0.0007
DARK = (52.0, 52.0, 54.0)
FOOT_M = -0.046
"""The plate stands on the table here."""


def paint_wall(wall: WallSettings, raster: Raster, sheet: Pixels) -> None:
    """Paint plate and holder over the background, in place."""
    _holder(raster, sheet, wall)
    plate = raster.box(-wall.thickness_m, 0.0, FOOT_M, 1.0)
    over(sheet, plate * wall.opacity, _tint(wall))
    light = tuple(min(255.0, 1.35 * c) for c in wall.tint)
    dark = tuple(0.38 * c for c in wall.tint)
    face = raster.box(-EDGE_M, 0.0, FOOT_M, 1.0)
    back = raster.box(-wall.thickness_m, EDGE_M - wall.thickness_m, FOOT_M, 1.0)
    core = raster.box(-0.55 * wall.thickness_m, -0.30 * wall.thickness_m, FOOT_M, 1.0)
    over(sheet, back * wall.edge, (light[0], light[1], light[2]))
    over(sheet, core * 0.35 * wall.edge, (light[0], light[1], light[2]))
    over(sheet, face * wall.edge, (dark[0], dark[1], dark[2]))


def plate_film(wall: WallSettings, raster: Raster, lens_m: float) -> Standing:
    """Near part of the plate, which reaches over the bodies' side: it stands in front of them."""
    cover = np.zeros(raster.shape, dtype=np.float32)
    if wall.front_m:
        veil = raster.box(0.0, wall.front_m, FOOT_M - 0.006, 1.0)
        edge = raster.box(wall.front_m - 0.8 * EDGE_M, wall.front_m, FOOT_M - 0.006, 1.0)
        cover += 0.35 * wall.opacity * veil + 0.45 * wall.edge * edge
    rgb = cover[..., None] * np.asarray(_tint(wall), dtype=np.float32)
    return standing(raster.picture(rgb, lens_m), raster.picture(cover, lens_m))


def mirror_mask(wall: WallSettings, raster: Raster) -> Pixels:
    """Where the plate's face mirrors the ball, shape (h, w)."""
    return raster.box(-wall.mirror_m, 0.0, FOOT_M, 1.0) * wall.reflection


def plate_clamp(wall: WallSettings, raster: Raster, lens_m: float) -> Standing:
    """Steel jaw in front of plate and bodies, with its screw."""
    cover = np.zeros(raster.shape, dtype=np.float32)
    sheet = raster.blank((0.0, 0.0, 0.0))
    if wall.clamp_m:
        left_m, foot_m, top_m = -wall.thickness_m - 0.020, FOOT_M - 0.02, wall.clamp_up_m
        cover = raster.box(left_m, wall.clamp_m, foot_m, top_m)
        shade = 92 + 26 * np.clip((raster.up_m() - top_m) / 0.004 + 1, 0, 1)
        steel = np.repeat(shade.astype(np.float32), raster.shape[1], axis=1)
        over(sheet, cover, np.stack([steel, steel * 0.98, steel * 0.95], axis=-1))
        screw_m = left_m / 2
        over(
            sheet, raster.box(screw_m - 0.004, screw_m + 0.004, top_m - 0.016, top_m - 0.008), DARK
        )
        over(sheet, raster.box(wall.clamp_m - 0.001, wall.clamp_m, foot_m, top_m), DARK)
    return standing(raster.picture(sheet, lens_m), raster.picture(cover, lens_m))


def _holder(raster: Raster, sheet: Pixels, wall: WallSettings) -> None:
    """Steel block on a base that holds the plate upright."""
    right = -wall.thickness_m
    left, top = right - 0.022, -TABLE_DEPTH_M - 0.002
    base = raster.box(left - 0.02, left + 0.004, FOOT_M - 0.008, FOOT_M - 0.003)
    over(sheet, base, (96.0, 94.0, 92.0))
    block = raster.box(left, right, FOOT_M - 0.008, top)
    shade = (86 - 260 * (raster.up_m() - top)).astype(np.float32)
    metal = np.repeat(np.clip(shade, 60, 120), raster.shape[1], axis=1)
    over(sheet, block, np.stack([metal, metal * 0.97, metal * 0.93], axis=-1))
    over(sheet, raster.box(left, right, top - 0.0012, top), (196.0, 196.0, 192.0))


def _tint(wall: WallSettings) -> tuple[float, float, float]:
    return (float(wall.tint[0]), float(wall.tint[1]), float(wall.tint[2]))


# ---- rail ----------------------------------------------------------------------------------------
# A rail on which blocks and carts run, and the stops at its ends.

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

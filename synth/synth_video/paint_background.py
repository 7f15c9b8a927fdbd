"""What is behind the bodies: table, cloth, plaster, stone, boards on a wall or a full shelf."""

from __future__ import annotations

import cv2
import numpy as np

from synth_video.appearance import BackgroundSettings
from synth_video.paint_boards import hang_boards
from synth_video.paint_clutter import paint_shelf
from synth_video.pixels import Pixels, as_pixels
from synth_video.raster import Raster, over

TABLE_DEPTH_M = 0.033
"""The table's far edge is seen this far below the rest line."""
WOOD = (140.0, 98.0, 68.0)


def paint_background(settings: BackgroundSettings, raster: Raster) -> Pixels:
    """Paint a sheet of the surroundings, out of focus, without wall and bodies; shape (h, w, 3)."""
    painters = {
        "table": _table,
        "cloth": _cloth,
        "plaster": _plaster,
        "shelf": paint_shelf,
        "stone": _stone,
        "boards": _boards,
    }
    sheet = as_pixels(np.clip(painters[settings.kind](settings, raster), 0, 255))
    defocus_px = max(settings.blur_m * raster.px_per_m, 0.3)
    return as_pixels(cv2.GaussianBlur(sheet, (0, 0), defocus_px))


def _table(settings: BackgroundSettings, raster: Raster) -> Pixels:
    """Grey wall behind a wooden table."""
    sheet = _plaster(settings, raster)
    grain = raster.grain(30.0, 0.35) + 0.7 * raster.grain(60.0, 1.6) + 0.4 * raster.grain(9.0, 0.2)
    light = 1 + 0.085 * settings.texture * grain
    # Grain gets denser toward the far edge, and the far part of the table is a little darker.
    depth = np.clip((-TABLE_DEPTH_M - raster.up_m()) / 0.03, 0, 1)
    wood = as_pixels(light * (0.86 + 0.22 * depth))[..., None] * as_pixels(WOOD)
    over(sheet, _below(raster, -TABLE_DEPTH_M), wood)
    return sheet


def _cloth(settings: BackgroundSettings, raster: Raster) -> Pixels:
    """Cloth that hangs behind and lies below, with folds and weave."""
    weave = raster.grain(0.35, 0.9) + raster.grain(0.9, 0.35)
    folds = raster.grain(22.0, 60.0)
    lit = np.where(raster.up_m() < -TABLE_DEPTH_M, 1.12, 1.0).astype(np.float32)
    sheet = raster.blank(_floats(settings.color))
    sheet *= (lit * (1 + settings.texture * (0.06 * weave + 0.10 * folds)))[..., None]
    return sheet


def _plaster(settings: BackgroundSettings, raster: Raster) -> Pixels:
    """Rough wall with uneven light."""
    rough = raster.grain(0.5, 0.5)
    patches = raster.grain(18.0, 12.0)
    falloff = 1 - 0.9 * np.clip(-raster.up_m(), 0, 0.2) + 0.25 * raster.along_m()
    light = falloff * (1 + settings.texture * (0.022 * rough + 0.03 * patches))
    return raster.blank(_floats(settings.color)) * light.astype(np.float32)[..., None]


def _stone(settings: BackgroundSettings, raster: Raster) -> Pixels:
    """Plaster-like wall with mottles of some millimetres."""
    mottles = 0.75 * raster.grain(2.2, 2.2) + 0.65 * raster.grain(5.0, 4.0)
    sheet = _plaster(settings, raster)
    sheet *= as_pixels(1 + 0.06 * settings.texture * mottles)[..., None]
    return sheet


def _boards(settings: BackgroundSettings, raster: Raster) -> Pixels:
    """Plaster on which boards, discs and bars hang."""
    sheet = _plaster(settings, raster)
    hang_boards(sheet, settings.texture, raster)
    return sheet


def _below(raster: Raster, up_m: float) -> Pixels:
    """Coverage of everything below a height."""
    edge = raster.y(up_m)
    rows = np.clip(np.arange(raster.shape[0]) - edge + 0.5, 0, 1).astype(np.float32)
    return np.repeat(rows[:, None], raster.shape[1], axis=1)


def _floats(color: tuple[int, int, int]) -> tuple[float, float, float]:
    return (float(color[0]), float(color[1]), float(color[2]))

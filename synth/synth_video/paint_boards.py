"""Boards, discs and bars on the wall, as high as the bodies hang."""

from __future__ import annotations

import numpy as np

from synth_video.pixels import Pixels, as_pixels
from synth_video.raster import Raster, over

WIDTH_M = (0.010, 0.036)
"""Things are narrower than a ball, so that an edge lies behind each of its places."""
GAP_M = (0.0, 0.012)
HEIGHT_M = (0.016, 0.060)
BAR_WIDTH_M = (0.030, 0.090)
BAR_HEIGHT_M = (0.004, 0.009)
"""A bar runs along the upper or the lower edge of a body, and behind several of its places."""
SHIFT_M = 0.022
"""The middle of a thing is at most so far above or below the bodies' axis."""
CONTRAST = (0.25, 0.75)
"""A thing is darker or brighter than the wall by such a part of the wall's brightness."""
TINT = 0.12
"""Each colour channel of a thing differs from the others by up to such a part."""
DISC_CORNERS = 72


def hang_boards(sheet: Pixels, strength: float, raster: Raster) -> None:
    """Hang things over a sheet of plain wall, in place; the raster's generator draws them.

    Parameters
    ----------
    sheet
        Colours of the wall, shape (h, w, 3).
    strength
        Factor on the contrast of all things; 0 hides them.
    raster
        The sheet's coordinates.
    """
    wall = sheet.copy()
    _row(sheet, wall, strength, raster, bars=False)
    _row(sheet, wall, strength, raster, bars=True)


def _row(sheet: Pixels, wall: Pixels, strength: float, raster: Raster, *, bars: bool) -> None:
    """Hang things side by side along the whole line of motion."""
    rng = raster.rng
    place = float(raster.along_m()[0]) - rng.uniform(*WIDTH_M)
    while place < raster.along_m()[-1]:
        width = rng.uniform(*(BAR_WIDTH_M if bars else WIDTH_M))
        middle = (place + width / 2, rng.uniform(-SHIFT_M, SHIFT_M))
        if bars:
            cover = _board(raster, middle, width, rng.uniform(*BAR_HEIGHT_M))
        elif rng.random() < 0.4:
            cover = _disc(raster, middle, width)
        else:
            cover = _board(raster, middle, width, rng.uniform(*HEIGHT_M))
        over(sheet, cover, wall * _shade(strength, rng))
        place += width + rng.uniform(*(BAR_WIDTH_M if bars else GAP_M))


def _board(
    raster: Raster, middle_m: tuple[float, float], width_m: float, height_m: float
) -> Pixels:
    along_m, up_m = middle_m
    left_m, foot_m = along_m - width_m / 2, up_m - height_m / 2
    return raster.box(left_m, left_m + width_m, foot_m, foot_m + height_m)


def _disc(raster: Raster, middle_m: tuple[float, float], width_m: float) -> Pixels:
    turn = np.linspace(0, 2 * np.pi, DISC_CORNERS, endpoint=False)
    along_m = middle_m[0] + width_m / 2 * np.cos(turn)
    up_m = middle_m[1] + width_m / 2 * np.sin(turn)
    return raster.polygon(list(zip(along_m.tolist(), up_m.tolist(), strict=True)))


def _shade(strength: float, rng: np.random.Generator) -> Pixels:
    """Factor on the wall's colour, shape (3,)."""
    sign = 1 if rng.random() < 0.5 else -1
    tint = 1 + rng.uniform(-TINT, TINT, 3)
    return as_pixels(1 + strength * (sign * rng.uniform(*CONTRAST) + tint - 1))

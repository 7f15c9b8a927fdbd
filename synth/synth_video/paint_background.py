"""What is behind the bodies: table, cloth, plaster, stone, boards on a wall or a full shelf."""

from __future__ import annotations

import cv2
import numpy as np

from synth_video.appearance import BackgroundSettings
from synth_video.body_picture import Pixels, as_pixels
from synth_video.raster import Raster, over

# ---- boards --------------------------------------------------------------------------------------
# Boards, discs and bars on the wall, as high as the bodies hang.

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


# ---- shelf ---------------------------------------------------------------------------------------
# A laboratory shelf: books, bottles, boxes, a stand, a roll of tape.

SHELF_M = -0.030
"""Height of the board on which things stand."""
SPINES = (
    (158, 40, 44), (46, 62, 138), (118, 108, 92), (206, 204, 196), (36, 92, 84), (196, 128, 42),
    (84, 70, 60), (132, 124, 112), (28, 30, 44), (150, 60, 36),
)  # fmt: skip
TITLES = ("MECHANICS", "DATA 2019", "PHYSIK", "Vol. III", "Experiments", "CALIBRATION", "OPTICS")
GLASS = ((212, 178, 44), (214, 216, 218), (186, 44, 36), (34, 34, 38), (70, 128, 90))


def paint_shelf(settings: BackgroundSettings, raster: Raster) -> Pixels:
    """Paint a sheet of clutter; what stands where is drawn from the raster's generator."""
    sheet = raster.blank((132.0, 126.0, 118.0))
    sheet *= (1 + 0.02 * settings.texture * raster.grain(0.6, 0.6))[..., None]
    _books(raster, sheet)
    board = raster.box(-1.0, 2.0, -1.0, SHELF_M)
    lit = (212 + 3.0 * settings.texture * raster.grain(6.0, 1.0)).astype(np.float32)
    over(sheet, board, np.stack([lit, lit * 0.985, lit * 0.99], axis=-1))
    _row_of_things(raster, sheet)
    return sheet


def _books(raster: Raster, sheet: Pixels) -> None:
    """Stand books side by side behind everything."""
    rng = raster.rng
    left, end = raster.along_m()[0] - 0.02, raster.along_m()[-1]
    while left < end:
        width, height = rng.uniform(0.008, 0.020), rng.uniform(0.055, 0.105)
        color = np.array(SPINES[rng.integers(len(SPINES))]) * rng.uniform(0.8, 1.15)
        box = raster.box(left, left + width - 0.0006, SHELF_M, SHELF_M + height)
        across = (raster.along_m() - left) / width
        round_back = (1.08 - 0.5 * (across - 0.4) ** 2).astype(np.float32)
        over(sheet, box, color.astype(np.float32) * round_back[None, :, None])
        for place in rng.uniform(0.05, 0.95, 2):
            band = raster.box(
                left, left + width - 0.0006, SHELF_M + place * height,
                SHELF_M + place * height + 0.0012,
            )  # fmt: skip
            over(sheet, band * 0.7, (214.0, 196.0, 140.0))
        if width > 0.010 and rng.random() < 0.8:
            title = TITLES[rng.integers(len(TITLES))]
            _upright_title(raster, sheet, title, (left + 0.3 * width, SHELF_M + 0.25 * height))
        left += width


def _upright_title(raster: Raster, sheet: Pixels, text: str, corner_m: tuple[float, float]) -> None:
    """Write a title up a spine from its lower left corner."""
    ink = cv2.rotate(raster.lettering(text, 0.0042), cv2.ROTATE_90_COUNTERCLOCKWISE)
    x, bottom = round(raster.x(corner_m[0])), round(raster.y(corner_m[1]))
    top, left = max(bottom - ink.shape[0], 0), max(x, 0)
    part = sheet[top : max(bottom, 0), left : max(x + ink.shape[1], 0)]
    ink = ink[top - bottom + ink.shape[0] :, left - x :][: part.shape[0], : part.shape[1]]
    over(part, as_pixels(ink) * np.float32(0.8 / 255), (228.0, 224.0, 210.0))


def _row_of_things(raster: Raster, sheet: Pixels) -> None:
    """Stand boxes, bottles and a stand on the board, with gaps."""
    rng = raster.rng
    place = float(raster.along_m()[0]) + rng.uniform(0.0, 0.03)
    things = (_bottle, _box, _bottle, _tape, _stand)
    number = int(rng.integers(len(things)))
    while place < raster.along_m()[-1]:
        place += things[number % len(things)](raster, sheet, place) + rng.uniform(0.01, 0.045)
        number += int(rng.integers(1, 3))


def _bottle(raster: Raster, sheet: Pixels, left: float) -> float:
    """Bottle with a neck and a highlight; returns its width."""
    rng = raster.rng
    width, height = rng.uniform(0.012, 0.020), rng.uniform(0.035, 0.060)
    color = np.array(GLASS[rng.integers(len(GLASS))], dtype=np.float32)
    foot, neck = SHELF_M - 0.006, 0.32 * width
    shape = [
        (left, foot), (left + width, foot), (left + width, foot + 0.6 * height),
        (left + width - neck, foot + 0.78 * height), (left + width - neck, foot + height),
        (left + neck, foot + height), (left + neck, foot + 0.78 * height),
        (left, foot + 0.6 * height),
    ]  # fmt: skip
    across = ((raster.along_m() - left) / width).astype(np.float32)
    glass = 0.55 + 0.6 * np.exp(-(((across - 0.3) / 0.28) ** 2))
    over(sheet, raster.polygon(shape), color * glass[None, :, None])
    cap = raster.box(
        left + neck * 0.9, left + width - neck * 0.9, foot + 0.9 * height, foot + 1.06 * height
    )
    over(sheet, cap, (60.0, 44.0, 40.0))
    return float(width)


def _box(raster: Raster, sheet: Pixels, left: float) -> float:
    """Cardboard box with a lit lid; returns its width."""
    width, height = raster.rng.uniform(0.025, 0.045), raster.rng.uniform(0.018, 0.032)
    foot = SHELF_M - 0.010
    over(sheet, raster.box(left, left + width, foot, foot + height), (166.0, 118.0, 74.0))
    lid = [
        (left, foot + height), (left + width, foot + height),
        (left + width - 0.003, foot + height + 0.004), (left + 0.003, foot + height + 0.004),
    ]  # fmt: skip
    over(sheet, raster.polygon(lid), (196.0, 150.0, 104.0))
    return float(width)


def _tape(raster: Raster, sheet: Pixels, left: float) -> float:
    """Roll of tape lying on the board; returns its width."""
    width, foot = 0.026, SHELF_M - 0.020
    over(sheet, raster.box(left, left + width, foot, foot + 0.009), (196.0, 158.0, 92.0))
    over(sheet, raster.box(left + 0.002, left + width - 0.002, foot + 0.009, foot + 0.012),
         (224.0, 190.0, 128.0))  # fmt: skip
    return width


def _stand(raster: Raster, sheet: Pixels, left: float) -> float:
    """Steel rod on a green foot, with a clamp; returns its width."""
    width, foot = 0.048, SHELF_M - 0.012
    over(sheet, raster.box(left, left + width, foot, foot + 0.004), (42.0, 70.0, 58.0))
    middle = left + width / 2
    across = ((raster.along_m() - middle) / 0.002).astype(np.float32)
    steel = 110 + 120 * np.exp(-(((across + 0.3) / 0.4) ** 2))
    over(sheet, raster.box(middle - 0.002, middle + 0.002, foot + 0.004, 0.5),
         np.repeat(steel[None, :, None], 3, axis=2))  # fmt: skip
    over(sheet, raster.box(middle - 0.005, middle + 0.005, 0.012, 0.022), (74.0, 70.0, 72.0))
    return width


# ---- backgrounds ---------------------------------------------------------------------------------
# What is behind the bodies: table, cloth, plaster, stone, boards on a wall or a full shelf.

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

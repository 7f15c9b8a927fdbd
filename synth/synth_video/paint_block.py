"""Bodies other than ball and cylinder: a wooden block, a cart, a puck."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats
from synth_video.appearance import Color
from synth_video.body_picture import BodyPicture
from synth_video.canvas import BodyCanvas, body_canvas, printed
from synth_video.pixels import as_pixels

CORNER = 0.03
"""Radius of the broken edges, in half heights."""
WHEEL, WHEEL_LENGTH = 0.30, 0.21
"""Greatest radius of a cart's wheels, in its height and in its length."""
WHEEL_BELOW = 0.10
"""How far they stand out below, in its height."""
SPIN_MARK = 0.16
"""Half width of the cross on a puck, in its radii."""


@dataclass(frozen=True)
class BlockAppearance:
    """Size, place and colours of a body with straight faces, or of a puck."""

    left_px: float
    right_px: float
    """Its faces along the line of motion, from its reference point."""
    height_px: float
    color: Color
    trim_color: Color
    """Tape, wheels, rim."""
    mark_color: Color
    mark: str
    """Printed on it; empty for none."""


def paint_block(block: BlockAppearance, tilt_deg: float, blur_px: float) -> BodyPicture:
    """Paint a block of wood with a band of tape. Channels: as a ball's."""
    half = block.height_px / 2
    canvas = body_canvas((block.left_px, block.right_px), (-half, half), tilt_deg, blur_px)
    along, down = canvas.along_px - block.left_px, canvas.down_px
    length = block.right_px - block.left_px
    cover = canvas.coverage(_box(along, down, length, half))
    rings = np.sin(9 * down / half + 2.5 * np.sin(2.2 * along / half + 0.6) + 0.8 * along / half)
    light = 0.95 + 0.10 * rings - 0.16 * (down / half) + 0.05 * np.cos(31 * down / half)
    band = np.abs(along - 0.30 * length) < 0.09 * length
    rgb = np.multiply.outer(np.array(block.color, float), light)
    rgb[:, band] = np.array(block.trim_color, float)[:, None] * light[band]
    _write(rgb, block, (along - 0.66 * length) / half, down / half)
    return _finish(canvas, rgb * _edges(along, down, length, half), cover, blur_px)


def paint_cart(block: BlockAppearance, tilt_deg: float, blur_px: float) -> BodyPicture:
    """Paint a cart seen from the side: body, plate and two wheels. Channels: as a ball's."""
    half = block.height_px / 2
    length = block.right_px - block.left_px
    wheel, bottom = (
        min(WHEEL * block.height_px, WHEEL_LENGTH * length),
        half * (1 + 2 * WHEEL_BELOW),
    )
    canvas = body_canvas((block.left_px, block.right_px), (-half, bottom), tilt_deg, blur_px)
    along, down = canvas.along_px - block.left_px, canvas.down_px
    body = canvas.coverage(_box(along, down + 0.25 * half, length, 0.75 * half))
    light = 1.0 - 0.22 * (down / half) + 0.30 * np.exp(-(((down / half + 0.55) / 0.10) ** 2))
    rgb = np.multiply.outer(np.array(block.color, float), light)
    plate = (np.abs(along - length / 2) < 0.22 * length) & (np.abs(down + 0.2 * half) < 0.42 * half)
    rgb[:, plate] = np.array(block.trim_color, float)[:, None] * light[plate]
    _write(rgb, block, (along - length / 2) / half, down / half + 0.2)
    cover = body
    rgb *= _edges(along, down + 0.25 * half, length, 0.75 * half)
    for place in (0.22, 0.78):
        from_axle = np.hypot(along - place * length, down - bottom + wheel)
        tyre = canvas.coverage(from_axle - wheel)
        shade = np.where(from_axle < 0.45 * wheel, 150.0, 42.0)
        rgb += (shade - rgb) * tyre
        cover = cover + tyre - cover * tyre
    return _finish(canvas, rgb, cover, blur_px)


def paint_puck(
    block: BlockAppearance, tilt_deg: float, blur_px: float, turn_rad: float = 0.0
) -> BodyPicture:
    """Paint a puck seen from above, turned; its height is its diameter. Channels: as a ball's."""
    radius = (block.right_px - block.left_px) / 2
    middle = (block.right_px + block.left_px) / 2
    canvas = body_canvas((block.left_px, block.right_px), (-radius, radius), tilt_deg, blur_px)
    u, v = (canvas.along_px - middle) / radius, canvas.down_px / radius
    from_middle = np.hypot(u, v)
    cover = canvas.coverage((from_middle - 1) * radius)
    cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
    x, y = u * cosine + v * sine, v * cosine - u * sine
    light = 0.98 - 0.10 * (u + v) + 0.12 * np.clip(1 - np.abs(from_middle - 0.86) / 0.05, 0, 1)
    rgb = np.multiply.outer(np.array(block.color, float), light)
    cross = (np.minimum(np.abs(x), np.abs(y)) < SPIN_MARK / 2) & (from_middle < 0.62) & (x > -0.2)
    for color, part in (
        (block.trim_color, from_middle > 0.80),
        (block.mark_color, cross),
    ):
        rgb[:, part] = np.array(color, float)[:, None] * light[part]
    knob = np.clip((0.22 - from_middle) * 12, 0, 1)
    rgb += (60.0 + 90 * np.clip(-u - v, 0, 1) - rgb) * knob
    return _finish(canvas, rgb, cover, blur_px)


def _box(along: Floats, down: Floats, length: float, half: float) -> Floats:
    """Distance outside a box with broken corners, negative inside."""
    corner = CORNER * half
    dx = np.abs(along - length / 2) - length / 2 + corner
    dy = np.abs(down) - half + corner
    beyond = np.hypot(np.clip(dx, 0, None), np.clip(dy, 0, None))
    return np.asarray(beyond + np.minimum(np.maximum(dx, dy), 0) - corner)


def _edges(along: Floats, down: Floats, length: float, half: float) -> Floats:
    """Brightness near the outline: lit above and at the left, dark below and at the right."""
    width = 0.06 * half
    lit = np.exp(-(((down + half) / width) ** 2)) + 0.6 * np.exp(-((along / width) ** 2))
    dark = np.exp(-(((down - half) / width) ** 2))
    dark += 0.6 * np.exp(-(((along - length) / width) ** 2))
    return np.asarray(1 + 0.25 * lit - 0.35 * dark)


def _write(rgb: Floats, block: BlockAppearance, x: Floats, y: Floats) -> None:
    """Print the mark about the point (0, 0) of coordinates in half heights, in place."""
    if not block.mark:
        return
    page = as_pixels(printed(block.mark, 48.0, 1))
    columns, rows = x * 80 + page.shape[1] / 2, y * 80 + page.shape[0] / 2
    grid = columns.astype(np.float32), rows.astype(np.float32)
    ink = cv2.remap(page, *grid, cv2.INTER_LINEAR)
    rgb += (np.array(block.mark_color, float)[:, None, None] - rgb) * ink


def _finish(canvas: BodyCanvas, rgb: Floats, cover: Floats, blur_px: float) -> BodyPicture:
    return canvas.finish([*(np.clip(rgb, 0, 255) * cover), cover], blur_px)

"""The bodies: a table-tennis ball, a brass cylinder, and a block, a cart or a puck."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats
from synth_video.appearance import BallSettings, Color, CylinderSettings
from synth_video.body_picture import BodyCanvas, BodyPicture, as_pixels, body_canvas, printed

# ---- ball ----------------------------------------------------------------------------------------
# The light body: a table-tennis ball with its plastic ring and print.

LAMP = np.array([-0.35, -0.72, 0.60])
"""Direction to the main lamp: left, above (y is down), in front."""
PRINT_CELLS = 160.0
"""Cells of the print to a ball radius."""
RING_HALF_WIDTH = 0.055
RING_YAW = 0.12
"""The ring's half width in ball radii, and the sine of its turn toward the camera."""


@dataclass(frozen=True)
class BallView:
    """From where a ball is seen."""

    diameter_px: float
    tilt_deg: float
    blur_px: float
    """Standard deviation of the lens blur."""
    reflected: bool = False
    """True for its image in a mirror at its side."""
    cells_per_px: int | None = None
    """None for as fine as its size allows."""


def paint_ball(ball: BallSettings, view: BallView, turn_rad: float = 0.0) -> BodyPicture:
    """Paint the ball about its centre, turned about its axis.

    Channels: red, green, blue (premultiplied), coverage.
    """
    blur_px = view.blur_px
    radius = view.diameter_px / 2
    reach = radius * (1 + 2 * RING_HALF_WIDTH) if ball.ring else radius
    canvas = body_canvas(
        (-radius, radius), (-reach, reach), view.tilt_deg, blur_px, view.cells_per_px
    )
    along = -canvas.along_px if view.reflected else canvas.along_px
    cover = canvas.coverage(np.hypot(along, canvas.down_px) - radius)
    rgb = _shaded(ball, along / radius, canvas.down_px / radius, turn_rad)
    if ball.ring:
        ring, shade = _ring(along, canvas.down_px, radius, canvas)
        ring_rgb = np.multiply.outer(np.array(ball.ring_color, float), shade)
        rgb = rgb * (cover * (1 - ring)) + ring_rgb * ring
        cover = cover + ring - cover * ring
    else:
        rgb = rgb * cover
    return canvas.finish([*rgb, cover], blur_px)


def _shaded(ball: BallSettings, u: Floats, v: Floats, turn_rad: float) -> Floats:
    """Colour of the sphere's surface, shape (3, h, w); u, v in ball radii."""
    w = np.sqrt(np.clip(1 - u * u - v * v, 0, 1))
    lamp = LAMP / np.linalg.norm(LAMP)
    lit = np.clip(u * lamp[0] + v * lamp[1] + w * lamp[2], 0, 1)
    bounce = np.clip(v, 0, 1) * 0.16  # light thrown back by the table
    shade = 1 + ball.shading * (0.62 * lit + bounce - 0.50)
    halfway = lamp + np.array([0, 0, 1])
    halfway /= np.linalg.norm(halfway)
    gleam = np.clip(u * halfway[0] + v * halfway[1] + w * halfway[2], 0, 1) ** 48
    surface = np.multiply.outer(np.array(ball.color, float), np.ones_like(u))
    ink = _ink(ball, *_turned(ball, u, v, w, turn_rad))
    surface += (np.array(ball.mark_color, float)[:, None, None] - surface) * ink * 0.85
    return np.asarray(np.clip(surface * shade + 190 * ball.gloss * gleam, 0, 255))


def _turned(
    ball: BallSettings, u: Floats, v: Floats, w: Floats, turn_rad: float
) -> tuple[Floats, Floats, Floats]:
    """Points of the surface in the coordinates of a ball that has turned about its axis."""
    cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
    if ball.spin_axis == "upright":
        return u * cosine - w * sine, v, u * sine + w * cosine
    return u * cosine + v * sine, v * cosine - u * sine, w


def _ink(ball: BallSettings, u: Floats, v: Floats, w: Floats) -> Floats:
    """How far the surface has the colour of the mark, 0 to 1; u, v, w in ball radii."""
    if ball.pattern == "stripes":
        # Edges of the stripes lie at right angles to the line of motion: the hardest to bear.
        return np.asarray(np.clip(0.5 + 6 * np.sin(6 * np.arctan2(u, w)), 0, 1))
    if ball.pattern == "halves":
        return np.asarray(np.clip(0.5 + 20 * u, 0, 1))
    if ball.pattern == "print" and ball.mark:
        return _mark(ball.mark, u, v, w)
    return np.zeros_like(u)


def _mark(text: str, u: Floats, v: Floats, w: Floats) -> Floats:
    """Coverage of the print, wrapped round the sphere to the right of its middle."""
    page = printed(text, 0.30 * PRINT_CELLS, 1)
    dots = printed("* * *", 0.22 * PRINT_CELLS, 1)
    ink = np.zeros_like(u)
    for picture, middle in ((page, 0.02), (dots, -0.36)):
        longitude, latitude = np.arctan2(u, w), np.arcsin(np.clip(v, -1, 1))
        x = (longitude - 0.62) * PRINT_CELLS + picture.shape[1] / 2
        y = (latitude - middle) * PRINT_CELLS + picture.shape[0] / 2
        ink = np.maximum(
            ink, cv2.remap(picture, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR)
        )
    return ink


def _ring(along: Floats, down: Floats, radius: float, canvas: BodyCanvas) -> tuple[Floats, Floats]:
    """Coverage and brightness of the front half of a thin hoop round the ball, nearly edge-on."""
    half = RING_HALF_WIDTH * radius
    hoop = radius + half
    middle = hoop * RING_YAW * np.sqrt(np.clip(1 - (down / hoop) ** 2, 0, 1))
    outside = np.maximum(np.abs(along - middle) - half, np.abs(down) - hoop - half)
    shade = 0.75 + 0.55 * np.clip(-down / hoop, 0, 1) + 0.5 * np.clip((middle - along) / half, 0, 1)
    return canvas.coverage(outside), shade


# ---- cylinder ------------------------------------------------------------------------------------
# The heavy body: a polished brass cylinder seen from the side, with modelling clay at its end.

CLAY_LENGTH = 0.26
"""How far the clay stands out, in cylinder radii."""
POLISH = (
    # Height of the middle across the cylinder (-1 top to 1 bottom), width, brightness added.
    (-0.60, 0.13, 0.34),
    (-0.30, 0.22, 0.22),
    (0.16, 0.14, -0.34),
    (0.52, 0.13, 0.34),
    (0.95, 0.16, -0.38),
    (-1.00, 0.10, -0.30),
)
WHITER = np.array([30.0, 42.0, 70.0])
"""Red, green and blue added where the brass shines most."""
GLINT_HEIGHT, GLINT_WIDTH = -0.60, 0.075
"""The band in which the lamps are mirrored."""


def paint_cylinder(
    cylinder: CylinderSettings, px_per_m: float, tilt_deg: float, blur_px: float
) -> BodyPicture:
    """Paint the cylinder about the centre of the face that meets the ball.

    Channels: red, green, blue (premultiplied), coverage, and the strength with which the cylinder
    mirrors the lamps: where they are seen is settled in the picture, not on the cylinder.
    """
    length, radius = cylinder.length_m * px_per_m, cylinder.diameter_m * px_per_m / 2
    reach, rim = length, cylinder.rim_m * px_per_m
    if cylinder.clay:
        reach += CLAY_LENGTH * radius + 1
    canvas = body_canvas((-rim, reach), (-radius, radius), tilt_deg, blur_px)
    along, down = canvas.along_px, canvas.down_px
    corner = 0.02 * radius  # turned edges are broken a little
    brass = canvas.coverage(_rounded_box(along - length / 2, down, length / 2, radius, corner))
    rgb = _brass(cylinder, along, down, length, radius)
    glint = np.exp(-(((down / radius - GLINT_HEIGHT) / GLINT_WIDTH) ** 2)) * brass
    glint *= canvas.coverage(2 * corner - along) * canvas.coverage(along - length + 2 * corner)
    cover = brass
    if cylinder.clay:
        clay, clay_rgb = _clay(cylinder, along - length, down, radius, canvas)
        clay = clay * (1 - brass)
        rgb = rgb * brass + clay_rgb * clay
        cover = brass + clay
    else:
        rgb = rgb * brass
    if rim:
        near = canvas.coverage((np.hypot(along / rim, down / radius) - 1) * rim) * (1 - cover)
        rgb, cover = rgb + _face(cylinder, down / radius) * near, cover + near
    layers = [*rgb, cover, glint * cylinder.glint]
    return canvas.finish(layers, blur_px)


def _face(cylinder: CylinderSettings, height: Floats) -> Floats:
    """Colour of the front face, turned away from the lamps, shape (3, h, w)."""
    return np.asarray(np.multiply.outer(np.array(cylinder.color, float), 0.62 - 0.25 * height))


def _rounded_box(x: Floats, y: Floats, half_x: float, half_y: float, corner: float) -> Floats:
    """Distance outside a box with rounded corners, negative inside."""
    dx, dy = np.abs(x) - half_x + corner, np.abs(y) - half_y + corner
    beyond = np.hypot(np.clip(dx, 0, None), np.clip(dy, 0, None))
    return beyond + np.minimum(np.maximum(dx, dy), 0) - corner


def _brass(
    cylinder: CylinderSettings, along: Floats, down: Floats, length: float, radius: float
) -> Floats:
    """Colour of the polished side, shape (3, h, w)."""
    height = np.clip(down / radius, -1, 1)
    shine = np.full_like(height, 0.74)
    for middle, width, gain in POLISH:
        shine += gain * np.exp(-(((height - middle) / width) ** 2))
    ends = np.minimum(along, length - along) / radius
    shine *= (
        1 + 0.25 * np.exp(-((ends / 0.03) ** 2)) - 0.22 * np.exp(-(((ends - 0.07) / 0.02) ** 2))
    )
    # What it mirrors is not the same all over.
    shine *= 1 + 0.05 * np.cos(along / length * 5.0 + 1.0)
    for place in (0.17, 0.80):  # the slings that carry it
        sling = np.exp(-(((along / length - place) * length / (0.012 * radius + 0.3)) ** 2))
        shine *= 1 + 0.16 * sling
    white = np.clip(shine - 1.0, 0, 1)
    rgb = np.multiply.outer(np.array(cylinder.color, float), np.clip(shine, 0.12, None))
    return np.asarray(np.clip(rgb + white * WHITER[:, None, None], 0, 255))


def _clay(
    cylinder: CylinderSettings, beyond: Floats, down: Floats, radius: float, canvas: BodyCanvas
) -> tuple[Floats, Floats]:
    """Coverage and colour of the lump of clay behind the cylinder."""
    angle = np.arctan2(down, beyond)
    lump = 1 + 0.05 * np.sin(3 * angle + 0.7) + 0.04 * np.sin(7 * angle)
    depth, height = CLAY_LENGTH * radius, 0.55 * radius
    level = np.hypot(beyond / depth, down / height) / lump
    # The slope of ``level`` is at most 1 / depth: dividing by it keeps the edge one cell soft.
    cover = canvas.coverage((level - 1) * depth) * (beyond > -0.5)
    shade = 0.75 - 0.45 * down / height + 0.25 * np.clip(1 - beyond / depth, 0, 1)
    rgb = np.multiply.outer(np.array(cylinder.clay_color, float), np.clip(shade, 0.25, 1.6))
    return cover, np.clip(rgb, 0, 255)


# ---- block, cart and puck ------------------------------------------------------------------------
# Bodies other than ball and cylinder: a wooden block, a cart, a puck.

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
    cover = canvas.coverage(_rounded_box(along - length / 2, down, length / 2, half, CORNER * half))
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
    wheel = min(WHEEL * block.height_px, WHEEL_LENGTH * length)
    bottom = half * (1 + 2 * WHEEL_BELOW)
    canvas = body_canvas((block.left_px, block.right_px), (-half, bottom), tilt_deg, blur_px)
    along, down = canvas.along_px - block.left_px, canvas.down_px
    side = 0.75 * half
    box = _rounded_box(along - length / 2, down + 0.25 * half, length / 2, side, CORNER * side)
    body = canvas.coverage(box)
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
    for color, part in ((block.trim_color, from_middle > 0.80), (block.mark_color, cross)):
        rgb[:, part] = np.array(color, float)[:, None] * light[part]
    knob = np.clip((0.22 - from_middle) * 12, 0, 1)
    rgb += (60.0 + 90 * np.clip(-u - v, 0, 1) - rgb) * knob
    return _finish(canvas, rgb, cover, blur_px)


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

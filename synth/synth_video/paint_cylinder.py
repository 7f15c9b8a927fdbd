"""The heavy body: a polished brass cylinder seen from the side, with modelling clay at its end."""

from __future__ import annotations

import numpy as np

from count_video.records import Floats
from synth_video.appearance import CylinderSettings
from synth_video.body_picture import BodyPicture
from synth_video.canvas import BodyCanvas, body_canvas

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
    shine *= 1 + 0.05 * np.cos(
        along / length * 5.0 + 1.0
    )  # what it mirrors is not the same all over
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

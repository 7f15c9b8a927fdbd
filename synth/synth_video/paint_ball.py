"""The light body: a table-tennis ball with its plastic ring and print."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats
from synth_video.appearance import BallSettings
from synth_video.body_picture import BodyPicture
from synth_video.canvas import BodyCanvas, body_canvas, printed

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

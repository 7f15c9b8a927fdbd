"""Pictures of known positions, drawn by area coverage; (0, 0) is the centre of the first pixel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.records import Floats, Frame

Luma = NDArray[np.uint8]
Canvas = NDArray[np.float64]

PX_PER_M = 900.0
RADIUS_PX = 18.0
FRAMES = 240
SAMPLES = 8
"""A pixel's share of a disc is taken from so many samples a side."""


def paint_disc(canvas: Canvas, x: float, y: float, radius: float, grey: float) -> None:
    """Lay a disc over the canvas, shape (height, width), in place."""
    rows, columns = canvas.shape
    left, right = _span(x, radius, columns)
    top, bottom = _span(y, radius, rows)
    if left >= right or top >= bottom:
        return
    offset = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    fine_x = (np.arange(left, right)[:, None] + offset).ravel() - x
    fine_y = (np.arange(top, bottom)[:, None] + offset).ravel() - y
    inside = fine_x[None, :] ** 2 + fine_y[:, None] ** 2 < radius**2
    share = inside.reshape(bottom - top, SAMPLES, right - left, SAMPLES).mean(axis=(1, 3))
    part = canvas[top:bottom, left:right]
    part += share * (grey - part)


def _span(middle: float, radius: float, size: int) -> tuple[int, int]:
    return max(0, int(np.floor(middle - radius))), min(size, int(np.ceil(middle + radius)) + 1)


def paint_box(canvas: Canvas, box: tuple[float, float, float, float], grey: float) -> None:
    """Lay an upright box (left, top, right, bottom edges) over the canvas, exactly, in place."""
    left, top, right, bottom = box
    x = np.arange(canvas.shape[1], dtype=np.float64)
    y = np.arange(canvas.shape[0], dtype=np.float64)
    across = np.clip(np.minimum(x + 0.5, right) - np.maximum(x - 0.5, left), 0, 1)
    down = np.clip(np.minimum(y + 0.5, bottom) - np.maximum(y - 0.5, top), 0, 1)
    canvas += down[:, None] * across * (grey - canvas)


def paint_ball(canvas: Canvas, x: float, y: float, radius: float) -> None:
    """Lay a light ball with a dark ring and two marks over the canvas."""
    paint_disc(canvas, x, y, radius, 215.0)
    paint_disc(canvas, x, y, 0.55 * radius, 90.0)
    paint_disc(canvas, x, y, 0.35 * radius, 215.0)
    paint_disc(canvas, x + 0.1 * radius, y - 0.75 * radius, 0.12 * radius, 60.0)
    paint_disc(canvas, x - 0.2 * radius, y + 0.75 * radius, 0.12 * radius, 60.0)


def paint_cylinder(canvas: Canvas, face: float, y: float, size: tuple[float, float]) -> None:
    """Lay a dark box with a highlight and marks over the canvas.

    ``size`` is width and height; a negative width reaches to the left of the face.
    """
    width, height = size
    top = y - height / 2
    left, right = sorted((face, face + width))
    paint_box(canvas, (left, top, right, y + height / 2), 60.0)
    paint_box(canvas, (left, top + 0.2 * height, right, top + 0.35 * height), 150.0)
    for along, down in ((0.15, 0.6), (0.4, 0.8), (0.55, 0.5), (0.85, 0.7), (0.2, 0.9)):
        paint_disc(canvas, face + along * width, top + down * height, 2.5, 190.0)


def background(shape: tuple[int, int], seed: int = 0) -> Canvas:
    """Return a soft, cluttered backdrop that stands still."""
    rng = np.random.default_rng(seed)
    y, x = np.indices(shape, dtype=np.float64)
    canvas = 125.0 + 15.0 * np.sin(x / 23.0) * np.cos(y / 17.0)
    for _ in range(12):
        place = rng.uniform(0, shape[1]), rng.uniform(0, shape[0])
        paint_disc(canvas, *place, rng.uniform(2, 5), rng.uniform(90, 160))
    return canvas


def texture(seed: int, size: tuple[int, int], low: int, high: int, block: int = 5) -> Luma:
    """Blocks of so many px, each of a random grey from ``low`` on and below ``high``."""
    coarse = np.random.default_rng(seed).integers(
        low, high, (size[0] // block + 1, size[1] // block + 1)
    )
    return np.kron(coarse, np.ones((block, block)))[: size[0], : size[1]].astype(np.uint8)


def to_luma(canvas: Canvas, noise: float = 0.0, rng: np.random.Generator | None = None) -> Luma:
    """Round to grey levels, after adding white noise of so many levels."""
    if rng is not None and noise > 0:
        canvas = canvas + rng.normal(0.0, noise, canvas.shape)
    return np.clip(np.round(canvas), 0, 255).astype(np.uint8)


@dataclass(frozen=True)
class Scene:
    """Two bodies on a tilted line of motion before a backdrop that stands still."""

    ball_px: Floats
    """Image x of the ball's centre in each frame, shape (n,)."""
    face_px: Floats
    """Image x of the cylinder's face."""
    radius_px: float = 18.0
    shape: tuple[int, int] = (112, 320)
    wall_left: bool = True
    tilt_deg: float = 0.0
    ball_contrast: float = 1.0
    """Share of the ball's contrast that is left."""

    def frames(self, noise: float = 0.8, seed: int = 0) -> list[Luma]:
        """Draw every frame."""
        rng = np.random.default_rng([seed, 9])
        behind = background(self.shape, seed)
        return [
            to_luma(self._drawn(behind, ball, face), noise, rng)
            for ball, face in zip(self.ball_px, self.face_px, strict=True)
        ]

    def _drawn(self, behind: Canvas, ball: float, face: float) -> Canvas:
        canvas = behind.copy()
        width = 70.0 if self.wall_left else -70.0
        paint_cylinder(canvas, face, self._row(face + width / 2), (width, 2.4 * self.radius_px))
        plain = canvas.copy()
        paint_ball(canvas, ball, self._row(ball), self.radius_px)
        return np.asarray(plain + self.ball_contrast * (canvas - plain))

    def _row(self, x: float) -> float:
        rise = float(np.tan(np.radians(self.tilt_deg)))
        return (self.shape[0] - 1) / 2 + rise * (x - (self.shape[1] - 1) / 2)


def scene(tilt_deg: float = 0.0, wall_left: bool = True) -> Scene:
    """Return a simulated trial at 1:16, seen at 300 frames per second."""
    setup = Setup(heavy_mass_kg=0.0105 * 16, wall_gap_m=0.03)
    motion = simulate(setup)
    sample = motion.sample(motion.burst[0].time_s + (np.arange(FRAMES) - 40) / 300)
    ball = 30.0 + RADIUS_PX + PX_PER_M * sample.ball_far_face_m
    gap = PX_PER_M * (sample.heavy_face_m - sample.ball_near_face_m)
    face = ball + RADIUS_PX + gap
    if not wall_left:
        ball, face = 319.0 - ball, 319.0 - face
    return Scene(ball, face, RADIUS_PX, tilt_deg=tilt_deg, wall_left=wall_left)


def displaced(luma: Luma, shift: tuple[float, float]) -> Luma:
    """Move a picture to the right and down, as a shaken camera would; edges go on."""
    moved = ndimage.shift(luma.astype(np.float64), shift[::-1], order=3, mode="nearest")
    return to_luma(moved)


def as_frames(pictures: Sequence[Luma], first: int = 0) -> list[Frame]:
    """Wrap pictures as consecutive frames."""
    return [Frame(k, luma, repeats_previous=False) for k, luma in enumerate(pictures, first)]

"""A person at the edge of the picture: a coat with folds and checks, out of focus, that sways."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats
from synth_video.body_picture import BodyPicture
from synth_video.exposure import Paths
from synth_video.moving_layers import Layer
from synth_video.pixels import Pixels, as_pixels
from synth_video.projection import Projection

COAT = np.array([74.0, 82.0, 104.0])
CHECK = np.array([150.0, 66.0, 58.0])
SKIN = np.array([196.0, 146.0, 118.0])
SOFT_M = 0.0012
"""Defocus of somebody who stands behind the apparatus."""
SWAY_SHARE = 0.4
"""Part of the reach by which the person sways about its mean place."""
DIP_M = 0.006
"""Height of the sway."""


@dataclass(frozen=True)
class Person:
    """Somebody who sways into the picture and out of it."""

    picture: BodyPicture
    """About the foremost point of the coat, which reaches away from the bodies."""
    edge_m: float
    """Distance from the wall of the picture's edge."""
    inward: int
    """-1 where the person comes from far off, 1 from behind the wall."""
    reach_m: float
    speed_m_s: float
    phase_rad: float

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Lay the coat where the person has swayed to."""
        sway_m = SWAY_SHARE * self.reach_m
        angle = self.speed_m_s / sway_m * paths.times_s + self.phase_rad
        along_m = self.edge_m + self.inward * (self.reach_m - sway_m * (1 - np.sin(angle)))
        up_m = DIP_M * np.sin(0.7 * angle)
        yield Layer(self.picture.placed(*projection.tilted(along_m, up_m)))


def paint_person(
    width_px: int, height_px: int, px_per_m: float, inward: int, rng: np.random.Generator
) -> BodyPicture:
    """Paint a coat of this size, its foremost point in the middle of one upright side.

    Channels: red, green, blue (premultiplied), coverage.
    """
    # Depth counts from the foremost point into the coat.
    depth_m = np.arange(width_px) / px_per_m
    down_m = ((np.arange(height_px, dtype=np.float64) - height_px / 2) / px_per_m)[:, None]
    front_m = _front_m(down_m, rng)
    cover = as_pixels(np.clip((depth_m - front_m) * px_per_m, 0, 1))
    folds = _noise((height_px, width_px), 0.02 * px_per_m, rng)
    weave = _noise((height_px, width_px), 0.0012 * px_per_m, rng)
    checks = (np.sin(2 * np.pi * (depth_m + 0.1 * down_m) / 0.017) > 0.55) * 0.6
    checks = np.maximum(checks, (np.sin(2 * np.pi * (down_m - 0.1 * depth_m) / 0.02) > 0.6) * 0.5)
    rgb = COAT + (CHECK - COAT) * checks[..., None]
    lit = 1 + 0.22 * folds + 0.06 * weave - 3.0 * np.clip(0.02 - (depth_m - front_m), 0, 0.02)
    sleeve = np.abs(down_m - 0.035) + 0.35 * np.abs(depth_m - front_m - 0.01) < 0.010
    rgb[sleeve] = SKIN
    rgb = np.clip(rgb * lit[..., None], 0, 255)
    sheet = np.concatenate([rgb * cover[..., None], cover[..., None]], axis=-1)
    soft = as_pixels(cv2.GaussianBlur(as_pixels(sheet), (0, 0), max(SOFT_M * px_per_m, 0.5)))
    if inward < 0:
        return BodyPicture(np.ascontiguousarray(soft), 1, 0.0, height_px / 2)
    return BodyPicture(np.ascontiguousarray(soft[:, ::-1]), 1, float(width_px), height_px / 2)


def _front_m(down_m: Floats, rng: np.random.Generator) -> Floats:
    """Depth at which the coat begins, by height: waves, and a shoulder that slopes away."""
    front_m = 0.012 + 0.9 * np.clip(-down_m - 0.03, 0, None)
    for depth_m, length_m in ((0.006, 0.11), (0.003, 0.045), (0.0015, 0.021)):
        front_m += depth_m * np.sin(2 * np.pi * down_m / length_m + rng.uniform(0, 2 * np.pi))
    return np.asarray(front_m)


def _noise(shape: tuple[int, int], sigma_px: float, rng: np.random.Generator) -> Pixels:
    """Smooth random field of unit spread."""
    field = as_pixels(rng.standard_normal(shape))
    smooth = as_pixels(cv2.GaussianBlur(field, (0, 0), max(sigma_px, 0.3)))
    return as_pixels(smooth / (smooth.std() + 1e-6))

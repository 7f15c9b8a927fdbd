"""A large sheet in level coordinates on which the still part of the picture is painted."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from synth_video.body_picture import Pixels, as_pixels
from synth_video.projection import Projection

SCALE = 2
"""Sheet pixels to a picture pixel: edges are softened when the sheet is made smaller."""
_SUBPIXEL_BITS = 4


@dataclass(frozen=True)
class Raster:
    """Sheet of paint with its coordinates; metres along the line and up from the rest line."""

    projection: Projection
    margin_px: int
    """Picture pixels around the picture, so that a tilted camera still sees paint."""
    rng: np.random.Generator

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the sheet in sheet pixels."""
        p = self.projection
        return (
            (p.height_px + 2 * self.margin_px) * SCALE,
            (p.width_px + 2 * self.margin_px) * SCALE,
        )

    @property
    def px_per_m(self) -> float:
        """Sheet pixels to a metre."""
        return self.projection.px_per_m * SCALE

    def x(self, along_m: float) -> float:
        """Sheet x of a distance from the wall."""
        p = self.projection
        return (p.wall_x_px + p.px_per_m * along_m + self.margin_px + 0.5) * SCALE - 0.5

    def y(self, up_m: float) -> float:
        """Sheet y of a height over the rest line."""
        p = self.projection
        return (p.line_y_px - p.px_per_m * up_m + self.margin_px + 0.5) * SCALE - 0.5

    def along_m(self) -> Floats:
        """Distance from the wall of each sheet column, shape (w,)."""
        return np.asarray((np.arange(self.shape[1]) - self.x(0.0)) / self.px_per_m)

    def up_m(self) -> Floats:
        """Height over the rest line of each sheet row, shape (h, 1)."""
        return np.asarray((self.y(0.0) - np.arange(self.shape[0]))[:, None] / self.px_per_m)

    def blank(self, rgb: tuple[float, float, float]) -> Pixels:
        """Return a sheet of one colour."""
        return np.full((*self.shape, 3), rgb, dtype=np.float32)

    def polygon(self, corners_m: list[tuple[float, float]]) -> Pixels:
        """Coverage of a polygon given by (along, up) corners, shape (h, w)."""
        mask = np.zeros(self.shape, dtype=np.uint8)
        points = np.array([[self.x(a), self.y(u)] for a, u in corners_m])
        fixed = np.round(points * 2**_SUBPIXEL_BITS).astype(np.int32)
        cv2.fillPoly(mask, [fixed], 255, cv2.LINE_AA, _SUBPIXEL_BITS)
        return as_pixels(mask) / np.float32(255)

    def box(self, left_m: float, right_m: float, bottom_m: float, top_m: float) -> Pixels:
        """Coverage of an upright box, shape (h, w)."""
        return self.polygon(
            [(left_m, bottom_m), (right_m, bottom_m), (right_m, top_m), (left_m, top_m)]
        )

    def grain(self, along_mm: float, up_mm: float) -> Pixels:
        """Smooth random field of unit spread with the given lengths of correlation, (h, w)."""
        height, width = self.shape
        sigma_x = max(along_mm * 1e-3 * self.px_per_m, 0.3)
        sigma_y = max(up_mm * 1e-3 * self.px_per_m, 0.3)
        # A field that varies over many pixels is made small and stretched: the blur stays cheap.
        nx, ny = max(int(sigma_x / 2), 1), max(int(sigma_y / 2), 1)
        field = self.rng.standard_normal((height // ny + 2, width // nx + 2), dtype=np.float32)
        smooth = cv2.GaussianBlur(
            field, (0, 0), sigma_x / nx, sigmaY=sigma_y / ny, borderType=cv2.BORDER_REFLECT
        )
        wide = as_pixels(cv2.resize(smooth, (width, height), interpolation=cv2.INTER_CUBIC))
        return as_pixels((wide - wide.mean()) / (wide.std() + 1e-6))

    def lettering(self, text: str, height_m: float) -> NDArray[np.uint8]:
        """Coverage (0 to 255) of a line of text whose capitals are this high, cropped."""
        scale = max(height_m * self.px_per_m / 22.0, 0.2)
        thickness = max(1, round(scale * 1.6))
        face = cv2.FONT_HERSHEY_DUPLEX
        (width, rise), drop = cv2.getTextSize(text, face, scale, thickness)
        page = np.zeros((rise + drop + 2 * thickness, width + 2 * thickness), dtype=np.uint8)
        origin = (thickness, rise + thickness)
        cv2.putText(page, text, origin, face, scale, 255, thickness, cv2.LINE_AA)
        return page

    def picture(self, sheet: Pixels, blur_m: float) -> Pixels:
        """See a sheet through the tilted, slightly defocused camera: tilted coordinates."""
        p = self.projection
        blur_px = blur_m * self.px_per_m
        if blur_px > 0.2:
            sheet = as_pixels(cv2.GaussianBlur(sheet, (0, 0), blur_px))
        centre = ((p.width_px - 1) / 2 + self.margin_px, (p.height_px - 1) / 2 + self.margin_px)
        x, y = ((c + 0.5) * SCALE - 0.5 for c in centre)
        turn = cv2.getRotationMatrix2D((x, y), -p.tilt_deg, 1.0)
        turn[:, 2] -= self.margin_px * SCALE
        size = (p.width_px * SCALE, p.height_px * SCALE)
        turned = cv2.warpAffine(
            sheet, turn, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        small = cv2.resize(turned, (p.width_px, p.height_px), interpolation=cv2.INTER_AREA)
        return as_pixels(small)


def raster_for(projection: Projection, rng: np.random.Generator) -> Raster:
    """Prepare a sheet large enough for the camera's tilt."""
    longest = max(projection.width_px, projection.height_px)
    turn = abs(np.sin(np.radians(projection.tilt_deg)))
    return Raster(projection, int(np.ceil(turn * longest / 2)) + 4, rng)


def over(sheet: Pixels, cover: Pixels, rgb: tuple[float, float, float] | Pixels) -> None:
    """Paint a colour, or a whole coloured sheet, over a sheet where it covers; in place."""
    sheet += cover[..., None] * (np.asarray(rgb, dtype=np.float32) - sheet)

"""From the flat picture to the numbers in the file: through the lens, and on the sensor."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from synth_video.appearance import LightSettings
from synth_video.body_picture import Pixels, as_pixels
from synth_video.projection import Projection
from synth_video.scene import CameraSettings
from synth_video.schedule import Schedule

# ---- from the flat picture to the light on the sensor --------------------------------------------
# From the flat picture to the light on the sensor: through the lens, moved by the tripod.
#
# The flat picture is composed with a margin, so that what moves or bends into the picture is there.
# Shifts by parts of a pixel are taken with a windowed sinc, which moves a picture that the lens has
# blurred without softening it further.

TAPS = 4
"""The windowed sinc reaches so many px to each side."""


@dataclass(frozen=True)
class Optics:
    """What lies between the composed picture and the sensor; coordinates are tilted ones."""

    composed: Projection
    """Projection of the picture to compose: that of the clip with a margin around it."""
    margin_px: int
    shift_px: Floats
    """Shift of the picture in each frame, shape (n, 2)."""
    bend: tuple[Pixels, Pixels] | None
    """Column and row of the composed picture that each pixel of the bent one shows, shape
    (h + 2 * TAPS, w + 2 * TAPS) or more; None for an ideal lens."""

    def seen(self, light: Pixels, frame: int) -> Pixels:
        """Light on the sensor, shape (h, w, 3), of a composed picture."""
        if not self.margin_px:
            return light
        if self.bend is not None:
            light = as_pixels(cv2.remap(light, *self.bend, interpolation=cv2.INTER_CUBIC))
        return _shifted(light, self.shift_px[frame], self.composed, self.margin_px)


def optics_for(projection: Projection, shift_px: Floats) -> Optics:
    """Build the optics of a clip from its projection and the tripod's shifts, shape (n, 2)."""
    moved = int(np.ceil(np.abs(shift_px).max()))
    ideal = projection.lens.ideal
    if ideal and not moved:
        return Optics(projection, 0, shift_px, None)
    margin = moved + TAPS + 1
    if ideal:
        return Optics(_widened(projection, margin), margin, shift_px, None)
    x, y = _flat_points(projection, margin)
    # The bent picture keeps its size, so that the composed one needs what lies beyond it besides.
    beyond = max(-x.min(), -y.min(), x.max() - projection.width_px, y.max() - projection.height_px)
    margin = max(margin, int(np.ceil(beyond)) + 2)
    x, y = _flat_points(projection, margin)
    bend = (as_pixels(x + margin), as_pixels(y + margin))
    return Optics(_widened(projection, margin), margin, shift_px, bend)


def _flat_points(projection: Projection, margin: int) -> tuple[Floats, Floats]:
    """Points of the flat picture that the pixels of the bent one show, margin included."""
    x_centre, y_centre = (projection.width_px - 1) / 2, (projection.height_px - 1) / 2
    x = np.arange(-margin, projection.width_px + margin) - x_centre
    y = np.arange(-margin, projection.height_px + margin)[:, None] - y_centre
    flat_x, flat_y = projection.lens.flat(*np.broadcast_arrays(x, y))
    return flat_x + x_centre, flat_y + y_centre


def _widened(projection: Projection, margin: int) -> Projection:
    """Return a projection of the same things with so many px more on each side."""
    return replace(
        projection,
        width_px=projection.width_px + 2 * margin,
        height_px=projection.height_px + 2 * margin,
        wall_x_px=projection.wall_x_px + margin,
        line_y_px=projection.line_y_px + margin,
    )


def _shifted(light: Pixels, shift_px: Floats, composed: Projection, margin: int) -> Pixels:
    """Cut the picture out of the composed one, moved by the shift."""
    whole = np.rint(shift_px).astype(int)
    kernel_x, kernel_y = (_kernel(part) for part in shift_px - whole)
    left, top = margin - TAPS - int(whole[0]), margin - TAPS - int(whole[1])
    width = composed.width_px - 2 * margin + 2 * TAPS
    height = composed.height_px - 2 * margin + 2 * TAPS
    part = np.ascontiguousarray(light[top : top + height, left : left + width])
    if np.any(shift_px != whole):
        part = as_pixels(cv2.sepFilter2D(part, -1, kernel_x, kernel_y))
    return np.ascontiguousarray(part[TAPS:-TAPS, TAPS:-TAPS])


def _kernel(part_px: float) -> Floats:
    """Weights by which a row moves by a part of a pixel, shape (2 * TAPS + 1,), sum 1."""
    place = np.arange(-TAPS, TAPS + 1) + part_px
    weights = np.sinc(place) * np.sinc(place / (TAPS + 0.5))
    return np.asarray(weights / weights.sum())


# ---- from the light to the numbers in the file ---------------------------------------------------
# From the light that reaches the sensor to the numbers in the file.


@dataclass
class Sensor:
    """Vignette, flicker, drift and noise; the noise goes on from frame to frame."""

    shading: Pixels
    """Brightness factor of each pixel and channel, shape (h, w, 3)."""
    gain: Floats
    """Brightness factor of each frame, shape (n,)."""
    read_noise: float
    shot_noise: float
    rng: np.random.Generator

    def expose(self, light: Pixels, frame: int) -> NDArray[np.uint8]:
        """Turn a picture's light, shape (h, w, 3), into its RGB values, noise added.

        The noise is that of the brightness: the same in all three channels, with variance
        ``read_noise ** 2 + shot_noise * brightness`` in grey levels.
        """
        seen = as_pixels(cv2.multiply(light, self.shading, scale=float(self.gain[frame])))
        grain = np.zeros_like(seen)
        if self.read_noise or self.shot_noise:
            variance = as_pixels(cv2.cvtColor(seen, cv2.COLOR_RGB2GRAY))
            variance *= np.float32(self.shot_noise)
            variance += np.float32(self.read_noise**2)
            noise = self.rng.standard_normal(variance.shape, dtype=np.float32)
            noise *= np.sqrt(variance)
            grain = as_pixels(cv2.merge([noise, noise, noise]))
        # Added in float, then rounded to the nearest and held to 0 to 255, all in one pass.
        return np.asarray(cv2.add(seen, grain, dtype=cv2.CV_8U), dtype=np.uint8)


def sensor_for(
    camera: CameraSettings, light: LightSettings, schedule: Schedule, rng: np.random.Generator
) -> Sensor:
    """Build the sensor for a clip."""
    shading = vignette(camera.width_px, camera.height_px, camera.vignette) * light.brightness
    return Sensor(
        np.ascontiguousarray(np.repeat(shading[..., None], 3, axis=2), dtype=np.float32),
        flicker_gain(light, schedule) * drift_gain(light, len(schedule.centre_s)),
        camera.read_noise,
        camera.shot_noise,
        rng,
    )


def vignette(width_px: int, height_px: int, loss: float) -> Floats:
    """Brightness factor of each pixel: 1 in the middle, ``1 - loss`` in the corners."""
    x = np.linspace(-1, 1, width_px) * width_px
    y = np.linspace(-1, 1, height_px)[:, None] * height_px
    return np.asarray(1 - loss * (x * x + y * y) / (width_px**2 + height_px**2))


def flicker_gain(light: LightSettings, schedule: Schedule) -> Floats:
    """Mean brightness of the lamps during each exposure, relative to their mean; shape (n,).

    A sine averaged over the exposure is the sine at its centre times sinc(f * exposure).
    """
    since = schedule.centre_s - schedule.centre_s[0]
    phase = 2 * np.pi * light.flicker_hz * since + np.radians(light.flicker_phase_deg)
    swing = light.flicker_amplitude * np.sinc(light.flicker_hz * schedule.exposure_s)
    return np.asarray(1 + swing * np.sin(phase))


def drift_gain(light: LightSettings, frames: int) -> Floats:
    """Brightness of each frame relative to the first, shape (n,): an even change to the last."""
    return np.linspace(1.0, 1.0 + light.drift, frames)

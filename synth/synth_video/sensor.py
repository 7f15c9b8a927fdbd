"""From the light that reaches the sensor to the numbers in the file."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from synth_video.appearance import LightSettings
from synth_video.pixels import Pixels, as_pixels
from synth_video.scene import CameraSettings
from synth_video.schedule import Schedule


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

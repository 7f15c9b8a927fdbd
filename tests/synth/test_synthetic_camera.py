from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synth_video.appearance import LightSettings
from synth_video.optics import flicker_gain, sensor_for, vignette
from synth_video.scene import CameraSettings
from synth_video.schedule import Schedule

SCHEDULE = Schedule(np.arange(240) / 1000.0, 0.5 / 1000.0)
GREY = 100.0


def test_noise_has_the_variance_of_reading_and_of_photons() -> None:
    settings = CameraSettings(320, 240, read_noise=3.0, shot_noise=0.2, vignette=0.0)
    sensor = sensor_for(settings, LightSettings(), SCHEDULE, np.random.default_rng(1))
    picture = sensor.expose(np.full((240, 320, 3), GREY, dtype=np.float32), 0)[..., 0]
    variance = 3.0**2 + 0.2 * GREY + 1 / 12  # rounding to whole grey levels adds 1/12
    # The variance of n normal numbers has a relative standard error of sqrt(2 / n).
    assert picture.var() == pytest.approx(variance, rel=4 * np.sqrt(2 / picture.size))
    assert picture.mean() == pytest.approx(GREY, abs=4 * np.sqrt(variance / picture.size))


def test_noise_differs_from_frame_to_frame_and_from_seed_to_seed() -> None:
    settings, light = CameraSettings(64, 64), np.full((64, 64, 3), GREY, dtype=np.float32)
    first, other = (
        sensor_for(settings, LightSettings(), SCHEDULE, np.random.default_rng(seed))
        for seed in (1, 2)
    )
    pictures = [first.expose(light, 0), first.expose(light, 1), other.expose(light, 0)]
    assert not np.array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[0], pictures[2])


def test_a_camera_without_noise_shows_the_light_itself() -> None:
    settings = CameraSettings(64, 64, read_noise=0, shot_noise=0, vignette=0)
    sensor = sensor_for(settings, LightSettings(), SCHEDULE, np.random.default_rng(1))
    light = np.linspace(-20, 280, 64 * 64 * 3, dtype=np.float32).reshape(64, 64, 3)
    assert np.abs(sensor.expose(light, 0) - np.clip(light, 0, 255)).max() <= 0.5


def test_the_corners_are_darker_by_the_stated_part_and_the_middle_is_not() -> None:
    shading = vignette(101, 51, 0.3)
    assert shading[25, 50] == pytest.approx(1.0)
    assert shading[[0, 0, -1, -1], [0, -1, 0, -1]] == pytest.approx(np.full(4, 0.7))


def test_lamps_flicker_with_their_frequency_in_real_time() -> None:
    light = LightSettings(flicker_amplitude=0.1, flicker_hz=100.0, flicker_phase_deg=90.0)
    gain = flicker_gain(light, Schedule(SCHEDULE.centre_s, 1e-9))
    assert gain[0] == pytest.approx(1.1)
    assert gain[5] == pytest.approx(0.9)  # half a cycle later: 5 ms
    assert gain[10:] == pytest.approx(gain[:-10])


def test_a_shutter_open_for_a_whole_cycle_sees_no_flicker() -> None:
    light = LightSettings(flicker_amplitude=0.2, flicker_hz=100.0)
    assert flicker_gain(light, Schedule(SCHEDULE.centre_s, 0.010)) == pytest.approx(np.ones(240))


def test_the_mean_over_an_exposure_is_the_mean_of_the_lamps() -> None:
    light = LightSettings(flicker_amplitude=0.2, flicker_hz=120.0, flicker_phase_deg=30.0)
    exposure_s = 0.004
    gain = flicker_gain(light, Schedule(SCHEDULE.centre_s, exposure_s))
    part = ((np.arange(500) + 0.5) / 500 - 0.5) * exposure_s
    times = SCHEDULE.centre_s[:, None] + part
    lamps = 1 + 0.2 * np.sin(2 * np.pi * 120.0 * times + np.radians(30.0))
    assert gain == pytest.approx(lamps.mean(axis=1), abs=1e-6)


def test_brightness_scales_the_picture() -> None:
    settings = CameraSettings(64, 64, read_noise=0, shot_noise=0, vignette=0)
    sensor = sensor_for(
        settings, replace(LightSettings(), brightness=0.5), SCHEDULE, np.random.default_rng(1)
    )
    light = np.full((64, 64, 3), GREY, dtype=np.float32)
    assert np.all(sensor.expose(light, 0) == GREY / 2)

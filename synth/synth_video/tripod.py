"""How the picture moves when the camera does not stand still."""

from __future__ import annotations

import numpy as np

from count_video.records import Floats
from synth_video.scene import TripodSettings
from synth_video.schedule import Schedule

_CHANCE = 4
"""Stream of chance of its own: a tripod that shakes does not change what is filmed."""
_WAVES = 3
_DECAY_S = 0.06
"""The swing after a knock falls to a third in this time."""
_KNOCK_HZ = (10.0, 18.0)


def tripod_shift(tripod: TripodSettings, schedule: Schedule, seed: int) -> Floats:
    """Shift of the picture in each frame, (x, y) in px of the tilted picture, shape (n, 2).

    It is the shift at the centre of the exposure: a tripod is slow next to a shutter.
    """
    shift = np.zeros((len(schedule.centre_s), 2))
    rng = np.random.default_rng([seed, _CHANCE])
    since_s = schedule.centre_s - schedule.centre_s[0]
    if tripod.shake_px:
        for axis in range(2):
            shift[:, axis] = tripod.shake_px * _shake(tripod, since_s, rng)
    if tripod.knock_px:
        shift += tripod.knock_px * _knock(since_s, rng)
    return shift


def _shake(tripod: TripodSettings, since_s: Floats, rng: np.random.Generator) -> Floats:
    """Sum of waves, never beyond -1 to 1."""
    share = rng.dirichlet(np.ones(_WAVES))
    rate_hz = rng.uniform(tripod.shake_low_hz, tripod.shake_high_hz, _WAVES)
    phase = rng.uniform(0, 2 * np.pi, _WAVES)
    return np.asarray(np.sin(2 * np.pi * rate_hz * since_s[:, None] + phase) @ share)


def _knock(since_s: Floats, rng: np.random.Generator) -> Floats:
    """Damped swing that starts in the middle third of the clip, first peak 1, shape (n, 2)."""
    after_s = np.clip(since_s - rng.uniform(1 / 3, 2 / 3) * since_s[-1], 0, None)
    angular = 2 * np.pi * rng.uniform(*_KNOCK_HZ)
    # exp(-t / d) sin(w t) has its first peak where tan(w t) = w d.
    peak_s = np.arctan(angular * _DECAY_S) / angular
    peak = np.exp(-peak_s / _DECAY_S) * np.sin(angular * peak_s)
    swing = np.exp(-after_s / _DECAY_S) * np.sin(angular * after_s) / peak
    direction = rng.uniform(-np.pi / 4, np.pi / 4) + np.pi * rng.integers(2)
    return np.asarray(swing[:, None] * np.array([np.cos(direction), np.sin(direction)]))

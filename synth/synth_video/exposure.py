"""Where the bodies are while the shutter is open."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion
from count_video.records import Floats
from synth_video.schedule import Schedule

FEWEST_SAMPLES = 8
MOST_SAMPLES = 64
SAMPLES_PER_PX = 8
"""Samples for a px of travel. A bounce within an exposure costs the mean position most: with n
samples at most 2 * travel / (8 * n**2), so these figures keep it below 0.004 px up to 64 px."""
_CHUNK = 256


@dataclass(frozen=True)
class BodyPath:
    """Path of a body's reference point during one exposure, arrays of shape (m,)."""

    along_m: Floats
    """Distance from the wall: of a ball's centre, of the middle of a cylinder's face."""
    up_m: Floats
    """Height over the rest line."""


@dataclass(frozen=True)
class Paths:
    """Paths of all bodies during one exposure."""

    bodies: tuple[BodyPath, ...]
    """In a trial the ball, then the cylinder."""
    times_s: Floats
    """Real time of each point of the paths, shape (m,)."""


def exposures(
    motion: Motion, schedule: Schedule, px_per_m: float, *, rising: bool
) -> Iterator[Paths]:
    """Paths during each exposure, frame by frame, sampled at the middle of equal parts of it."""
    count = _samples(motion, schedule, px_per_m)
    times_s = open_times(schedule, count)
    for start in range(0, len(times_s), _CHUNK):
        yield from _paths(motion, times_s[start : start + _CHUNK], rising=rising)


def open_times(schedule: Schedule, count: int) -> Floats:
    """Middles of ``count`` equal parts of each exposure, shape (frames, count)."""
    part = ((np.arange(count) + 0.5) / count - 0.5) * schedule.exposure_s
    return schedule.centre_s[:, None] + part


def rise_m(setup: Setup, displacement_m: Floats, thread_m: float) -> Floats:
    """Height gained on the arc of a thread; 0 for bodies that do not hang."""
    if setup.mounting != "suspended":
        return np.zeros_like(displacement_m)
    return thread_m - np.sqrt(np.clip(thread_m**2 - displacement_m**2, 0, None))


def _samples(motion: Motion, schedule: Schedule, px_per_m: float) -> int:
    """Count the samples that the fastest body needs; the same for all frames."""
    speeds = [0.0]
    for hit in motion.collisions:
        speeds += [abs(hit.heavy_before_m_s), abs(hit.light_after_m_s)]
    return samples_for(max(speeds) * schedule.exposure_s * px_per_m)


def samples_for(travel_px: float) -> int:
    """Count the samples of an exposure for a body that travels so far during it."""
    return int(np.clip(np.ceil(travel_px * SAMPLES_PER_PX), FEWEST_SAMPLES, MOST_SAMPLES))


def _paths(motion: Motion, times_s: Floats, *, rising: bool) -> Iterator[Paths]:
    """One ``Paths`` for each row of times, shape (frames, m)."""
    setup = motion.setup
    sample = motion.sample(times_s.ravel())
    ball_m = (sample.ball_far_face_m + setup.ball_diameter_m / 2).reshape(times_s.shape)
    heavy_m = sample.heavy_face_m.reshape(times_s.shape)
    ball_up, heavy_up = np.zeros_like(ball_m), np.zeros_like(heavy_m)
    if rising:
        ball_rest = setup.wall_gap_m + setup.ball_diameter_m / 2
        ball_up = rise_m(setup, ball_m - ball_rest, setup.light_thread_m)
        heavy_up = rise_m(setup, heavy_m - setup.heavy_rest_m, setup.heavy_thread_m)
    for k, times in enumerate(times_s):
        ball, heavy = BodyPath(ball_m[k], ball_up[k]), BodyPath(heavy_m[k], heavy_up[k])
        yield Paths((ball, heavy), times)

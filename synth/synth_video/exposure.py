"""Where the bodies are while the shutter is open."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from count_video.records import Floats
from synth_video.experiments.course import Course
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


def exposures(course: Course, schedule: Schedule, px_per_m: float) -> Iterator[Paths]:
    """Paths during each exposure, frame by frame, sampled at the middle of equal parts of it."""
    times_s = open_times(schedule, _samples(course, schedule, px_per_m))
    for start in range(0, len(times_s), _CHUNK):
        part_s = times_s[start : start + _CHUNK]
        places = [place(part_s) for place in course.places]
        for k, times in enumerate(part_s):
            yield Paths(tuple(BodyPath(along[k], up[k]) for along, up in places), times)


def open_times(schedule: Schedule, count: int) -> Floats:
    """Middles of ``count`` equal parts of each exposure, shape (frames, count)."""
    part = ((np.arange(count) + 0.5) / count - 0.5) * schedule.exposure_s
    return schedule.centre_s[:, None] + part


def _samples(course: Course, schedule: Schedule, px_per_m: float) -> int:
    """Count the samples of an exposure that the fastest body needs; the same for all frames."""
    if course.fastest_m_s is not None:
        travel_m = course.fastest_m_s * schedule.exposure_s
    else:
        places = (place(open_times(schedule, 2)) for place in course.places)
        ways_m = (np.hypot(np.diff(along_m), np.diff(up_m)) for along_m, up_m in places)
        travel_m = 2 * max(way_m.max() for way_m in ways_m)  # the two are half an exposure apart
    wanted = np.ceil(travel_m * px_per_m * SAMPLES_PER_PX)
    return int(np.clip(wanted, FEWEST_SAMPLES, MOST_SAMPLES))

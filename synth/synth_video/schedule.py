"""Which real time each frame shows, and where the bodies are while its shutter is open."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.physics.simulator import Motion, SimulatedCollision
from count_video.records import Floats
from synth_video.experiments.course import Course
from synth_video.scene import ClipSettings, EncodingSettings, Scene

RAMP_APART_FRAMES = 2.7
"""A ramp leaves collisions at least this many frames apart: the frames still show each."""


@dataclass(frozen=True)
class Schedule:
    """Real times of the exposures of all frames."""

    centre_s: Floats
    """Centre of each frame's exposure in seconds since the release, shape (n,); increasing, but
    for frames that are copies: they have the time of the one before."""
    exposure_s: float
    """Time during which the shutter is open."""
    lost_s: Floats | None = None
    """Exposures before copies took the place of lost pictures, shape (n,); None without losses.
    Frames count by these."""

    @property
    def copies(self) -> NDArray[np.bool_]:
        """True for each frame that is a copy of the one before, shape (n,)."""
        return np.concatenate([[False], np.diff(self.centre_s) == 0])

    def frame_coordinate(self, time_s: float) -> float:
        """Frame coordinate of a real time; also outside the clip, by the rate at its ends."""
        times_s = self.centre_s if self.lost_s is None else self.lost_s
        first, last = times_s[0], times_s[-1]
        step = (last - first) / max(len(times_s) - 1, 1) or self.exposure_s
        if time_s < first:
            return float((time_s - first) / step)
        if time_s > last:
            return float(len(times_s) - 1 + (time_s - last) / step)
        return float(np.interp(time_s, times_s, np.arange(len(times_s))))

    def footage_s(self, capture_fps: float, container_fps: float) -> Floats:
        """Footage time of each frame where it follows the exposures, shape (n,)."""
        return np.asarray((self.centre_s - self.centre_s[0]) * capture_fps / container_fps)


def schedule_of(scene: Scene, motion: Motion, rng: np.random.Generator) -> Schedule:
    """Choose the frames' times: from shortly before the first collision to shortly after the last.

    The camera does not know of the collision, so the phase of its clock is drawn from ``rng``.

    Raises
    ------
    UsageError
        No collision to place the clip by, or more frames than ``clip.max_frames``.
    """
    clip, rate = scene.clip, scene.camera.capture_fps
    start_s = first_event_s(clip, motion) - (clip.lead_frames - rng.random()) / rate
    count = clip.frames or int(np.ceil((last_event_s(clip, motion) - start_s) * rate)) + 1
    count += 0 if clip.frames else clip.tail_frames
    if count > clip.max_frames:
        raise UsageError(
            f"the clip would have {count} frames; lower camera.capture_fps, set clip.frames, "
            f"or raise clip.max_frames (now {clip.max_frames})"
        )
    taken: Floats = np.arange(count, dtype=float)
    if clip.ramp > 1:
        taken = _ramped(count, (_times_s(motion.burst) - start_s) * rate, clip.ramp)
    return timed(scene, start_s, taken, rng)


def timed(scene: Scene, start_s: float, taken: Floats, rng: np.random.Generator) -> Schedule:
    """Time the pictures taken at these places of the camera's clock, shape (n,), in frames.

    Jitter, copies and lost pictures are those that the scene asks for.
    """
    rate = scene.camera.capture_fps
    if scene.camera.jitter:
        taken = taken + rng.uniform(-1, 1, len(taken)) * scene.camera.jitter
    centre_s = start_s + taken[_order(len(taken), scene.encoding)] / rate
    lost_s = start_s + taken / rate if scene.encoding.repeat_lost else None
    return Schedule(centre_s, scene.camera.shutter / rate, lost_s)


def first_event_s(clip: ClipSettings, motion: Motion) -> float:
    """Time of the event that ``clip.lead_frames`` precede.

    Raises
    ------
    UsageError
        There is no such event.
    """
    if clip.start == "release":
        return 0.0
    if not motion.collisions:
        raise UsageError("the bodies never collide; use clip.start=release and clip.frames")
    bounces = motion.burst or motion.collisions
    place = {"collision": 0, "second": 1, "middle": len(bounces) // 2}[clip.start]
    return bounces[min(place, len(bounces) - 1)].time_s


def last_event_s(clip: ClipSettings, motion: Motion) -> float:
    """Time of the event after which ``clip.tail_frames`` are counted.

    Raises
    ------
    UsageError
        There is no such event.
    """
    bounces = motion.burst
    if not bounces:
        raise UsageError("the bodies never collide; set clip.frames")
    if clip.end == "turn":
        if not np.isfinite(motion.burst_end_s):
            raise UsageError("the cylinder never turns back; use clip.end=burst")
        return motion.burst_end_s
    if clip.end == "all":
        return motion.collisions[-1].time_s
    place = {"middle": len(bounces) // 2, "penultimate": max(len(bounces) - 2, 0), "burst": -1}
    return bounces[place[clip.end]].time_s


def _ramped(count: int, hits: Floats, factor: float) -> Floats:
    """Pictures that a ramped export takes of ``count``, as places among them, shape (m,).

    ``hits`` are the collisions' places. All pictures are kept where they are dense, and half the
    way to the neighbours on both sides; elsewhere one of ``factor``.
    """
    dense = [(a, b) for a, b in pairwise(hits) if b - a < RAMP_APART_FRAMES * factor]
    if not dense:
        return np.arange(0.0, count, factor)
    first, last = dense[0][0], dense[-1][1]
    before = hits[hits < first][-1:].tolist() or [first - 4 * factor]
    after = hits[hits > last][:1].tolist() or [last + 4 * factor]
    slow, fast = (before[0] + first) / 2, (last + after[0]) / 2
    steps = np.array([-count, slow, fast, 2.0 * count])
    pace = np.cumsum(np.concatenate([[0.0], np.diff(steps) / [factor, 1.0, factor]]))
    ticks = np.arange(np.ceil(np.interp(0.0, steps, pace)), np.interp(count - 1, steps, pace))
    return np.asarray(np.interp(ticks, pace, steps))


def _order(count: int, encoding: EncodingSettings) -> NDArray[np.intp]:
    """Picture that each frame of the file shows, shape (n,); copies show the one before."""
    pictures = np.arange(count)
    if not encoding.repeat_every:
        return pictures
    last = pictures % encoding.repeat_every == encoding.repeat_every - 1
    if encoding.repeat_lost:
        return np.asarray(pictures - last)
    return np.repeat(pictures, 1 + last)


def _times_s(bounces: tuple[SimulatedCollision, ...]) -> Floats:
    return np.array([bounce.time_s for bounce in bounces])


# ---- places during an exposure -------------------------------------------------------------------
# Where the bodies are while the shutter is open.

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

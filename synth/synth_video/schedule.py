"""Which real time each frame shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.errors import UsageError
from count_video.physics.simulator import Motion
from count_video.records import Floats
from synth_video.scene import ClipSettings, Scene


@dataclass(frozen=True)
class Schedule:
    """Real times of the exposures of all frames."""

    centre_s: Floats
    """Centre of each frame's exposure in seconds since the release, shape (n,), increasing."""
    exposure_s: float
    """Time during which the shutter is open."""

    def frame_coordinate(self, time_s: float) -> float:
        """Frame coordinate of a real time; also outside the clip, by the rate at its ends."""
        first, last = self.centre_s[0], self.centre_s[-1]
        step = (last - first) / max(len(self.centre_s) - 1, 1) or self.exposure_s
        if time_s < first:
            return float((time_s - first) / step)
        if time_s > last:
            return float(len(self.centre_s) - 1 + (time_s - last) / step)
        return float(np.interp(time_s, self.centre_s, np.arange(len(self.centre_s))))


def schedule_of(scene: Scene, motion: Motion, rng: np.random.Generator) -> Schedule:
    """Choose the frames' times: from shortly before the first collision to shortly after the last.

    The camera does not know of the collision, so the phase of its clock is drawn from ``rng``.

    Raises
    ------
    UsageError
        No collision to place the clip by, or more frames than ``clip.max_frames``.
    """
    clip, rate = scene.clip, scene.camera.capture_fps
    origin_s = 0.0
    if clip.start == "collision":
        if not motion.collisions:
            raise UsageError("the bodies never collide; use clip.start=release and clip.frames")
        origin_s = motion.collisions[0].time_s
    start_s = origin_s - (clip.lead_frames - rng.random()) / rate
    count = clip.frames or int(np.ceil((_last_event_s(clip, motion) - start_s) * rate)) + 1
    count += 0 if clip.frames else clip.tail_frames
    if count > clip.max_frames:
        raise UsageError(
            f"the clip would have {count} frames; lower camera.capture_fps, set clip.frames, "
            f"or raise clip.max_frames (now {clip.max_frames})"
        )
    return Schedule(start_s + np.arange(count) / rate, scene.camera.shutter / rate)


def _last_event_s(clip: ClipSettings, motion: Motion) -> float:
    """Time of the event after which ``clip.tail_frames`` are counted."""
    if not motion.burst:
        raise UsageError("the bodies never collide; set clip.frames")
    if clip.end == "turn":
        if not np.isfinite(motion.burst_end_s):
            raise UsageError("the cylinder never turns back; use clip.end=burst")
        return motion.burst_end_s
    return (motion.burst if clip.end == "burst" else motion.collisions)[-1].time_s

"""Which part of an experiment a clip shows."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from count_video.errors import UsageError
from synth_video.experiments.course import Course
from synth_video.scene import Scene
from synth_video.schedule import Schedule, timed


def schedule_of_course(scene: Scene, course: Course, rng: np.random.Generator) -> Schedule:
    """Choose the frames' times; the phase of the camera's clock is drawn from ``rng``.

    Raises
    ------
    UsageError
        If the experiment has fewer impacts than are to be shown, or there would be more frames
        than ``clip.max_frames``.
    """
    rate = scene.camera.capture_fps
    start_s = -scene.experiment.held_s + rng.random() / rate
    end_s = _end_s(scene, course)
    count = scene.clip.frames or int((end_s - start_s) * rate) + 1
    if count > scene.clip.max_frames or count < 1:
        raise UsageError(
            f"the clip would have {count} frames, from 1 to {scene.clip.max_frames} are allowed; "
            "change camera.capture_fps, experiment.impacts or experiment.duration_s"
        )
    return timed(scene, start_s, np.arange(count, dtype=float), rng)


def _end_s(scene: Scene, course: Course) -> float:
    """When the clip ends: half-way between two impacts, or after the time it may last."""
    experiment = scene.experiment
    if not experiment.impacts:
        return experiment.duration_s
    times_s = [contact.time_s for contact in course.contacts]
    if len(times_s) < experiment.impacts:
        raise UsageError(
            f"only {len(times_s)} impacts in experiment.duration_s, experiment.impacts asks for "
            f"{experiment.impacts}; raise the duration or lower the number"
        )
    middles_s = [(a + b) / 2 for a, b in pairwise(times_s)]
    shown_s = [*middles_s, experiment.duration_s][experiment.impacts - 1]
    return min(shown_s, experiment.duration_s)

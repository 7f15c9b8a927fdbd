"""One experiment from scene to clip and truth."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from synth_video.experiments.course import Course
from synth_video.experiments.happening import course_of
from synth_video.experiments.staging import set_experiment
from synth_video.experiments.timing import schedule_of_course
from synth_video.experiments.truth import ExperimentTruth, experiment_json, truth_of_course
from synth_video.exposure import BodyPath, Paths, open_times, samples_for
from synth_video.film import CLOCK, pictures, write_film
from synth_video.projection import Projection, projection_of
from synth_video.scene import Scene
from synth_video.schedule import Schedule
from synth_video.truth import write_text


def render_experiment(scene: Scene, seed: int, clip_path: Path) -> ExperimentTruth:
    """Work out and film an experiment; write the clip and, beside it, its truth.

    Raises
    ------
    UsageError
        If the numbers allow no run, the clip is too long, or it cannot be written as asked.
    """
    course = course_of(scene)
    schedule = schedule_of_course(scene, course, np.random.default_rng([seed, CLOCK]))
    projection = projection_of(scene)
    truth = truth_of_course(scene, seed, course, schedule, projection)
    frames = experiment_frames(scene, seed, course, schedule, projection)
    write_film(clip_path, frames, scene, schedule, partial(write_text, experiment_json(truth)))
    return truth


def experiment_frames(
    scene: Scene, seed: int, course: Course, schedule: Schedule, projection: Projection
) -> Iterator[NDArray[np.uint8]]:
    """Yield the RGB pictures of an experiment, shape (h, w, 3), one by one."""
    paths = course_paths(course, schedule, projection.px_per_m)
    yield from pictures(scene, seed, schedule, paths, partial(set_experiment, scene, course))


def course_paths(course: Course, schedule: Schedule, px_per_m: float) -> Iterator[Paths]:
    """Paths of all bodies during each exposure, frame by frame."""
    ends_s = open_times(schedule, 2)
    travel_px = 0.0
    for place in course.places:
        along_m, up_m = place(ends_s)
        way_m = np.hypot(np.diff(along_m), np.diff(up_m)).max()
        travel_px = max(travel_px, 2 * way_m * px_per_m)  # the two are half an exposure apart
    times_s = open_times(schedule, samples_for(travel_px))
    places = [place(times_s) for place in course.places]
    for k, times in enumerate(times_s):
        yield Paths(tuple(BodyPath(along[k], up[k]) for along, up in places), times)

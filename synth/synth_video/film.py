"""From a scene to its pictures, and to a clip with its truth beside it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.footage.writer import WriteOptions, write_clip
from count_video.physics.simulator import simulate
from synth_video.compositor import Compositor
from synth_video.experiments.course import Course, course_of_trial
from synth_video.experiments.course_truth import ExperimentTruth, experiment_json, truth_of_course
from synth_video.experiments.happening import course_of
from synth_video.experiments.staging import set_experiment
from synth_video.experiments.timing import schedule_of_course
from synth_video.exposure import exposures
from synth_video.optics import optics_for
from synth_video.pixels import as_pixels
from synth_video.projection import projection_of
from synth_video.scene import EncodingSettings, Scene
from synth_video.schedule import Schedule, schedule_of
from synth_video.sensor import sensor_for
from synth_video.stage import set_stage
from synth_video.tripod import tripod_shift
from synth_video.truth import Truth, truth_json, truth_of, truth_path, write_text

CLOCK, ART, NOISE = 1, 2, 3
"""Each use of chance has its own stream: more noise does not change what stands on the shelf."""


def render_clip(scene: Scene, seed: int, clip_path: Path) -> Truth | ExperimentTruth:
    """Work out and film what a scene shows; write the clip and, beside it, its truth.

    Raises
    ------
    UsageError
        If the scene shows no collision, its numbers allow no run, the clip is too long, or it
        cannot be written as asked.
    """
    clock, projection = np.random.default_rng([seed, CLOCK]), projection_of(scene)
    truth: Truth | ExperimentTruth
    if scene.experiment.kind == "pi":
        motion = simulate(scene.setup, seed=seed)
        course = course_of_trial(motion, rising=scene.view.rising_path)
        schedule = schedule_of(scene, motion, clock)
        truth = truth_of(scene, seed, motion, schedule, projection)
        text = truth_json(truth)
    else:
        course = course_of(scene)
        schedule = schedule_of_course(scene, course, clock)
        truth = truth_of_course(scene, seed, course, schedule, projection)
        text = experiment_json(truth)
    _write_film(clip_path, frames_of(scene, seed, course, schedule), scene, schedule, text)
    return truth


def frames_of(
    scene: Scene, seed: int, course: Course, schedule: Schedule
) -> Iterator[NDArray[np.uint8]]:
    """Yield the RGB pictures of what moves on a course, shape (h, w, 3), one by one."""
    projection = projection_of(scene)
    optics = optics_for(projection, tripod_shift(scene.tripod, schedule, seed))
    art = np.random.default_rng([seed, ART])
    if scene.experiment.kind == "pi":
        stage = set_stage(scene, optics.composed, art)
    else:
        stage = set_experiment(scene, course, optics.composed, art)
    compositor = Compositor(stage)
    sensor = sensor_for(scene.camera, scene.light, schedule, np.random.default_rng([seed, NOISE]))
    copies, picture = schedule.copies, None
    for k, path in enumerate(exposures(course, schedule, projection.px_per_m)):
        if picture is not None and copies[k]:
            yield picture
            continue
        light = optics.seen(compositor.compose(path), k)
        seen = as_pixels(cv2.flip(light, 1)) if projection.mirrored else light
        picture = sensor.expose(seen, k)
        yield picture


def _write_film(
    clip_path: Path,
    frames: Iterator[NDArray[np.uint8]],
    scene: Scene,
    schedule: Schedule,
    truth: str,
) -> None:
    """Encode the pictures as the scene asks, and write their truth as JSON text beside them.

    Raises
    ------
    UsageError
        If the file cannot be written so, or its truth cannot.
    """
    write_clip(clip_path, _stored(frames, scene.encoding), _write_options(scene, schedule))
    try:
        write_text(truth, truth_path(clip_path))
    except UsageError:
        clip_path.unlink()  # a clip without its truth, or with an older one, would mislead
        raise


def _stored(
    frames: Iterator[NDArray[np.uint8]], encoding: EncodingSettings
) -> Iterator[NDArray[np.uint8]]:
    """Turn the pictures as a file stores them that asks to be turned for display."""
    for frame in frames:
        # Positive quarters turn counter-clockwise; display will turn back what is turned here.
        yield np.ascontiguousarray(np.rot90(frame, -encoding.rotation_deg // 90))


def _write_options(scene: Scene, schedule: Schedule) -> WriteOptions:
    encoding, times = scene.encoding, None
    if encoding.variable_rate:
        times = schedule.footage_s(scene.camera.capture_fps, encoding.container_fps).tolist()
    return WriteOptions(
        container_fps=encoding.container_fps,
        codec=encoding.codec,
        crf=encoding.crf,
        preset=encoding.preset,
        pixel_format=encoding.pixel_format,
        rotation_deg=encoding.rotation_deg,
        frame_times_s=times,
    )

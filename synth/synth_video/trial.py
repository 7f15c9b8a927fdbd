"""One synthetic trial from scene to clip and truth."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.footage.writer import WriteOptions, write_clip
from count_video.physics.simulator import Motion, simulate
from synth_video.camera import sensor_for
from synth_video.compositor import Compositor
from synth_video.exposure import exposures
from synth_video.optics import optics_for
from synth_video.pixels import as_pixels
from synth_video.projection import Projection, projection_of
from synth_video.scene import EncodingSettings, Scene
from synth_video.schedule import Schedule, schedule_of
from synth_video.stage import set_stage
from synth_video.tripod import tripod_shift
from synth_video.truth import Truth, truth_of, truth_path, write_truth

_CLOCK, _ART, _NOISE = 1, 2, 3
"""Each use of chance has its own stream: more noise does not change what stands on the shelf."""


def render_trial(scene: Scene, seed: int, clip_path: Path) -> Truth:
    """Simulate and film a trial; write the clip and, beside it, its truth.

    Raises
    ------
    UsageError
        If the scene shows no collision, is too long, or cannot be written as asked.
    """
    motion = simulate(scene.setup, seed=seed)
    schedule = schedule_of(scene, motion, np.random.default_rng([seed, _CLOCK]))
    projection = projection_of(scene)
    truth = truth_of(scene, seed, motion, schedule, projection)
    pictures = render_frames(scene, seed, motion, schedule, projection)
    write_clip(clip_path, _stored(pictures, scene.encoding), _write_options(scene, schedule))
    try:
        write_truth(truth, truth_path(clip_path))
    except UsageError:
        clip_path.unlink()  # a clip without its truth, or with an older one, would mislead
        raise
    return truth


def render_frames(
    scene: Scene, seed: int, motion: Motion, schedule: Schedule, projection: Projection
) -> Iterator[NDArray[np.uint8]]:
    """Yield the RGB pictures of a trial, shape (h, w, 3), one by one."""
    optics = optics_for(projection, tripod_shift(scene.tripod, schedule, seed))
    stage = set_stage(scene, optics.composed, np.random.default_rng([seed, _ART]))
    compositor = Compositor(stage)
    noise = np.random.default_rng([seed, _NOISE])
    sensor = sensor_for(scene.camera, scene.light, schedule, noise)
    rising = scene.view.rising_path
    paths = exposures(motion, schedule, projection.px_per_m, rising=rising)
    copies, picture = schedule.copies, None
    for k, path in enumerate(paths):
        if picture is not None and copies[k]:
            yield picture
            continue
        light = optics.seen(compositor.compose(path), k)
        seen = as_pixels(cv2.flip(light, 1)) if projection.mirrored else light
        picture = sensor.expose(seen, k)
        yield picture


def _stored(
    pictures: Iterator[NDArray[np.uint8]], encoding: EncodingSettings
) -> Iterator[NDArray[np.uint8]]:
    """Turn the pictures as a file stores them that asks to be turned for display."""
    for picture in pictures:
        # Positive quarters turn counter-clockwise; display will turn back what is turned here.
        yield np.ascontiguousarray(np.rot90(picture, -encoding.rotation_deg // 90))


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

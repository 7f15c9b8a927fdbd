"""From paths and a stage to pictures, and from pictures to a file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.footage.writer import WriteOptions, write_clip
from synth_video.camera import sensor_for
from synth_video.compositor import Compositor
from synth_video.exposure import Paths
from synth_video.optics import optics_for
from synth_video.pixels import as_pixels
from synth_video.projection import Projection, projection_of
from synth_video.scene import EncodingSettings, Scene
from synth_video.schedule import Schedule
from synth_video.stage import Stage
from synth_video.tripod import tripod_shift
from synth_video.truth import truth_path

CLOCK, ART, NOISE = 1, 2, 3
"""Each use of chance has its own stream: more noise does not change what stands on the shelf."""

Setter = Callable[[Projection, np.random.Generator], Stage]
"""Paints what is there before the first frame, as a projection shows it."""


def pictures(
    scene: Scene, seed: int, schedule: Schedule, paths: Iterable[Paths], set_stage: Setter
) -> Iterator[NDArray[np.uint8]]:
    """Yield the RGB pictures of what moves along the paths, shape (h, w, 3), one by one."""
    projection = projection_of(scene)
    optics = optics_for(projection, tripod_shift(scene.tripod, schedule, seed))
    compositor = Compositor(set_stage(optics.composed, np.random.default_rng([seed, ART])))
    noise = np.random.default_rng([seed, NOISE])
    sensor = sensor_for(scene.camera, scene.light, schedule, noise)
    copies, picture = schedule.copies, None
    for k, path in enumerate(paths):
        if picture is not None and copies[k]:
            yield picture
            continue
        light = optics.seen(compositor.compose(path), k)
        seen = as_pixels(cv2.flip(light, 1)) if projection.mirrored else light
        picture = sensor.expose(seen, k)
        yield picture


def write_film(
    clip_path: Path,
    frames: Iterator[NDArray[np.uint8]],
    scene: Scene,
    schedule: Schedule,
    tell: Callable[[Path], None],
) -> None:
    """Encode the pictures as the scene asks; ``tell`` then writes their truth to its path.

    Raises
    ------
    UsageError
        If the file cannot be written so, or its truth cannot.
    """
    write_clip(clip_path, _stored(frames, scene.encoding), _write_options(scene, schedule))
    try:
        tell(truth_path(clip_path))
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

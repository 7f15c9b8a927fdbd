"""From a scene to its pictures, and to a clip with its truth beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.physics.simulator import simulate
from count_video.video.writer import WriteOptions, write_clip
from synth_video.body_picture import Pixels, Placed, as_pixels
from synth_video.experiments.course import Course, course_of_trial
from synth_video.experiments.happening import course_of, schedule_of_course
from synth_video.moving_layers import Layer
from synth_video.optics import optics_for, sensor_for
from synth_video.projection import projection_of, tripod_shift
from synth_video.scene import EncodingSettings, Scene
from synth_video.schedule import Paths, Schedule, exposures, schedule_of
from synth_video.stage import Stage, set_stage
from synth_video.truth import ClipTruth, truth_of, truth_of_course, truth_path, write_text

# ---- moving parts over the still picture ---------------------------------------------------------
# Lay the moving parts over the still picture, frame by frame.

Spot = tuple[slice, slice]


@dataclass
class Compositor:
    """A canvas that is repaired and painted again only where something is laid over it."""

    stage: Stage
    _canvas: Pixels = field(init=False)
    _touched: list[Spot] = field(init=False)

    def __post_init__(self) -> None:
        self._canvas = self.stage.still.copy()
        self._touched = []

    def compose(self, paths: Paths) -> Pixels:
        """Return the picture, shape (h, w, 3), during one exposure; the next call reuses it.

        Coordinates are tilted ones: the wall stands on the left.
        """
        for spot in self._touched:
            self._canvas[spot] = self.stage.still[spot]
        self._touched = []
        for source in self.stage.layer_sources:
            for layer in source.layers(paths, self.stage.projection):
                self._lay(layer)
        return self._canvas

    def _lay(self, layer: Layer) -> None:
        """Lay a premultiplied picture over the canvas, as far as its strength lets it."""
        spot, pixels = _inside(layer.placed, self._canvas.shape)
        if not pixels.size:
            return
        self._touched.append(spot)
        if layer.strength is not None:
            pixels = pixels * layer.strength[spot]
        part = self._canvas[spot]
        part *= 1 - pixels[..., 3:4]
        part += pixels[..., :3]
        if pixels.shape[2] == 5:
            # The fifth channel mirrors the lamps, whose image stays where it is in the picture.
            part += pixels[..., 4:] * self.stage.lamps[spot]


def _inside(placed: Placed, shape: tuple[int, ...]) -> tuple[Spot, Pixels]:
    """Part of the canvas that a picture covers, and the part of the picture that covers it."""
    height, width = placed.pixels.shape[:2]
    top, left = max(placed.y_px, 0), max(placed.x_px, 0)
    bottom = max(min(placed.y_px + height, shape[0]), top)
    right = max(min(placed.x_px + width, shape[1]), left)
    pixels = placed.pixels[
        top - placed.y_px : bottom - placed.y_px, left - placed.x_px : right - placed.x_px
    ]
    return (slice(top, bottom), slice(left, right)), pixels


# ---- films ---------------------------------------------------------------------------------------
# From a scene to its pictures, and to a clip with its truth beside it.

CLOCK, ART, NOISE = 1, 2, 3
"""Each use of chance has its own stream: more noise does not change what stands on the shelf."""


def render_clip(scene: Scene, seed: int, clip_path: Path) -> ClipTruth:
    """Work out and film what a scene shows; write the clip and, beside it, its truth.

    Raises
    ------
    UsageError
        If the scene shows no collision, its numbers allow no run, the clip is too long, or it
        cannot be written as asked.
    """
    clock, projection = np.random.default_rng([seed, CLOCK]), projection_of(scene)
    truth: ClipTruth
    if scene.experiment.kind == "pi":
        motion = simulate(scene.setup, seed=seed)
        course = course_of_trial(motion, rising=scene.view.rising_path)
        schedule = schedule_of(scene, motion, clock)
        truth = truth_of(scene, seed, motion, schedule, projection)
    else:
        course = course_of(scene)
        schedule = schedule_of_course(scene, course, clock)
        truth = truth_of_course(scene, seed, course, schedule, projection)
    _write_film(clip_path, frames_of(scene, seed, course, schedule), scene, schedule, truth.text())
    return truth


def frames_of(
    scene: Scene, seed: int, course: Course, schedule: Schedule
) -> Iterator[NDArray[np.uint8]]:
    """Yield the RGB pictures of what moves on a course, shape (h, w, 3), one by one."""
    projection = projection_of(scene)
    optics = optics_for(projection, tripod_shift(scene.tripod, schedule, seed))
    art = np.random.default_rng([seed, ART])
    compositor = Compositor(set_stage(scene, optics.composed, art, course))
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

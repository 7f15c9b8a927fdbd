"""Helpers of these tests: small scenes, still bodies, and what of a picture is covered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from count_video.physics.simulator import Motion, simulate
from count_video.records import Floats
from synth_video.experiments.course import course_of_trial
from synth_video.film import Compositor, frames_of
from synth_video.projection import projection_of
from synth_video.scene import Scene
from synth_video.scene_file import load_scene
from synth_video.schedule import BodyPath, Paths, Schedule, schedule_of
from synth_video.stage import Stage, set_stage

BARE = ("light.shadow=0", "wall.reflection=0", "wall.front_m=0", "camera.vignette=0")
"""Nothing but the bodies changes the picture."""
NOISELESS = ("camera.read_noise=0", "camera.shot_noise=0")


def small_scene(name: str = "paper", *overrides: str) -> Scene:
    """A scene at a quarter of the usual picture, quick to film."""
    return load_scene(name, ["camera.width_px=320", "camera.height_px=120", *overrides])


def filmed_times(scene: Scene, seed: int = 0) -> tuple[Motion, Schedule]:
    """Motion and times of a trial."""
    motion = simulate(scene.setup, seed=seed)
    return motion, schedule_of(scene, motion, np.random.default_rng(seed))


def filmed(scene: Scene, seed: int = 0) -> tuple[Motion, Schedule, list[NDArray[np.uint8]]]:
    """Motion, times and all pictures of a trial."""
    motion, schedule = filmed_times(scene, seed)
    course = course_of_trial(motion, rising=scene.view.rising_path)
    return motion, schedule, list(frames_of(scene, seed, course, schedule))


class CoverageCamera:
    """Sees how much of each pixel the bodies cover, by filming them before black and white."""

    def __init__(self, scene: Scene) -> None:
        self.projection = projection_of(scene)
        self.stage = set_stage(scene, self.projection, np.random.default_rng(0))
        self._on_black, self._on_white = (
            Compositor(_before(self.stage, shade)) for shade in (0.0, 255.0)
        )

    def coverage(self, ball_m: Floats, heavy_m: Floats) -> Floats:
        """Covered part of each pixel, (h, w), while the bodies pass these places, shape (m,)."""
        level = np.zeros_like(ball_m)
        paths = Paths((BodyPath(ball_m, level), BodyPath(heavy_m, level)), level)
        black = self._on_black.compose(paths)[..., 0].astype(float)
        white = self._on_white.compose(paths)[..., 0].astype(float)
        return 1 - (white - black) / 255

    def row_of(self, along_m: float) -> int:
        """The row of pixels nearest to the line of motion at this distance from the wall."""
        return round(float(self.projection.tilted(np.array(along_m), np.array(0.0))[1]))


def _before(stage: Stage, shade: float) -> Stage:
    return replace(stage, still=np.full_like(stage.still, shade))


def edge_px(row: Floats, outside: int, inside: int) -> float:
    """Place where a row of coverage goes from 0 at pixel ``outside`` to 1 at pixel ``inside``."""
    if outside < inside:
        return inside + 0.5 - float(row[outside : inside + 1].sum())
    return inside - 0.5 + float(row[inside : outside + 1].sum())

"""One synthetic trial from scene to clip and truth."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from count_video.physics.simulator import Motion, simulate
from synth_video.experiments.filming import render_experiment
from synth_video.experiments.truth import ExperimentTruth
from synth_video.exposure import exposures
from synth_video.film import CLOCK, pictures, write_film
from synth_video.projection import Projection, projection_of
from synth_video.scene import Scene
from synth_video.schedule import Schedule, schedule_of
from synth_video.stage import set_stage
from synth_video.truth import Truth, truth_of, write_truth


def render_clip(scene: Scene, seed: int, clip_path: Path) -> Truth | ExperimentTruth:
    """Film whatever experiment a scene shows; write the clip and, beside it, its truth.

    Raises
    ------
    UsageError
        As for ``render_trial``.
    """
    render = render_trial if scene.experiment.kind == "pi" else render_experiment
    return render(scene, seed, clip_path)


def render_trial(scene: Scene, seed: int, clip_path: Path) -> Truth:
    """Simulate and film a trial; write the clip and, beside it, its truth.

    Raises
    ------
    UsageError
        If the scene shows no collision, is too long, or cannot be written as asked.
    """
    motion = simulate(scene.setup, seed=seed)
    schedule = schedule_of(scene, motion, np.random.default_rng([seed, CLOCK]))
    projection = projection_of(scene)
    truth = truth_of(scene, seed, motion, schedule, projection)
    frames = render_frames(scene, seed, motion, schedule, projection)
    write_film(clip_path, frames, scene, schedule, partial(write_truth, truth))
    return truth


def render_frames(
    scene: Scene, seed: int, motion: Motion, schedule: Schedule, projection: Projection
) -> Iterator[NDArray[np.uint8]]:
    """Yield the RGB pictures of a trial, shape (h, w, 3), one by one."""
    rising = scene.view.rising_path
    paths = exposures(motion, schedule, projection.px_per_m, rising=rising)
    yield from pictures(scene, seed, schedule, paths, partial(set_stage, scene))

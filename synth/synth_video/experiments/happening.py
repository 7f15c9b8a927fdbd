"""From a scene to what happens in it and what its clip shows of that; random runs of it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.physics.setup import Setup
from synth_video.appearance import Color
from synth_video.experiments.course import Course
from synth_video.experiments.one_body import in_the_air, on_a_thread, on_a_track
from synth_video.experiments.several import cradle, passing, two_discs, two_pendulums
from synth_video.projection import projection_of
from synth_video.scene import ExperimentSettings, Scene
from synth_video.schedule import Schedule, timed
from synth_video.truth import ExperimentTruth, PathTruth, truth_of_course

COURSES = {
    "bounce": in_the_air,
    "throw": in_the_air,
    "stops": on_a_track,
    "pendulum": on_a_thread,
    "swing": on_a_thread,
    "pucks": two_discs,
    "pendulums": two_pendulums,
    "passing": passing,
    "cradle": cradle,
}
"""For each kind of experiment who works out its course."""


def course_of(scene: Scene) -> Course:
    """Work out what happens in a scene.

    Raises
    ------
    UsageError
        If the scene shows the ball between cylinder and wall, or its numbers allow no run.
    """
    experiment = scene.experiment
    if experiment.kind not in COURSES:
        raise UsageError("a ball between cylinder and wall is a trial, not one of the experiments")
    return COURSES[experiment.kind](experiment, scene.setup)


# ---- which part a clip shows ---------------------------------------------------------------------
# Which part of an experiment a clip shows.


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


# ---- random runs ---------------------------------------------------------------------------------
# Random runs of an experiment, so that many clips of a scene are as many different ones.

FEWEST_IMPACTS, MOST_IMPACTS = 4, 12
RATES = (24.0, 25.0, 30.0, 50.0, 60.0, 100.0, 120.0, 240.0)
"""Frames per second that cameras offer."""
FEWEST_FRAMES, MOST_FRAMES = 40, 500
SHORTEST_INTERVAL_FRAMES = 3.5
FASTEST_PX = 30.0
"""A body moves no farther from one frame to the next."""
COLORS: tuple[Color, ...] = (
    (226, 103, 28), (236, 234, 228), (28, 28, 32), (228, 196, 40), (186, 40, 44), (40, 76, 150),
    (52, 124, 70),
)  # fmt: skip
BACKGROUNDS: tuple[Color, ...] = (
    (128, 119, 110), (172, 172, 168), (84, 90, 98), (150, 128, 104), (110, 132, 140),
)  # fmt: skip
LEAST_CONTRAST = 35.0
"""Between body and background, in grey levels."""
_TRIES = 2000


def varied_experiment(scene: Scene, seed: int) -> Scene:
    """Draw the start, restitution, colours, side and capture rate of an experiment at random.

    All collisions of the drawn clip can be seen one by one. Where a body bounces, it does so 4
    to 12 times.

    Raises
    ------
    UsageError
        If the scene's bodies allow no such clip.
    """
    rng = np.random.default_rng(seed)
    for _ in range(_TRIES):
        drawn = _drawn(scene, rng)
        for rate in rng.permutation(RATES):
            at_rate = replace(drawn, camera=replace(drawn.camera, capture_fps=float(rate)))
            try:
                if _fits(_truth(at_rate, seed, rng)):
                    return at_rate
            except UsageError:  # too few impacts, or too many frames
                continue
    raise UsageError(f"no run found for scene {scene.name} in {_TRIES} draws; check its numbers")


def _truth(scene: Scene, seed: int, rng: np.random.Generator) -> ExperimentTruth:
    """Return what a clip of the scene would show."""
    course = course_of(scene)
    schedule = schedule_of_course(scene, course, rng)
    return truth_of_course(scene, seed, course, schedule, projection_of(scene))


def _fits(truth: ExperimentTruth) -> bool:
    """Return whether the clip is short, slow and plain enough, and its bodies stay in sight."""
    if not FEWEST_FRAMES <= truth.frames <= MOST_FRAMES or not truth.resolved:
        return False
    if truth.shortest_interval_frames < SHORTEST_INTERVAL_FRAMES:
        return False
    ways = (np.hypot(np.diff(body.x_px), np.diff(body.y_px)) for body in truth.bodies)
    if max(way.max() for way in ways) > FASTEST_PX:
        return False
    inside = np.array([_inside(truth, body) for body in truth.bodies])
    kind = truth.scene.experiment.kind
    if kind == "pucks":  # one may leave the picture when one has seen how they go on
        seen = truth.events and truth.events[0].frame < 0.7 * truth.frames
        return bool(seen) and bool(inside.any(axis=0).all())
    return kind == "throw" or bool(inside.all())


def _inside(truth: ExperimentTruth, body: PathTruth) -> NDArray[np.bool_]:
    """In which frames the whole body is in the picture, shape (n,)."""
    camera = truth.scene.camera
    radius_px = truth.scene.setup.ball_diameter_m * truth.px_per_m / 2
    inside = (body.x_px > radius_px) & (body.x_px < camera.width_px - radius_px)
    return inside & (body.y_px > radius_px) & (body.y_px < camera.height_px - radius_px)


def _drawn(scene: Scene, rng: np.random.Generator) -> Scene:
    """Everything at random, not yet checked."""
    experiment = _drawn_start(scene.experiment, scene.setup.ball_diameter_m, rng)
    setup = _drawn_losses(scene.setup, rng)
    background = BACKGROUNDS[rng.integers(len(BACKGROUNDS))]
    fitting = [c for c in COLORS if abs(_grey(c) - _grey(background)) >= LEAST_CONTRAST]
    spin_hz = float(rng.uniform(-1.5, 1.5)) if scene.ball.spin_hz else 0.0
    color = fitting[rng.integers(len(fitting))]
    return replace(
        scene,
        experiment=experiment,
        setup=setup,
        ball=replace(scene.ball, color=color, spin_hz=spin_hz),
        background=replace(scene.background, color=background),
        wall=replace(scene.wall, side="left" if rng.random() < 0.5 else "right"),
    )


def _drawn_start(
    experiment: ExperimentSettings, size_m: float, rng: np.random.Generator
) -> ExperimentSettings:
    """How it starts and how long it goes on; some kinds have ranges of their own."""
    start, speed, slope, drift = (
        float(rng.uniform(*bounds)) for bounds in ((0.5, 1.1), (0.6, 1.3), (0.5, 2.0), (-1.0, 1.0))
    )
    impacts, offset_m = int(rng.integers(FEWEST_IMPACTS, MOST_IMPACTS + 1)), experiment.offset_m
    if experiment.kind == "pucks" and offset_m:
        offset_m = float(rng.uniform(-0.5, 0.5)) * size_m
    elif experiment.kind == "passing":
        offset_m *= float(rng.uniform(0.5, 4.0))
    elif experiment.kind == "pendulums":
        impacts = int(rng.integers(1, 4))
    return replace(
        experiment,
        start_m=start * experiment.start_m,
        speed_m_s=speed * experiment.speed_m_s,
        slope=slope * experiment.slope,
        drift_m_s=(drift if experiment.kind == "bounce" else 1.0) * experiment.drift_m_s,
        offset_m=offset_m,
        impacts=impacts if experiment.impacts else 0,
    )


def _drawn_losses(setup: Setup, rng: np.random.Generator) -> Setup:
    """Restitution and length of the threads."""
    return replace(
        setup,
        restitution_wall=float(rng.uniform(0.7, 0.95)),
        restitution_bodies=float(rng.uniform(0.8, 1.0)),
        light_thread_m=setup.light_thread_m * float(rng.uniform(0.6, 1.2)),
    )


def _grey(color: Color) -> float:
    """Brightness as the eye weighs it."""
    return 0.299 * color[0] + 0.587 * color[1] + 0.114 * color[2]

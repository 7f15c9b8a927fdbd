"""From a scene to what happens in it."""

from __future__ import annotations

from count_video.errors import UsageError
from synth_video.experiments.course import Course
from synth_video.experiments.several import cradle, passing, two_discs, two_pendulums
from synth_video.experiments.single_body import in_the_air, on_a_thread, on_a_track
from synth_video.scene import Scene

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

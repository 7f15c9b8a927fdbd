"""One body: it falls, runs on a track or swings, against something or freely."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from count_video.physics.flights import Law, Sliding
from count_video.physics.setup import Setup
from count_video.records import Floats
from synth_video.experiments.course import SPARE_S, Contact, Course, free_run, pendulum_of, rise_m
from synth_video.experiments.one_body import Falling, Stops, run_one_body
from synth_video.scene import ExperimentSettings

Run = Callable[[Floats], Floats]
"""From times of any shape to the position of the body's face, in m."""


def _run(
    experiment: ExperimentSettings, law: Law, start_m: float, stops: Stops | None
) -> tuple[Run, tuple[Contact, ...]]:
    """Run one body, and name each of its impacts; without stops it meets nothing."""
    if stops is None:
        return free_run(law, start_m, experiment.speed_m_s), ()
    motion = run_one_body(
        law, start_m, experiment.speed_m_s, stops, SPARE_S + experiment.duration_s
    )
    contacts = tuple(Contact(impact.time_s, "wall") for impact in motion.impacts)
    return lambda times_s: motion.sample(times_s)[0], contacts


def _stops(experiment: ExperimentSettings, setup: Setup) -> Stops:
    """Stop of the table, the track or the wall, which the body strikes from above 0."""
    return Stops(restitution=setup.restitution_wall, slow_m_s=experiment.slow_m_s)


def in_the_air(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let a ball fall on the table, whose top is at height 0, or past it."""
    law = Falling(-setup.gravity_m_s2)
    stops = None if experiment.kind == "throw" else _stops(experiment, setup)
    run, contacts = _run(experiment, law, experiment.start_m, stops)

    def place(times_s: Floats) -> tuple[Floats, Floats]:
        height_m = run(times_s) + setup.ball_diameter_m / 2
        return experiment.drift_m_s * np.maximum(times_s, 0.0), height_m

    return Course(contacts, (place,))


def on_a_track(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let a cart run down to a stop whose face is at 0, or to and fro between two."""
    size_m, weight = setup.ball_diameter_m, setup.gravity_m_s2
    stops = _stops(experiment, setup)
    if experiment.span_m:
        stops = replace(stops, high_m=experiment.span_m - size_m)
    law: Law = Sliding(setup.light_friction * weight)
    if experiment.slope:
        law = Falling(-experiment.slope * weight)
    run, contacts = _run(experiment, law, experiment.start_m, stops)

    def place(times_s: Floats) -> tuple[Floats, Floats]:
        return run(times_s) + size_m / 2, np.zeros_like(times_s)

    return Course(contacts, (place,))


def on_a_thread(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let a ball swing against the wall, whose face is at 0, or freely."""
    law = pendulum_of(setup, setup.wall_gap_m)
    stops = None if experiment.kind == "swing" else _stops(experiment, setup)
    run, contacts = _run(experiment, law, setup.wall_gap_m + experiment.start_m, stops)

    def place(times_s: Floats) -> tuple[Floats, Floats]:
        face_m = run(times_s)
        return face_m + setup.ball_diameter_m / 2, rise_m(
            setup, face_m - setup.wall_gap_m, setup.light_thread_m
        )

    return Course(contacts, (place,), (setup.wall_gap_m + setup.ball_diameter_m / 2,))

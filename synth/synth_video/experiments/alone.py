"""One body: it falls, runs on a track or swings, against something or freely."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from count_video.physics.falling import Falling
from count_video.physics.flights import Law, Sliding
from count_video.physics.lone import LoneMotion, Stops, simulate_lone
from count_video.physics.setup import Setup
from count_video.records import Floats
from synth_video.experiments.course import SPARE_S, Contact, Course, pendulum_of
from synth_video.experiments.settings import ExperimentSettings
from synth_video.exposure import rise_m


def _run(
    experiment: ExperimentSettings, law: Law, start_m: float, stops: Stops
) -> tuple[LoneMotion, tuple[Contact, ...]]:
    """Run one body, and name each of its impacts."""
    motion = simulate_lone(
        law, start_m, experiment.speed_m_s, stops, SPARE_S + experiment.duration_s
    )
    return motion, tuple(Contact(impact.time_s, "wall") for impact in motion.impacts)


def in_the_air(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let a ball fall on the table, whose top is at height 0, or past it."""
    stops = Stops(0.0, math.inf, setup.restitution_wall, experiment.slow_m_s)
    if experiment.kind == "throw":
        stops = replace(stops, low_m=-math.inf)
    law = Falling(-setup.gravity_m_s2)
    motion, contacts = _run(experiment, law, experiment.start_m, stops)

    def place(times_s: Floats) -> tuple[Floats, Floats]:
        height_m = motion.sample(times_s)[0] + setup.ball_diameter_m / 2
        return experiment.drift_m_s * np.maximum(times_s, 0.0), height_m

    return Course(contacts, (place,))


def on_a_track(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let a cart run down to a stop whose face is at 0, or to and fro between two."""
    size_m, weight = setup.ball_diameter_m, setup.gravity_m_s2
    high_m = experiment.span_m - size_m if experiment.span_m else math.inf
    stops = Stops(0.0, high_m, setup.restitution_wall, experiment.slow_m_s)
    law: Law = Sliding(setup.light_friction * weight)
    if experiment.slope:
        law = Falling(-experiment.slope * weight)
    motion, contacts = _run(experiment, law, experiment.start_m, stops)

    def place(times_s: Floats) -> tuple[Floats, Floats]:
        return motion.sample(times_s)[0] + size_m / 2, np.zeros_like(times_s)

    return Course(contacts, (place,))


def on_a_thread(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let a ball swing against the wall, whose face is at 0, or freely."""
    low_m = 0.0 if experiment.kind == "pendulum" else -math.inf
    stops = Stops(low_m, math.inf, setup.restitution_wall, experiment.slow_m_s)
    law = pendulum_of(setup, setup.wall_gap_m)
    motion, contacts = _run(experiment, law, setup.wall_gap_m + experiment.start_m, stops)

    def place(times_s: Floats) -> tuple[Floats, Floats]:
        face_m = motion.sample(times_s)[0]
        return face_m + setup.ball_diameter_m / 2, rise_m(
            setup, face_m - setup.wall_gap_m, setup.light_thread_m
        )

    return Course(contacts, (place,), (setup.wall_gap_m + setup.ball_diameter_m / 2,))

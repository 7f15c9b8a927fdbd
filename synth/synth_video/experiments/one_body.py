"""One body alone: it falls, runs on a track or swings, between two stops, one stop or none."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from count_video.errors import UsageError
from count_video.physics.laws import Law, Mover, contact_s
from count_video.physics.setup import Setup
from count_video.records import CollisionKind, Floats
from synth_video.experiments.course import SPARE_S, Contact, Course, free_run, pendulum_of, rise_m
from synth_video.scene import ExperimentSettings

MOST_IMPACTS = 100_000
"""A run with more is refused before it fills the memory."""
NO_STOP_M = 1e3
"""A stop so far away that nothing reaches it."""


@dataclass(frozen=True)
class Stops:
    """What the body strikes: a stop at 0 and perhaps one above it, positions in metres.

    Raises
    ------
    UsageError
        If a number is out of its range.
    """

    high_m: float = NO_STOP_M
    """Upper stop."""
    restitution: float = 1.0
    """Speed after an impact over the speed before it."""
    slow_m_s: float = 0.0
    """An impact no faster than this is no bounce and the last one: the body stays, or goes where
    its law draws it. Without it an inelastic ball would bounce infinitely often before it rests."""

    def __post_init__(self) -> None:
        if not self.high_m > 0.0:
            raise UsageError(f"the upper stop is at {self.high_m:g} m; it must lie above 0")
        if not 0.0 <= self.restitution <= 1.0:
            raise UsageError(f"restitution is {self.restitution:g}; it must lie between 0 and 1")
        if not 0.0 <= self.slow_m_s < math.inf:
            raise UsageError(f"slow_m_s is {self.slow_m_s:g}; it must be finite and not negative")


@dataclass(frozen=True)
class Impact:
    """One bounce; velocities are positive away from the stop at 0."""

    time_s: float
    kind: CollisionKind
    """``wall`` at the stop at 0, ``bodies`` at the upper one."""
    before_m_s: float
    after_m_s: float


@dataclass(frozen=True)
class OneBody:
    """A simulated run."""

    law: Law
    until_s: float
    """Simulated up to here."""
    impacts: tuple[Impact, ...]
    events: Floats
    """Time, position and velocity after each event, the start first, shape (events, 3)."""
    rests_s: float
    """When the body came to stay where it is; inf if it did not."""

    def sample(self, times_s: Floats) -> tuple[Floats, Floats]:
        """Position and velocity at times of any shape, up to ``until_s``.

        Before time 0 the body is held at its start. At the very time of an impact the velocity is
        the one after it.

        Raises
        ------
        UsageError
            If a time is not finite or later than ``until_s``.
        """
        times = np.asarray(times_s, dtype=np.float64)
        if not (np.isfinite(times).all() and times.max(initial=0.0) <= self.until_s):
            raise UsageError(f"the motion is known up to {self.until_s:g} s; simulate it longer")
        now = np.clip(times, 0.0, self.rests_s)
        rows = np.searchsorted(self.events[:, 0], now, side="right") - 1
        start_s, position, velocity = np.moveaxis(self.events[rows], -1, 0)
        rise, velocity = self.law.advance(position, velocity, now - start_s)
        return position + rise, np.where(times < 0, 0.0, velocity)


def run_one_body(
    law: Law, position_m: float, velocity_m_s: float, stops: Stops, until_s: float
) -> OneBody:
    """Run one body from time 0 to ``until_s``.

    Raises
    ------
    UsageError
        If the body does not start between the stops, ``until_s`` is no time, or there are more
        than ``MOST_IMPACTS`` impacts.
    """
    if not 0.0 <= position_m <= stops.high_m:
        raise UsageError(f"the body starts at {position_m:g} m, which is not between its stops")
    if not 0.0 <= until_s < math.inf:
        raise UsageError(f"cannot simulate until {until_s} s; give a finite time from 0 on")
    high = Mover(Law(), np.array([stops.high_m]), np.zeros(1))
    time_s, rests_s = 0.0, math.inf
    events, impacts = [(time_s, position_m, velocity_m_s)], list[Impact]()
    while True:
        body = Mover(law, np.array([events[-1][1]]), np.array([events[-1][2]]))
        left_s = np.array([until_s - time_s])
        down_s, up_s = contact_s(body, None, left_s), contact_s(high, body, left_s)
        flight_s = np.minimum(down_s, up_s)
        if flight_s[0] > left_s[0]:
            break
        before_m_s, at_wall = float(body.after(flight_s)[1][0]), bool(down_s[0] <= up_s[0])
        time_s, place_m = time_s + float(flight_s[0]), 0.0 if at_wall else stops.high_m
        if abs(before_m_s) <= stops.slow_m_s:
            events.append((time_s, place_m, 0.0))
            pull = law.acceleration(place_m, 0.0)
            rests_s = time_s if (pull <= 0.0 if at_wall else pull >= 0.0) else math.inf
            break
        after_m_s = -stops.restitution * before_m_s
        events.append((time_s, place_m, after_m_s))
        impacts.append(Impact(time_s, "wall" if at_wall else "bodies", before_m_s, after_m_s))
        if len(impacts) > MOST_IMPACTS:
            raise UsageError(f"more than {MOST_IMPACTS} impacts; end sooner or raise slow_m_s")
    return OneBody(law, until_s, tuple(impacts), np.array(events), rests_s)


# ---- from a scene --------------------------------------------------------------------------------
# One body: it falls, runs on a track or swings, against something or freely.

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
    law = Law(acceleration_m_s2=-setup.gravity_m_s2)
    stops = None if experiment.kind == "throw" else _stops(experiment, setup)
    run, contacts = _run(experiment, law, experiment.start_m, stops)

    def place(times_s: Floats) -> tuple[Floats, Floats]:
        height_m = run(times_s) + setup.ball_diameter_m / 2
        return experiment.drift_m_s * np.maximum(times_s, 0.0), height_m

    return Course(contacts, (place,))


def on_a_track(experiment: ExperimentSettings, setup: Setup) -> Course:
    """Let a cart run down to a stop whose face is at 0, or to and fro between two."""
    size_m = setup.ball_diameter_m
    stops = _stops(experiment, setup)
    if experiment.span_m:
        stops = replace(stops, high_m=experiment.span_m - size_m)
    law = Law(acceleration_m_s2=-experiment.slope * setup.gravity_m_s2)
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

"""One body alone: it falls, runs on a track or swings, between two stops, one stop or none.

It is a trial of ball, cylinder and wall in which the second stop stands for the cylinder: a body
beside which the moving one has no mass.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from count_video.errors import UsageError
from count_video.physics.engine import Anchor, SimulatedCollision, events, settle, states_at
from count_video.physics.flights import REST, Law, Number, Sliding
from count_video.physics.setup import Apparatus, Hold, Setup
from count_video.records import Floats
from synth_video.experiments.course import SPARE_S, Contact, Course, free_run, pendulum_of, rise_m
from synth_video.scene import ExperimentSettings

MOST_IMPACTS = 100_000
"""A run with more is refused before it fills the memory."""
NO_STOP_M = 1e3
"""A stop so far away that nothing reaches it."""
FALL_WINDOW_S = 10.0
"""A body that falls and meets nothing begins a new flight after this time, in which it cannot get
as far as ``NO_STOP_M``."""


@dataclass(frozen=True, slots=True)
class Falling(Law):
    """A parabola in time: q'' = a; a ball in the air, a cart on an inclined track."""

    acceleration_m_s2: float
    """Of any sign; negative toward the stop at 0."""

    def advance(
        self, position_m: Number, velocity_m_s: Number, tau_s: Number
    ) -> tuple[Number, Number]:
        """Displacement and velocity after ``tau_s``."""
        pull = self.acceleration_m_s2
        return (velocity_m_s + 0.5 * pull * tau_s) * tau_s, velocity_m_s + pull * tau_s

    def acceleration(self, position_m: float, velocity_m_s: float) -> float:
        """Constant."""
        return self.acceleration_m_s2

    def bounds(self, position_m: float, velocity_m_s: float) -> tuple[float, float]:
        """|acceleration|, and no jerk."""
        return abs(self.acceleration_m_s2), 0.0

    def valid_for_s(self, velocity_m_s: float) -> float:
        """``FALL_WINDOW_S``: the closed form holds on, but stops are sought window by window."""
        return FALL_WINDOW_S

    def potential(self, position_m: float) -> float:
        """Per unit mass: −a q, 0 at the origin."""
        return -self.acceleration_m_s2 * position_m


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
    """An impact no faster than this is no bounce: the body stays. Without it an inelastic ball
    would bounce infinitely often before it rests."""

    def __post_init__(self) -> None:
        if not self.high_m > 0.0:
            raise UsageError(f"the upper stop is at {self.high_m:g} m; it must lie above 0")
        if not 0.0 <= self.restitution <= 1.0:
            raise UsageError(f"restitution is {self.restitution:g}; it must lie between 0 and 1")
        if not 0.0 <= self.slow_m_s < math.inf:
            raise UsageError(f"slow_m_s is {self.slow_m_s:g}; it must be finite and not negative")


@dataclass(frozen=True)
class OneBody:
    """A simulated run."""

    apparatus: Apparatus
    until_s: float
    """Simulated up to here."""
    impacts: tuple[SimulatedCollision, ...]
    """Of kind ``wall`` at the stop at 0, ``bodies`` at the upper one; the body is the light one."""
    anchors: tuple[Anchor, ...]
    """State after each event, the start first."""

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
        states = states_at(self.apparatus, self.anchors, np.maximum(times.ravel(), 0.0))
        position, velocity = states[2:].reshape(2, *times.shape)
        return position, np.where(times < 0, 0.0, velocity)


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
    apparatus = Apparatus(
        heavy_kg=1.0, light_kg=0.0, heavy=REST, light=law, together=REST, relative=None,
        resting_speed_m_s=0.0, resting_acceleration_m_s2=0.0,
    )  # fmt: skip
    anchor = Anchor(0.0, stops.high_m, 0.0, position_m, velocity_m_s, Hold.APART)
    anchors, impacts = [anchor], list[SimulatedCollision]()
    following = events(apparatus, anchor, lambda kind: stops.restitution)
    while (step := next(following, None)) is not None and step[0].time_s <= until_s:
        anchor, impact = step
        if impact is not None and abs(impact.light_before_m_s) <= stops.slow_m_s:
            anchor = settle(apparatus, anchor._replace(ball_velocity_m_s=0.0))
            following = events(apparatus, anchor, lambda kind: stops.restitution)
        elif impact is not None:
            impacts.append(impact)
        anchors.append(anchor)
        if len(impacts) > MOST_IMPACTS:
            raise UsageError(f"more than {MOST_IMPACTS} impacts; end sooner or raise slow_m_s")
    return OneBody(apparatus, until_s, tuple(impacts), tuple(anchors))


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

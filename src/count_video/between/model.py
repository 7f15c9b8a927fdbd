"""The event-driven model, for many sets of parameters at once.

`physics.simulator` follows one trial to rounding and through every oddity. A fit needs the same
motion a few thousand times over, with slightly different parameters, and knows what happens next:
bodies, wall, bodies, wall ... So each flight is solved for all sets together, in closed form where
the threads are equal and with Newton steps from there where they are not. The laws are those of the
simulator: x'' = -w^2 (x - x0) for each body, and (1 + e) of the relative velocity at a contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.between.parameters import FIRST_DEVIATION, Column
from count_video.records import Floats

State = tuple[Floats, Floats, Floats, Floats]
"""Heavy body's place and velocity, then the ball's; each of shape (sets,)."""
NEWTON_STEPS = 2
"""From the closed form for equal threads; each squares the error."""


@dataclass(frozen=True)
class Pendulums:
    """Rates and rest places of both bodies; arrays have shape (sets,)."""

    heavy_rate: Floats
    heavy_rest: Floats
    ball_rate: Floats
    ball_rest: Floats


@dataclass(frozen=True)
class Paths:
    """Motions of all sets; piece k lasts from event k to event k + 1, piece 0 is the start."""

    pendulums: Pendulums
    time: Floats
    """Shape (sets, events + 1): the start of each piece; inf for what never happens."""
    states: Floats
    """Shape (4, sets, events + 1): heavy body's place and velocity, then the ball's."""
    before: Floats
    """Like ``states``, right before the event that starts the piece."""


def pendulums_of(sets: Floats) -> Pendulums:
    """Read the pendulums from parameter sets, shape (sets, columns)."""
    rate = np.exp(sets[:, Column.SWING])
    return Pendulums(
        heavy_rate=rate,
        heavy_rest=sets[:, Column.HEAVY] + sets[:, Column.HEAVY_PULL] / rate**2,
        ball_rate=rate * np.exp(sets[:, Column.BALL_SWING]),
        ball_rest=sets[:, Column.BALL_REST],
    )


def follow(sets: Floats, count: int, first_time: float) -> Paths:
    """Follow the motions through ``count`` collisions that alternate, the bodies' first.

    Parameters
    ----------
    sets
        Shape (sets, columns); deviations of the restitution may be left out.
    count
        Number of collisions.
    first_time
        No collision is looked for before this time (the model's time 0 may lie after the first).
    """
    pendulums = pendulums_of(sets)
    times = np.full((len(sets), count + 1), np.inf)
    states = np.zeros((4, len(sets), count + 1))
    before = np.zeros_like(states)
    lightness, wall = np.exp(sets[:, Column.LIGHTNESS]), sets[:, Column.WALL]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        state = _start(sets, pendulums, first_time)
        times[:, 0], states[:, :, 0], before[:, :, 0] = first_time, state, state
        for event in range(count):
            to_wall = event % 2 == 1
            if event:
                state = _closed_in(wall, state)
            flight = _flight(pendulums, state, wall, to_wall=to_wall)
            arrived = advance(pendulums, state, flight)
            restitution = _restitution(sets, event)
            state = _off_wall(arrived, restitution) if to_wall else arrived
            if not to_wall:
                state = _off_body(arrived, restitution, lightness)
            times[:, event + 1] = times[:, event] + flight
            states[:, :, event + 1], before[:, :, event + 1] = state, arrived
    return Paths(pendulums, np.where(np.isnan(times), np.inf, times), states, before)


def advance(pendulums: Pendulums, state: State, time: Floats) -> State:
    """Carry states over flights, shape (sets,)."""
    heavy, heavy_velocity, ball, ball_velocity = state
    return (
        *_swung(pendulums.heavy_rate, pendulums.heavy_rest, heavy, heavy_velocity, time),
        *_swung(pendulums.ball_rate, pendulums.ball_rest, ball, ball_velocity, time),
    )


def _swung(
    rate: Floats, rest: Floats, place: Floats, velocity: Floats, time: Floats
) -> tuple[Floats, Floats]:
    angle = rate * time
    sine, cosine = np.sin(angle), np.cos(angle)
    offset = place - rest
    return rest + offset * cosine + velocity / rate * sine, velocity * cosine - offset * rate * sine


def _start(sets: Floats, pendulums: Pendulums, time: float) -> State:
    """State at the first time: the heavy body on its free path, the ball at rest."""
    heavy = _swung(
        pendulums.heavy_rate,
        pendulums.heavy_rest,
        sets[:, Column.HEAVY],
        sets[:, Column.HEAVY_RATE],
        np.full(len(sets), time),
    )
    return (*heavy, sets[:, Column.BALL_REST], np.zeros(len(sets)))


def _flight(pendulums: Pendulums, state: State, wall: Floats, *, to_wall: bool) -> Floats:
    """Time to the next contact with the wall, or of the bodies; NaN or inf if there is none."""
    heavy, heavy_velocity, ball, ball_velocity = state
    if to_wall:
        offset = pendulums.ball_rest - wall
        return _reaches(pendulums.ball_rate, offset, ball - wall, ball_velocity)
    rest_gap = pendulums.heavy_rest - pendulums.ball_rest
    time = _reaches(pendulums.heavy_rate, rest_gap, heavy - ball, heavy_velocity - ball_velocity)
    for _ in range(NEWTON_STEPS):
        there = advance(pendulums, state, time)
        closing = there[1] - there[3]
        time = time - np.where(closing < 0, (there[0] - there[2]) / closing, 0.0)
    return np.where(time >= 0, time, np.nan)


def _reaches(rate: Floats, rest: Floats, gap: Floats, opening: Floats) -> Floats:
    """First time at which a swinging gap, not negative now, falls to zero; NaN if it never does.

    gap(t) = rest + A cos(rate t - phase) falls through zero at rate t = phase + arccos(-rest / A).
    """
    offset, quarter = gap - rest, opening / rate
    phase = np.arctan2(quarter, offset)
    angle = phase + np.arccos(-rest / np.hypot(offset, quarter))
    # A ball that has just left the contact falls through zero one swing later, not now.
    left_now = (angle < -1e-9) | ((np.abs(gap) <= 0) & (opening > 0) & (angle < 1e-9))
    return np.where(left_now, angle + 2 * np.pi, np.maximum(angle, 0.0)) / rate


def _closed_in(wall: Floats, state: State) -> State:
    """Undo the rounding of the last flight, so that bodies do not start inside each other."""
    ball = np.maximum(state[2], wall)
    return np.maximum(state[0], ball), state[1], ball, state[3]


def _restitution(sets: Floats, event: int) -> Floats:
    mean = sets[:, Column.BOUNCE if event % 2 == 1 else Column.BODIES]
    column = FIRST_DEVIATION + event
    return mean + sets[:, column] if column < sets.shape[1] else mean


def _off_wall(state: State, restitution: Floats) -> State:
    heavy, heavy_velocity, ball, ball_velocity = state
    return heavy, heavy_velocity, ball, -restitution * ball_velocity


def _off_body(state: State, restitution: Floats, lightness: Floats) -> State:
    heavy, heavy_velocity, ball, ball_velocity = state
    # The impulse on the ball is (1 + e) times the relative velocity over 1 + m/M.
    step = (1 + restitution) * (heavy_velocity - ball_velocity) / (1 + lightness)
    return heavy, heavy_velocity - lightness * step, ball, ball_velocity + step

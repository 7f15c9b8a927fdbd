"""The event-driven model, for many sets of parameters at once or for one alone.

`physics.simulator` follows one trial to rounding and through every oddity. A fit needs the same
motion a few thousand times over, with slightly different parameters, and knows what happens next:
bodies, wall, bodies, wall ... So each flight is solved in closed form where the threads are equal
and with Newton steps from there where they are not. The laws are those of the simulator:
x'' = -w^2 (x - x0) for each body, and (1 + e) of the relative velocity at a contact.

An array operation takes a microsecond however short the array is; a plain number takes a
twentieth of it. A scan over thousands of sets wants arrays, a fit follows one motion at a time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from count_video.motion.parameters import FIRST_DEVIATION, Column, deviation_places
from count_video.records import Floats

Number = TypeVar("Number", float, Floats)


class Numbers:
    """The functions of NumPy that a motion needs, on single numbers; undefined values are NaN."""

    exp, sin, cos, arctan2, hypot = math.exp, math.sin, math.cos, math.atan2, math.hypot
    any, isfinite = bool, math.isfinite

    @staticmethod
    def arccos(value: float) -> float:
        """Arc cosine; NaN outside -1 to 1."""
        return math.acos(value) if -1.0 <= value <= 1.0 else math.nan

    @staticmethod
    def divide(over: float, under: float) -> float:
        """Quotient; NaN by 0."""
        return over / under if under else math.nan

    @staticmethod
    def where(condition: object, yes: float, no: float) -> float:
        """Return the first value if the condition holds, else the second."""
        return yes if condition else no

    @staticmethod
    def maximum(one: float, other: float) -> float:
        """Return the larger one; NaN stays NaN."""
        return one if one > other or one != one else other  # noqa: PLR0124


Arithmetic = Any
"""``Numbers``, or NumPy for arrays."""

NEWTON_STEPS = 2
"""From the closed form for equal threads; each squares the error."""


@dataclass(frozen=True)
class Pendulums(Generic[Number]):
    """Rates and rest places of both bodies: numbers, or arrays of shape (sets,)."""

    heavy_rate: Number
    heavy_rest: Number
    ball_rate: Number
    ball_rest: Number


@dataclass(frozen=True)
class Paths:
    """Motions of all sets; piece k lasts from event k to event k + 1, piece 0 is the start."""

    pendulums: Pendulums[Floats]
    time: Floats
    """Shape (sets, events + 1): the start of each piece; inf for what never happens."""
    states: Floats
    """Shape (4, sets, events + 1): heavy body's place and velocity, then the ball's."""
    before: Floats
    """Like ``states``, right before the event that starts the piece."""


def follow(sets: Floats, count: int, first_time: float) -> Paths:
    """Follow the motions through ``count`` collisions that alternate, the bodies' first.

    Parameters
    ----------
    sets
        Shape (sets, columns); deviations of the restitution may be left out.
    count
        Number of collisions.
    first_time
        No collision is sought before this time (the model's time 0 may lie after the first).
    """
    times = np.full((len(sets), count + 1), np.inf)
    states = np.full((4, len(sets), count + 1), np.nan)
    before = np.full_like(states, np.nan)
    columns: Sequence[Floats] = list(np.ascontiguousarray(sets.T))
    pendulums = _pendulums(columns, np)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        state = _start(columns, pendulums, np.full(len(sets), first_time), np)
        times[:, 0], states[:, :, 0], before[:, :, 0] = first_time, state, state
        for event, step in enumerate(_events(columns, pendulums, (state, count), np)):
            flight, arrived, left = step
            times[:, event + 1] = times[:, event] + flight
            states[:, :, event + 1], before[:, :, event + 1] = left, arrived
    return Paths(pendulums, np.where(np.isnan(times), np.inf, times), states, before)


def follow_one(values: Floats, count: int, first_time: float) -> Paths:
    """Follow the motion of one set, shape (columns,), as :func:`follow` does."""
    columns: Sequence[float] = values.tolist()
    pendulums = _pendulums(columns, Numbers)
    state = _start(columns, pendulums, first_time, Numbers)
    flights, before, states = [first_time], [state], [state]
    for flight, arrived, left in _events(columns, pendulums, (state, count), Numbers):
        flights.append(flight)
        before.append(arrived)
        states.append(left)
    laws = (pendulums.heavy_rate, pendulums.heavy_rest, pendulums.ball_rate, pendulums.ball_rest)
    times = np.cumsum(_padded(flights, count + 1))
    return Paths(
        Pendulums(*(np.array([law]) for law in laws)),
        np.where(np.isnan(times), np.inf, times)[None],
        _padded(states, count + 1).T[:, None],
        _padded(before, count + 1).T[:, None],
    )


def _padded(rows: Sequence[object], length: int) -> Floats:
    """Rows as an array, NaN where the motion has ended."""
    array = np.array(rows, dtype=np.float64)
    padded = np.full((length, *array.shape[1:]), np.nan)
    padded[: len(array)] = array
    return padded


State = tuple[Number, Number, Number, Number]
"""Heavy body's place and velocity, then the ball's."""


def _pendulums(columns: Sequence[Number], on: Arithmetic) -> Pendulums[Number]:
    rate = on.exp(columns[Column.SWING])
    pull = columns[Column.HEAVY_PULL] / (rate * rate)
    return Pendulums(
        heavy_rate=rate,
        heavy_rest=columns[Column.HEAVY] + pull,
        ball_rate=rate * on.exp(columns[Column.BALL_SWING]),
        ball_rest=columns[Column.BALL_REST],
    )


def _start(
    columns: Sequence[Number],
    pendulums: Pendulums[Number],
    time: Number,
    on: Arithmetic,
) -> State[Number]:
    """State at the first time: the heavy body on its free path, the ball at rest."""
    place, velocity = columns[Column.HEAVY], columns[Column.HEAVY_RATE]
    law = (pendulums.heavy_rate, pendulums.heavy_rest)
    place, velocity = _swung(law, place, velocity, time, on)
    return place, velocity, columns[Column.BALL_REST], 0.0 * velocity


def _events(
    columns: Sequence[Number],
    pendulums: Pendulums[Number],
    begin: tuple[State[Number], int],
    on: Arithmetic,
) -> Iterator[tuple[Number, State[Number], State[Number]]]:
    """Yield flight, state on arrival and state after it for each event, while there are any."""
    state, count = begin
    lightness, wall = on.exp(columns[Column.LIGHTNESS]), columns[Column.WALL]
    deviation = (FIRST_DEVIATION + deviation_places(count)).tolist()
    for event in range(count):
        to_wall = event % 2 == 1
        if event:
            state = _closed_in(wall, state, on)
        reach = _wall_flight if to_wall else _bodies_flight
        flight = reach(pendulums, state, wall, on)
        if not on.any(on.isfinite(flight)):
            return
        arrived = _advance(pendulums, state, flight, on)
        restitution = columns[Column.BOUNCE if to_wall else Column.BODIES]
        if deviation[event] < len(columns):
            restitution = restitution + columns[deviation[event]]
        if to_wall:
            state = _off_wall(arrived, restitution)
        else:
            state = _off_body(arrived, restitution, lightness)
        yield flight, arrived, state


def _advance(
    pendulums: Pendulums[Number], state: State[Number], time: Number, on: Arithmetic
) -> State[Number]:
    """Carry a state over a flight."""
    heavy_law = (pendulums.heavy_rate, pendulums.heavy_rest)
    ball_law = (pendulums.ball_rate, pendulums.ball_rest)
    heavy, heavy_velocity = _swung(heavy_law, state[0], state[1], time, on)
    ball, ball_velocity = _swung(ball_law, state[2], state[3], time, on)
    return heavy, heavy_velocity, ball, ball_velocity


def _swung(
    law: tuple[Number, Number],
    place: Number,
    velocity: Number,
    time: Number,
    on: Arithmetic,
) -> tuple[Number, Number]:
    rate, rest = law
    angle = rate * time
    sine, cosine = on.sin(angle), on.cos(angle)
    offset = place - rest
    return rest + offset * cosine + velocity / rate * sine, velocity * cosine - offset * rate * sine


def _wall_flight(
    pendulums: Pendulums[Number], state: State[Number], wall: Number, on: Arithmetic
) -> Number:
    """Time of the ball to the wall; NaN if it never comes there."""
    _, _, ball, ball_velocity = state
    offset = pendulums.ball_rest - wall
    return _reaches(pendulums.ball_rate, offset, ball - wall, ball_velocity, on)


def _bodies_flight(
    pendulums: Pendulums[Number], state: State[Number], wall: Number, on: Arithmetic
) -> Number:
    """Time until the bodies meet; NaN if they never do."""
    heavy, heavy_velocity, ball, ball_velocity = state
    rest_gap = pendulums.heavy_rest - pendulums.ball_rest
    opening = heavy_velocity - ball_velocity
    time = _reaches(pendulums.heavy_rate, rest_gap, heavy - ball, opening, on)
    for _ in range(NEWTON_STEPS):
        if not on.any(on.isfinite(time)):
            return time
        there = _advance(pendulums, state, time, on)
        closing = there[1] - there[3]
        missing = on.divide(there[0] - there[2], closing)
        time = time - on.where(closing < 0, missing, 0.0 * closing)
    met: Number = on.where(time >= 0, time, time * np.nan)
    return met


def _reaches(rate: Number, rest: Number, gap: Number, opening: Number, on: Arithmetic) -> Number:
    """First time at which a swinging gap, not negative now, falls to zero; NaN if it never does.

    gap(t) = rest + A cos(rate t - phase) falls through zero at rate t = phase + arccos(-rest / A).
    """
    offset, quarter = gap - rest, opening / rate
    phase = on.arctan2(quarter, offset)
    angle = phase + on.arccos(on.divide(-rest, on.hypot(offset, quarter)))
    # A ball that has just left the contact falls through zero one swing later, not now.
    left_now = (angle < -1e-9) | ((gap <= 0) & (gap >= 0) & (opening > 0) & (angle < 1e-9))
    first: Number = on.where(left_now, angle + 2 * np.pi, on.maximum(angle, 0.0 * angle)) / rate
    return first


def _closed_in(wall: Number, state: State[Number], on: Arithmetic) -> State[Number]:
    """Undo the rounding of the last flight, so that bodies do not start inside each other."""
    ball = on.maximum(state[2], wall)
    return on.maximum(state[0], ball), state[1], ball, state[3]


def _off_wall(state: State[Number], restitution: Number) -> State[Number]:
    heavy, heavy_velocity, ball, ball_velocity = state
    return heavy, heavy_velocity, ball, -restitution * ball_velocity


def _off_body(state: State[Number], restitution: Number, lightness: Number) -> State[Number]:
    heavy, heavy_velocity, ball, ball_velocity = state
    # The impulse on the ball is (1 + e) times the relative velocity over 1 + m/M.
    step = (1 + restitution) * (heavy_velocity - ball_velocity) / (1 + lightness)
    return heavy, heavy_velocity - lightness * step, ball, ball_velocity + step

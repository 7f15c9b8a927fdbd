"""The event-driven model: motions of many sets of parameters at once, or of one with derivatives.

`physics.simulator` follows one trial to rounding and through every oddity. A fit needs the same
motion a few thousand times over, with slightly different parameters, and knows what happens next:
bodies, wall, bodies, wall ... So each flight is solved in closed form for equal threads without
air, and with Newton steps from there. The laws are those of the simulator, x'' = -w^2 (x - x0) for
each body and (1 + e) of the relative velocity at a contact; and the air slows the light ball, so
that its swing decays as exp(-c t).

An array operation takes a microsecond however short the array is; a plain number takes a
twentieth of it. So the functions work on either: a scan over thousands of sets has arrays, a fit
follows one motion in plain numbers.

Derivatives are exact, by complex steps: f(x + ih) = f(x) + ih f'(x) for a step h so small that its
square is none (Squire and Trapp 1998). So each event is differentiated by what it depends on, and
the chain of these maps gives the whole motion's derivatives.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from count_video.motion.parameters import FIRST_DEVIATION, Column, deviation_places
from count_video.records import Floats

Number = Any
"""A float, or an array of shape (sets,)."""
State = tuple[Number, Number, Number, Number]
"""Heavy body's place and velocity, then the ball's."""
Laws = tuple[Number, Number, Number, Number, Number]
"""Rate and rest of the heavy body, then rate, decay and rest of the ball."""


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


NEWTON_STEPS = 2
"""From the closed form for equal threads without air; each squares the error."""
LAST_STEP_SHARE = 0.05
"""By a larger share of the flight the last step does not change its time, if the gap closes."""


@dataclass(frozen=True)
class Paths:
    """Motions of all sets; piece k lasts from event k to event k + 1, piece 0 is the start."""

    laws: Floats
    """Rate and rest of the heavy body, then rate, decay and rest of the ball; shape (5, sets)."""
    time: Floats
    """Shape (sets, events + 1): the start of each piece; inf for what never happens."""
    states: Floats
    """Shape (4, sets, events + 1): heavy body's place and velocity, then the ball's."""
    before: Floats
    """Like ``states``, right before the event that starts the piece."""


def follow(sets: Floats, count: int, first_time: float, *, fitted: int | None = None) -> Paths:
    """Follow the motions through ``count`` collisions that alternate, the bodies' first.

    Parameters
    ----------
    sets
        Shape (sets, columns); deviations of the restitution may be left out.
    count
        Number of collisions.
    first_time
        No collision is sought before this time (the model's time 0 may lie after the first).
    fitted
        Of so many collisions the sets have deviations; None for all.
    """
    alone = len(sets) == 1
    on: Any = Numbers if alone else np
    columns = sets[0].tolist() if alone else list(np.ascontiguousarray(sets.T))
    laws = laws_of(columns, on)
    first = _start(columns, laws, first_time, on)
    times: list[Number] = [first_time + 0.0 * columns[0]]
    before, states = [first], [first]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for flight, arrived, left in _events(columns, laws, (first, count, fitted or count), on):
            times.append(times[-1] + flight)
            before.append(arrived)
            states.append(left)
    time = _padded(times, count + 1)[0]
    return Paths(
        np.array(laws).reshape(len(laws), -1),
        np.where(np.isnan(time), np.inf, time),
        _padded(states, count + 1),
        _padded(before, count + 1),
    )


def _padded(rows: Sequence[Number | State], length: int) -> Floats:
    """Rows as an array, shape (1 or 4, sets, length), undefined where the motion has ended."""
    array = np.array(rows, dtype=np.float64)
    padded = np.full((length, *array.shape[1:]), np.nan)
    padded[: len(array)] = array
    return np.moveaxis(padded.reshape(length, 4 if isinstance(rows[0], tuple) else 1, -1), 0, 2)


def laws_of(columns: Sequence[Number], on: Any) -> Laws:
    """Laws of one motion, or of many."""
    rate = on.exp(columns[Column.SWING])
    heavy_rest = columns[Column.HEAVY] + columns[Column.HEAVY_PULL] / (rate * rate)
    ball_rate = rate * on.exp(columns[Column.BALL_SWING])
    decay = ball_rate * on.exp(columns[Column.DAMPING])
    return rate, heavy_rest, ball_rate, decay, columns[Column.BALL_REST]


def _start(columns: Sequence[Number], laws: Laws, time: float, on: Any) -> State:
    """State at the first time: the heavy body on its free path, the ball at rest."""
    velocity = columns[Column.HEAVY_RATE]
    heavy = swung(laws[:2], columns[Column.HEAVY], velocity, time, on)
    return *heavy, columns[Column.BALL_REST], 0.0 * velocity


def _events(
    columns: Sequence[Number], laws: Laws, begin: tuple[State, int, int], on: Any
) -> Iterator[tuple[Number, State, State]]:
    """Yield flight, state on arrival and state after it for each event, while there are any.

    They ``begin`` with a state; so many are asked for, and of so many there are deviations.
    """
    state, count, fitted = begin
    lightness, wall = on.exp(columns[Column.LIGHTNESS]), columns[Column.WALL]
    slowly, by_speed = columns[Column.SPEED] / 2, _by_speed(columns, on)
    deviation = (FIRST_DEVIATION + deviation_places(fitted)).tolist()
    deviation += [len(columns)] * (count - fitted)
    for event in range(count):
        if event:
            # Undo the rounding of the last flight: bodies do not start inside each other.
            ball = on.maximum(state[2], wall)
            state = on.maximum(state[0], ball), state[1], ball, state[3]
        to_wall = event % 2 == 1
        flight = _flight(laws, state, wall, on, to_wall=to_wall)
        if not on.any(on.isfinite(flight)):
            return
        arrived = _advance(laws, state, flight, on)
        restitution = slowly + columns[Column.BOUNCE if to_wall else Column.BODIES]
        if deviation[event] < len(columns):
            restitution = restitution + columns[deviation[event]]
        state = _struck(arrived, lightness, restitution, by_speed, to_wall=to_wall)
        yield flight, arrived, state


def _advance(laws: Sequence[Number], state: Sequence[Number], time: Number, on: Any) -> State:
    """Carry a state over a flight."""
    heavy = swung(laws[:2], state[0], state[1], time, on)
    return *heavy, *slowed(laws[2:], state[2], state[3], time, on)


def swung(
    laws: Sequence[Number], place: Number, velocity: Number, time: Number, on: Any = np
) -> tuple[Number, Number]:
    """Place and velocity, after a time, of a body of some rate and rest."""
    rate, rest = laws
    angle = rate * time
    sine, cosine = on.sin(angle), on.cos(angle)
    offset = place - rest
    return rest + offset * cosine + velocity / rate * sine, velocity * cosine - offset * rate * sine


def slowed(
    laws: Sequence[Number], place: Number, velocity: Number, time: Number, on: Any = np
) -> tuple[Number, Number]:
    """Place and velocity, after a time, of a body of some rate, decay and rest.

    Without its decay, exp(-c t), its distance from the rest is a swing of the same rate.
    """
    rate, decay, rest = laws
    offset = place - rest
    undecayed, change = swung((rate, 0.0), offset, velocity + decay * offset, time, on)
    kept = on.exp(-decay * time)
    return rest + kept * undecayed, kept * (change - decay * undecayed)


def _gap(state: Sequence[Number], wall: Number, *, to_wall: bool) -> tuple[Number, Number]:
    """Gap that closes in the next event, of ball and wall or of the bodies, and its rate."""
    heavy, heavy_velocity, ball, ball_velocity = state
    return (
        (ball - wall, ball_velocity) if to_wall else (heavy - ball, heavy_velocity - ball_velocity)
    )


def _flight(laws: Laws, state: State, wall: Number, on: Any, *, to_wall: bool) -> Number:
    """Time until the next event; NaN if it never comes."""
    rate, rest = (laws[2], laws[4] - wall) if to_wall else (laws[0], laws[1] - laws[4])
    time = _reaches(rate, rest, *_gap(state, wall, to_wall=to_wall), on)
    missing = 0.0 * time
    for _ in range(NEWTON_STEPS):
        if not on.any(on.isfinite(time)):
            return time
        left, opening = _gap(_advance(laws, state, time, on), wall, to_wall=to_wall)
        missing = on.where(opening < 0, on.divide(left, opening), math.nan)
        time = time - missing
    closes = (time >= 0) & (abs(missing) <= LAST_STEP_SHARE * time)
    return on.where(closes, time, time * math.nan)


def _reaches(rate: Number, rest: Number, gap: Number, opening: Number, on: Any) -> Number:
    """First time at which a swinging gap, not negative now, falls to zero; NaN if it never does.

    gap(t) = rest + A cos(rate t - phase) falls through zero at rate t = phase + arccos(-rest / A).
    """
    offset, quarter = gap - rest, opening / rate
    phase = on.arctan2(quarter, offset)
    angle = phase + on.arccos(on.divide(-rest, on.hypot(offset, quarter)))
    # A ball that has just left the contact falls through zero one swing later, not now.
    left_now = (angle < -1e-9) | ((gap <= 0) & (gap >= 0) & (opening > 0) & (angle < 1e-9))
    return on.where(left_now, angle + 2 * np.pi, on.maximum(angle, 0.0 * angle)) / rate


def _by_speed(columns: Sequence[Number], on: Any) -> Number:
    """Change of the restitution by the rate at which a gap closes, which is negative."""
    return on.divide(columns[Column.SPEED], -columns[Column.HEAVY_RATE])


def _struck(
    state: Sequence[Number],
    lightness: Number,
    restitution: Number,
    by_speed: Number,
    *,
    to_wall: bool,
) -> State:
    """State after an event; the restitution is that at no speed, and changes by the speed."""
    heavy, heavy_velocity, ball, ball_velocity = state
    closing = ball_velocity if to_wall else heavy_velocity - ball_velocity
    restitution = restitution + by_speed * closing
    if to_wall:
        return heavy, heavy_velocity, ball, -restitution * ball_velocity
    # The impulse on the ball is (1 + e) times the relative velocity over 1 + m/M.
    step = (1 + restitution) * closing / (1 + lightness)
    return heavy, heavy_velocity - lightness * step, ball, ball_velocity + step


# ---- derivatives ---------------------------------------------------------------------------------

STEP = 1e-30
"""Complex steps are so small that no digit of a value changes, whatever its unit."""


@dataclass(frozen=True)
class Tangents:
    """Derivatives of one motion by its parameters; those of states are at fixed times."""

    inputs: Floats
    """Of what each event depends on: the state at the start of the flight, the laws, the wall, the
    lightness, the restitution and its change by speed; shape (pieces, 13, columns)."""
    by_inputs: Floats
    """Of the state after each event, of that before it and of its time, by what it depends on;
    shape (events, 9, 13)."""

    @property
    def laws(self) -> Floats:
        """Of the laws, shape (5, columns)."""
        return self.inputs[0, 4:9]

    @property
    def states(self) -> Floats:
        """Of the state at the start of each piece, shape (pieces, 4, columns)."""
        return self.inputs[:, :4]

    @property
    def arriving(self) -> Floats:
        """Of the state just before each event, shape (events, 4, columns)."""
        return self.by_inputs[:, 4:8] @ self.inputs[:-1]

    @property
    def time(self) -> Floats:
        """Of the events' times, shape (events, columns)."""
        return np.asarray((self.by_inputs[:, 8:] @ self.inputs[:-1])[:, 0])


def stepped(values: Floats) -> NDArray[np.complex128]:
    """Step each of some values, shape (values, ...), by itself; shape (values, steps, ...)."""
    steps = 1j * STEP * np.eye(len(values))
    return np.asarray(values[:, None] + steps.reshape(*steps.shape, *[1] * (values.ndim - 1)))


def slopes(results: Sequence[Any]) -> Floats:
    """Give derivatives of results of stepped values, shape (results, steps, ...)."""
    return np.array([result.imag for result in results]) / STEP


def tangents_of(paths: Paths, values: Floats) -> Tangents:
    """Differentiate the first motion of ``paths``, whose parameters are ``values``."""
    columns = list(stepped(values))
    laws = laws_of(columns, np)
    inputs = np.zeros((paths.time.shape[1], 13, len(values)))
    inputs[0, :4] = slopes(_start(columns, laws, paths.time[0, 0], np))
    inputs[:, 4:9] = slopes(laws)
    inputs[:, 9, Column.WALL] = 1.0
    inputs[:, 10] = slopes([np.exp(columns[Column.LIGHTNESS])])
    inputs[:, 11, Column.SPEED] = 0.5
    inputs[:, 12] = slopes([_by_speed(columns, np)])
    event = np.arange(len(inputs) - 1)
    places = [np.where(event % 2 == 1, Column.BOUNCE, Column.BODIES)]
    if len(values) > FIRST_DEVIATION:
        places.append(FIRST_DEVIATION + deviation_places(len(event)))
    for place in places:
        inputs[event, 11, place] = 1.0
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        restitution = values[Column.SPEED] / 2 + np.sum([values[place] for place in places], axis=0)
        by_inputs = _event_slopes(paths, values, restitution)
        for number, by in enumerate(by_inputs[:, :4]):
            np.dot(by, inputs[number], out=inputs[number + 1, :4])
    return Tangents(inputs, by_inputs)


def _event_slopes(paths: Paths, values: Floats, restitution: Floats) -> Floats:
    """Differentiate events of one motion by what they depend on, as in ``Tangents``."""
    flights = np.diff(paths.time[0])
    known = (*paths.laws[:, 0], values[Column.WALL], np.exp(values[Column.LIGHTNESS]))
    known_of_all = np.tile(known, (len(flights), 1)).T
    by_speed = np.full(len(flights), _by_speed(values.tolist(), Numbers))
    at = np.vstack([paths.states[:, 0, :-1], known_of_all, restitution, by_speed])
    found = np.empty((len(flights), 9, 13))
    for to_wall in (False, True):
        own = slice(int(to_wall), None, 2)
        inputs = list(stepped(at[:, own]))
        laws = inputs[4:9]
        arrived = _advance(laws, inputs[:4], flights[own], np)
        gap, closing = _gap(arrived, inputs[9], to_wall=to_wall)
        later = -1j * gap.imag / closing.real
        left = _struck(_moved(laws, arrived, later), *inputs[10:], to_wall=to_wall)
        results = (*_moved(laws, left, -later), *arrived, later)
        found[own] = slopes(results).transpose(2, 0, 1)
    return found


def _moved(laws: Sequence[Number], state: Sequence[Number], time: Number) -> State:
    """Carry a state over a time so short that its square is none."""
    rate, rest, ball_rate, decay, ball_rest = laws
    heavy, heavy_velocity, ball, ball_velocity = state
    ball_pull = (ball_rate**2 + decay**2) * (ball_rest - ball) - 2 * decay * ball_velocity
    return (
        heavy + time * heavy_velocity,
        heavy_velocity + time * rate**2 * (rest - heavy),
        ball + time * ball_velocity,
        ball_velocity + time * ball_pull,
    )

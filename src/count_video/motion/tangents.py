"""How a modelled motion changes with its parameters, exactly, in one pass over the events.

A change of a parameter moves a body at a given time by d(t). Within a flight d(t) swings like the
body itself, so that four numbers at its start determine it. At a contact the flight ends earlier
or later by dt = -(change of the gap) / (its closing speed), and what the two bodies then do is
mapped to what they would have done at the old time. Both maps are matrices: the four numbers after
an event are a matrix times those before it, and a term for what the parameters change there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.motion.parameters import FIRST_DEVIATION, Column, deviation_places
from count_video.motion.pendulums import Paths
from count_video.records import Floats


@dataclass(frozen=True)
class Tangents:
    """Derivatives of one motion by its parameters."""

    laws: Floats
    """Of the rate and the rest of the heavy body, then of the ball; shape (4, columns)."""
    time: Floats
    """Of the events' times, shape (events, columns)."""
    states: Floats
    """Of the state at the start of each piece, at a fixed time; shape (pieces, 4, columns)."""
    arriving: Floats
    """Of the state just before each event, at a fixed time; shape (events, 4, columns)."""


def tangents_of(paths: Paths, values: Floats) -> Tangents:
    """Differentiate the first motion of ``paths``, whose parameters are ``values``."""
    laws = _laws(paths, values)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        flown, drift = _flights(paths, laws)
        hits = _hits(paths, values)
        matrix = hits.impact @ flown
        shift = hits.impact @ drift + hits.explicit
        states = np.empty((len(flown) + 1, 4, len(values)))
        states[0] = _start(paths, laws, len(values))
        for by_state, by_law, before, after in zip(
            matrix, shift, states[:-1], states[1:], strict=True
        ):
            np.dot(by_state, before, out=after)
            np.add(after, by_law, out=after)
        arriving = flown @ states[:-1] + drift
        time = (hits.when[:, None] @ arriving)[:, 0] + hits.when_explicit
    return Tangents(laws, time, states, arriving)


@dataclass(frozen=True)
class _Hits:
    """Derivatives at the events; ``when`` of their times, the others of the state after them."""

    impact: Floats
    """By the state before, shape (events, 4, 4)."""
    explicit: Floats
    """By the parameters, shape (events, 4, columns)."""
    when: Floats
    """By the state before, shape (events, 4)."""
    when_explicit: Floats
    """By the parameters, shape (events, columns)."""


def _laws(paths: Paths, values: Floats) -> Floats:
    rate, ball_rate = paths.pendulums.heavy_rate[0], paths.pendulums.ball_rate[0]
    laws = np.zeros((4, len(values)))
    laws[0, Column.SWING] = rate
    laws[1, Column.HEAVY] = 1.0
    laws[1, Column.HEAVY_PULL] = 1 / rate**2
    laws[1, Column.SWING] = -2 * values[Column.HEAVY_PULL] / rate**2
    laws[2, Column.SWING] = laws[2, Column.BALL_SWING] = ball_rate
    laws[3, Column.BALL_REST] = 1.0
    return laws


def _start(paths: Paths, laws: Floats, columns: int) -> Floats:
    """Of the state at the first time, from the heavy body's at time 0; shape (4, columns)."""
    time, pendulums = paths.time[0, :1], paths.pendulums
    heavy, velocity = paths.states[:2, 0, :1]
    rate, rest = pendulums.heavy_rate[0], pendulums.heavy_rest[0]
    sine, cosine = np.sin(rate * time), np.cos(rate * time)
    # The derivative by the rate needs the state at time 0: back from the start.
    offset = (heavy - rest) * cosine - velocity / rate * sine
    at_zero = velocity * cosine + (heavy - rest) * rate * sine
    by_state, by_law = swing_derivatives(rate, offset, at_zero, time)
    start = np.zeros((4, columns))
    start[:2, [Column.HEAVY, Column.HEAVY_RATE]] = by_state[0]
    start[:2] += by_law[0] @ laws[:2]
    start[2, Column.BALL_REST] = 1.0
    return start


def swing_derivatives(
    rate: float | Floats, offset: Floats, velocity: Floats, time: Floats
) -> tuple[Floats, Floats]:
    """Differentiate place and velocity after a time by those before, and by rate and rest.

    ``offset`` is the place less the rest. Both results have shape (..., 2, 2), the result first,
    where ``offset`` has shape (...).
    """
    angle = rate * time
    sine, cosine = np.sin(angle), np.cos(angle)
    by_state, by_law = np.empty((2, *offset.shape, 2, 2))
    by_state[..., 0, 0] = by_state[..., 1, 1] = cosine
    by_state[..., 0, 1], by_state[..., 1, 0] = sine / rate, -rate * sine
    by_law[..., 0, 0] = velocity * (time * cosine - sine / rate) / rate - offset * time * sine
    by_law[..., 1, 0] = -velocity * time * sine - offset * (sine + angle * cosine)
    by_law[..., 0, 1], by_law[..., 1, 1] = 1 - cosine, rate * sine
    return by_state, by_law


def _flights(paths: Paths, laws: Floats) -> tuple[Floats, Floats]:
    """Of the state at the end of each flight: by that at its start, and by the laws."""
    flight, pendulums = np.diff(paths.time[0]), paths.pendulums
    rate = np.stack([pendulums.heavy_rate, pendulums.ball_rate])
    rest = np.stack([pendulums.heavy_rest, pendulums.ball_rest])
    place, velocity = paths.states[::2, 0, :-1], paths.states[1::2, 0, :-1]
    by_state, by_law = swing_derivatives(rate, place - rest, velocity, flight)
    flown = np.zeros((len(flight), 4, 4))
    drift = np.empty((len(flight), 4, laws.shape[1]))
    for body, own in enumerate((slice(0, 2), slice(2, 4))):
        flown[:, own, own] = by_state[body]
        drift[:, own] = by_law[body] @ laws[own]
    return flown, drift


def _hits(paths: Paths, values: Floats) -> _Hits:
    """Differentiate what happens at the events."""
    events, columns = paths.time.shape[1] - 1, len(values)
    before = paths.before[:, 0, 1:]
    on_wall = np.arange(events) % 2 == 1
    when, when_explicit = _when(before, on_wall, columns)
    after_by_before, explicit = _impacts(before, on_wall, values)
    flow, flow_after = _flow(paths, before), _flow(paths, paths.states[:, 0, 1:])
    slip = (after_by_before @ flow[:, :, None])[:, :, 0] - flow_after
    return _Hits(
        impact=after_by_before + slip[:, :, None] * when[:, None, :],
        explicit=explicit + slip[:, :, None] * when_explicit[:, None, :],
        when=when,
        when_explicit=when_explicit,
    )


def _when(before: Floats, on_wall: np.ndarray, columns: int) -> tuple[Floats, Floats]:
    _, heavy_velocity, _, ball_velocity = before
    earlier = -1 / np.where(on_wall, ball_velocity, heavy_velocity - ball_velocity)
    when = np.zeros((len(on_wall), 4))
    when[:, 0] = np.where(on_wall, 0.0, earlier)
    when[:, 2] = np.where(on_wall, earlier, -earlier)
    explicit = np.zeros((len(on_wall), columns))
    explicit[:, Column.WALL] = np.where(on_wall, -earlier, 0.0)
    return when, explicit


def _impacts(before: Floats, on_wall: np.ndarray, values: Floats) -> tuple[Floats, Floats]:
    """Of the state after each impact, at its own time: by the state before, by the parameters."""
    events = len(on_wall)
    _, heavy_velocity, _, ball_velocity = before
    lightness = np.exp(values[Column.LIGHTNESS])
    deviates = len(values) > FIRST_DEVIATION
    place = FIRST_DEVIATION + deviation_places(events)
    restitution = (values[place] if deviates else 0.0) + np.where(
        on_wall, values[Column.BOUNCE], values[Column.BODIES]
    )
    given = np.where(on_wall, 0.0, (1 + restitution) / (1 + lightness))
    matrix = np.zeros((events, 4, 4))
    matrix[:, 0, 0] = matrix[:, 2, 2] = 1.0
    matrix[:, 1, 1] = 1 - lightness * given
    matrix[:, 1, 3] = lightness * given
    matrix[:, 3, 1] = given
    matrix[:, 3, 3] = np.where(on_wall, -restitution, 1 - given)
    closing = heavy_velocity - ball_velocity
    by_restitution = np.where(on_wall, -ball_velocity, closing / (1 + lightness))
    explicit = np.zeros((events, 4, len(values)))
    event = np.arange(events)
    columns = [np.where(on_wall, Column.BOUNCE, Column.BODIES)]
    columns += [place] if deviates else []
    for column in columns:
        explicit[event, 1, column] = np.where(on_wall, 0.0, -lightness * by_restitution)
        explicit[event, 3, column] = by_restitution
    step = given * closing
    explicit[:, 1, Column.LIGHTNESS] = -step * lightness / (1 + lightness)
    explicit[:, 3, Column.LIGHTNESS] = -step * lightness / (1 + lightness)
    return matrix, explicit


def _flow(paths: Paths, states: Floats) -> Floats:
    """Rate of change of states of shape (4, events), shape (events, 4)."""
    laws = paths.pendulums
    flow = np.empty((states.shape[1], 4))
    flow[:, 0], flow[:, 2] = states[1], states[3]
    flow[:, 1] = laws.heavy_rate**2 * (laws.heavy_rest - states[0])
    flow[:, 3] = laws.ball_rate**2 * (laws.ball_rest - states[2])
    return flow

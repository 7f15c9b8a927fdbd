"""How what a camera sees of a modelled motion changes with the motion's parameters.

The ball's path has no jumps, so the mean over an exposure changes by the mean of the path's change,
whichever collisions it holds: the moving ends of the pieces do not matter.
"""

from __future__ import annotations

import numpy as np

from count_video.between.model import Paths
from count_video.between.parameters import Column
from count_video.between.sampling import Moment, Sampled, law_of, moment
from count_video.between.tangents import Tangents, swing_derivatives
from count_video.records import Floats


def sampled_tangents(
    paths: Paths, sampled: Sampled, tangents: Tangents, values: Floats, frame: Floats
) -> tuple[Floats, Floats]:
    """Differentiate ball and heavy body of the first sampled motion by its parameters.

    Both results have shape (frames, columns).
    """
    half = float(values[Column.EXPOSURE]) / 2
    whole = _piece_integrals(paths, tangents)
    opened, closed = moment(paths, (frame - half)[None]), moment(paths, (frame + half)[None])
    swept = _swept(paths, tangents, whole, closed) - _swept(paths, tangents, whole, opened)
    ball = swept / (2 * half)
    ends = _ball_place(paths, opened) + _ball_place(paths, closed)
    ball[:, Column.EXPOSURE] += (ends / 2 - sampled.ball[0]) / (2 * half)
    return ball, _heavy(paths, sampled, tangents, values, frame)


def _heavy(
    paths: Paths, sampled: Sampled, tangents: Tangents, values: Floats, frame: Floats
) -> Floats:
    when = moment(paths, frame[None])
    piece, since = when.piece[0], when.since[0]
    rate, rest = (float(value[0, 0]) for value in law_of(paths, "heavy"))
    place, velocity = paths.states[:2, 0, piece]
    by_state, by_law = swing_derivatives(rate, place - rest, velocity, since)
    heavy = by_state[:, 0, 0, None] * tangents.states[piece, 0]
    heavy += by_state[:, 0, 1, None] * tangents.states[piece, 1]
    heavy += by_law[:, 0] @ tangents.laws[:2]
    parallax = float(values[Column.PARALLAX])
    heavy *= 1 + parallax
    heavy[:, Column.BALL_REST] -= parallax
    heavy[:, Column.CONTACT] += 1.0
    from_rest = sampled.heavy[0] - values[Column.CONTACT] - values[Column.BALL_REST]
    heavy[:, Column.PARALLAX] += from_rest / (1 + parallax)
    return np.asarray(heavy)


def _ball_place(paths: Paths, when: Moment) -> Floats:
    rate, rest = law_of(paths, "ball")
    place, velocity = when.of(paths.states[2]), when.of(paths.states[3])
    angle = rate * when.since
    return np.ravel(rest + (place - rest) * np.cos(angle) + velocity / rate * np.sin(angle))


def _piece_integrals(paths: Paths, tangents: Tangents) -> Floats:
    """Differentiate the integral of the ball's path up to each piece; shape (pieces, columns)."""
    length = np.diff(paths.time, axis=1)
    length = np.where(np.isfinite(length), length, 0.0)
    pieces = np.arange(length.shape[1])[None]
    swept = _swept_in_piece(paths, tangents, Moment(pieces, length))
    return np.concatenate([np.zeros((1, swept.shape[1])), np.cumsum(swept, axis=0)])


def _swept(paths: Paths, tangents: Tangents, whole: Floats, when: Moment) -> Floats:
    return np.asarray(whole[when.piece[0]] + _swept_in_piece(paths, tangents, when))


def _swept_in_piece(paths: Paths, tangents: Tangents, when: Moment) -> Floats:
    """Differentiate the integral of the ball's path since the start of a piece, at fixed times."""
    piece, since = when.piece[0], when.since[0]
    rate, rest = (float(value[0, 0]) for value in law_of(paths, "ball"))
    place, velocity = paths.states[2:, 0, piece]
    sine, cosine = np.sin(rate * since) / rate, np.cos(rate * since)
    risen = 2 * np.sin(rate * since / 2) ** 2 / rate**2
    by_rate = (place - rest) * (since * cosine - sine) / rate
    by_rate += velocity * (since * sine - 2 * risen) / rate
    swept = sine[:, None] * tangents.states[piece, 2]
    swept += risen[:, None] * tangents.states[piece, 3]
    swept += np.stack([by_rate, since - sine], axis=1) @ tangents.laws[2:]
    return np.asarray(swept)

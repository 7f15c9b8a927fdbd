"""What a camera sees of modelled motions: the ball's mean place during each exposure.

A frame in the thick of it may hold several collisions; the mean over the exposure is exact all the
same, from the integral of the path: within a piece in closed form, across pieces by their sums.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.between.model import Paths
from count_video.between.parameters import Column
from count_video.records import Floats


@dataclass(frozen=True)
class Sampled:
    """Modelled places; arrays have shape (sets, frames)."""

    ball: Floats
    """Mean over the exposure."""
    ball_centre: Floats
    """At the middle of the exposure."""
    ball_rate: Floats
    """Velocity there."""
    heavy: Floats
    """At the middle of the exposure, as the outline of the face is measured."""


def sample(paths: Paths, sets: Floats, frame: Floats) -> Sampled:
    """Sample the motions at frame times, shape (frames,), counted from the model's time 0."""
    half = sets[:, Column.EXPOSURE, None] / 2
    whole = _piece_integrals(paths)
    opened = _integral(paths, frame - half, whole)
    closed = _integral(paths, frame + half, whole)
    ball, rate, heavy = _places(paths, frame)
    from_rest = heavy - sets[:, Column.BALL_REST, None]
    outline = sets[:, Column.CONTACT, None] + sets[:, Column.PARALLAX, None] * from_rest
    return Sampled((closed - opened) / (2 * half), ball, rate, heavy + outline)


def _pieces(paths: Paths, time: Floats) -> tuple[np.ndarray, Floats]:
    """Piece that holds each time and the time since its start; shape (sets, times)."""
    starts = paths.time
    rows = zip(starts, time, strict=True)
    piece = np.stack([np.searchsorted(row, when, side="right") for row, when in rows])
    piece = np.maximum(piece - 1, 0)
    return piece, time - np.take_along_axis(starts, piece, axis=1)


def _of_piece(values: Floats, piece: np.ndarray) -> Floats:
    return np.take_along_axis(values, piece, axis=1)


def _places(paths: Paths, frame: Floats) -> tuple[Floats, Floats, Floats]:
    time = np.broadcast_to(frame, (paths.time.shape[0], len(frame)))
    piece, since = _pieces(paths, time)
    heavy, heavy_velocity, ball, ball_velocity = (_of_piece(row, piece) for row in paths.states)
    laws = paths.pendulums
    rate, rest = laws.heavy_rate[:, None], laws.heavy_rest[:, None]
    heavy_now = rest + (heavy - rest) * np.cos(rate * since)
    heavy_now += heavy_velocity / rate * np.sin(rate * since)
    rate, rest = laws.ball_rate[:, None], laws.ball_rest[:, None]
    cosine, sine = np.cos(rate * since), np.sin(rate * since)
    ball_now = rest + (ball - rest) * cosine + ball_velocity / rate * sine
    ball_rate = ball_velocity * cosine - (ball - rest) * rate * sine
    return ball_now, ball_rate, heavy_now


def _swept(paths: Paths, ball: Floats, velocity: Floats, since: Floats) -> Floats:
    """Integral of the ball's path over a time since the start of a piece."""
    laws = paths.pendulums
    rate, rest = laws.ball_rate[:, None], laws.ball_rest[:, None]
    # 1 - cos would lose its digits at small angles; twice the squared sine of half keeps them.
    risen = 2 * np.sin(rate * since / 2) ** 2 / rate**2
    return rest * since + (ball - rest) * np.sin(rate * since) / rate + velocity * risen


def _piece_integrals(paths: Paths) -> Floats:
    """Integral of the ball's path up to the start of each piece; shape (sets, pieces)."""
    length = np.diff(paths.time, axis=1)
    length = np.where(np.isfinite(length), length, 0.0)
    swept = _swept(paths, paths.states[2, :, :-1], paths.states[3, :, :-1], length)
    return np.concatenate([np.zeros((len(swept), 1)), np.cumsum(swept, axis=1)], axis=1)


def _integral(paths: Paths, time: Floats, whole: Floats) -> Floats:
    piece, since = _pieces(paths, time)
    ball, velocity = _of_piece(paths.states[2], piece), _of_piece(paths.states[3], piece)
    return _of_piece(whole, piece) + _swept(paths, ball, velocity, since)

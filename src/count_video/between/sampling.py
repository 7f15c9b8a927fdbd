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

BLUR_MOMENTS = 16


@dataclass(frozen=True)
class Sampled:
    """Modelled places; arrays have shape (sets, frames)."""

    ball: Floats
    """Mean over the exposure."""
    heavy: Floats
    """At the middle of the exposure, as the outline of the face is measured."""


@dataclass(frozen=True)
class Moment:
    """Pieces that hold given times, and the times since their starts; shape (sets, times)."""

    piece: np.ndarray
    since: Floats

    def of(self, values: Floats) -> Floats:
        """Take the pieces' values out of an array of shape (sets, pieces)."""
        return np.take_along_axis(values, self.piece, axis=1)


def sample(paths: Paths, sets: Floats, frame: Floats) -> Sampled:
    """Sample the motions at frame times, shape (frames,), counted from the model's time 0."""
    half = sets[:, Column.EXPOSURE, None] / 2
    whole = _piece_integrals(paths)
    opened = _integral(paths, moment(paths, frame - half), whole)
    closed = _integral(paths, moment(paths, frame + half), whole)
    middle = moment(paths, np.broadcast_to(frame, (len(sets), len(frame))))
    heavy = _place(paths, middle, "heavy")
    from_rest = heavy - sets[:, Column.BALL_REST, None]
    outline = sets[:, Column.CONTACT, None] + sets[:, Column.PARALLAX, None] * from_rest
    return Sampled((closed - opened) / (2 * half), heavy + outline)


def blur_of(paths: Paths, values: Floats, frame: Floats) -> Floats:
    """Give the standard deviation of the ball's place over the exposures of one motion, px.

    Shape (frames,); from some moments of the exposure, as nothing hangs on its last digits.
    """
    share = (np.arange(BLUR_MOMENTS) + 0.5) / BLUR_MOMENTS - 0.5
    times = frame[:, None] + share * values[Column.EXPOSURE]
    places = _place(paths, moment(paths, times.reshape(1, -1)), "ball")
    return np.asarray(places.reshape(times.shape).std(axis=1))


def moment(paths: Paths, time: Floats) -> Moment:
    """Find the pieces that hold times, shape (sets, times)."""
    rows = zip(paths.time, time, strict=True)
    piece = np.stack([np.searchsorted(row, when, side="right") for row, when in rows])
    piece = np.maximum(piece - 1, 0)
    return Moment(piece, time - np.take_along_axis(paths.time, piece, axis=1))


def law_of(paths: Paths, body: str) -> tuple[Floats, Floats]:
    """Rate and rest of a body, ``heavy`` or ``ball``; shape (sets, 1)."""
    laws = paths.pendulums
    if body == "heavy":
        return laws.heavy_rate[:, None], laws.heavy_rest[:, None]
    return laws.ball_rate[:, None], laws.ball_rest[:, None]


def _place(paths: Paths, when: Moment, body: str) -> Floats:
    rate, rest = law_of(paths, body)
    row = 0 if body == "heavy" else 2
    place, velocity = when.of(paths.states[row]), when.of(paths.states[row + 1])
    angle = rate * when.since
    return np.asarray(rest + (place - rest) * np.cos(angle) + velocity / rate * np.sin(angle))


def _swept(paths: Paths, ball: Floats, velocity: Floats, since: Floats) -> Floats:
    """Integral of the ball's path over a time since the start of a piece."""
    rate, rest = law_of(paths, "ball")
    # 1 - cos would lose its digits at small angles; twice the squared sine of half keeps them.
    risen = 2 * np.sin(rate * since / 2) ** 2 / rate**2
    return np.asarray(rest * since + (ball - rest) * np.sin(rate * since) / rate + velocity * risen)


def _piece_integrals(paths: Paths) -> Floats:
    """Integral of the ball's path up to the start of each piece; shape (sets, pieces)."""
    length = np.diff(paths.time, axis=1)
    length = np.where(np.isfinite(length), length, 0.0)
    swept = _swept(paths, paths.states[2, :, :-1], paths.states[3, :, :-1], length)
    return np.concatenate([np.zeros((len(swept), 1)), np.cumsum(swept, axis=1)], axis=1)


def _integral(paths: Paths, when: Moment, whole: Floats) -> Floats:
    ball, velocity = when.of(paths.states[2]), when.of(paths.states[3])
    return when.of(whole) + _swept(paths, ball, velocity, when.since)

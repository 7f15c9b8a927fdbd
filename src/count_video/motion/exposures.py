"""What a camera sees of modelled motions: the ball's mean place during each exposure.

A frame in the thick of it may hold several collisions; the mean over the exposure is exact all the
same, from the integral of the path: within a piece in closed form, across pieces by their sums.

How this changes with the motion's parameters is exact, too. The ball's path has no jumps, so the
mean over an exposure changes by the mean of the path's change, whichever collisions it holds: the
moving ends of the pieces do not matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.motion.parameters import Column
from count_video.motion.pendulums import Paths
from count_video.motion.tangents import Tangents, swing_derivatives
from count_video.records import Floats

BLUR_MOMENTS = 16


@dataclass(frozen=True)
class Sampled:
    """Modelled places; arrays have shape (sets, frames)."""

    ball: Floats
    """Mean over the exposure."""
    heavy: Floats
    """At the middle of the exposure, as the outline of the face is measured."""
    ends: Moment
    """When the exposures begin, and then when they end."""
    middle: Moment
    """When they are half over."""


@dataclass(frozen=True)
class Moment:
    """Pieces that hold given times, and the times since their starts; shape (sets, times)."""

    piece: np.ndarray
    since: Floats

    def part(self, times: slice) -> Moment:
        """Keep some of the times."""
        return Moment(self.piece[:, times], self.since[:, times])

    def of(self, values: Floats) -> Floats:
        """Take the pieces' values out of an array of shape (sets, pieces)."""
        return np.asarray(values[np.arange(len(values))[:, None], self.piece])


def sample(paths: Paths, sets: Floats, frame: Floats) -> Sampled:
    """Sample the motions at times from the model's 0 on, shape (frames,) or (sets, frames)."""
    exposure, frames = sets[:, Column.EXPOSURE, None], frame.shape[-1]
    times = np.broadcast_to(frame, (len(sets), frames))
    every = moment(paths, np.hstack([times - exposure / 2, times + exposure / 2, times]))
    ends, middle = every.part(slice(2 * frames)), every.part(slice(2 * frames, None))
    swept = _integral(paths, ends)
    heavy = _place(paths, middle, "heavy")
    from_rest = heavy - sets[:, Column.BALL_REST, None]
    outline = sets[:, Column.CONTACT, None] + sets[:, Column.PARALLAX, None] * from_rest
    mean = (swept[:, frames:] - swept[:, :frames]) / exposure
    return Sampled(mean, heavy + outline, ends, middle)


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
    return Moment(piece, time - Moment(piece, time).of(paths.time))


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


def _piece_lengths(paths: Paths) -> Floats:
    """Length of each piece but the last, shape (sets, pieces - 1); 0 where it never ends."""
    length = np.diff(paths.time, axis=1)
    return np.where(np.isfinite(length), length, 0.0)


def _integral(paths: Paths, when: Moment) -> Floats:
    """Integral of the ball's path up to given times."""
    ball, velocity = paths.states[2], paths.states[3]
    whole = np.zeros_like(ball)
    lengths = _piece_lengths(paths)
    np.cumsum(_swept(paths, ball[:, :-1], velocity[:, :-1], lengths), axis=1, out=whole[:, 1:])
    return when.of(whole) + _swept(paths, when.of(ball), when.of(velocity), when.since)


def sampled_tangents(
    paths: Paths, sampled: Sampled, tangents: Tangents, values: Floats
) -> tuple[Floats, Floats]:
    """Differentiate ball and heavy body of the first sampled motion by its parameters.

    Both results have shape (frames, columns); in ``SKIP`` is the velocity of all frames.
    """
    exposure, parallax = float(values[Column.EXPOSURE]), float(values[Column.PARALLAX])
    ball = _swept_by(paths, tangents, sampled.ends) / exposure
    first, last = np.split(_place(paths, sampled.ends, "ball")[0], 2)
    ball[:, Column.EXPOSURE] += ((first + last) / 2 - sampled.ball[0]) / exposure
    ball[:, Column.SKIP] = (last - first) / exposure
    piece, since = sampled.middle.piece[0], sampled.middle.since[0]
    rate, rest = (float(value[0, 0]) for value in law_of(paths, "heavy"))
    place, velocity = paths.states[:2, 0, piece]
    by_state, by_law = swing_derivatives(rate, place - rest, velocity, since)
    heavy = (by_state[:, :1] @ tangents.states[piece, :2])[:, 0] + by_law[:, 0] @ tangents.laws[:2]
    angle = rate * since
    heavy[:, Column.SKIP] = velocity * np.cos(angle) - (place - rest) * rate * np.sin(angle)
    heavy *= 1 + parallax
    heavy[:, Column.BALL_REST] -= parallax
    heavy[:, Column.CONTACT] += 1.0
    from_rest = sampled.heavy[0] - values[Column.CONTACT] - values[Column.BALL_REST]
    heavy[:, Column.PARALLAX] += from_rest / (1 + parallax)
    return ball, heavy


def _swept_by(paths: Paths, tangents: Tangents, ends: Moment) -> Floats:
    """Differentiate the integral of the ball's path over each exposure, shape (frames, columns)."""
    opened, closed = np.split(_sweeping(paths, ends), 2)
    first, last = np.split(ends.piece[0], 2)
    across = np.flatnonzero(first != last)
    within = closed - opened
    by_law = within[:, 2:] @ tangents.laws[2:]
    within[across] = closed[across]
    swept = _by_state(within, tangents.states[last]) + by_law
    if len(across):
        # Exposures with collisions in them hold the rest of a piece, and whole ones.
        pieces = np.arange(len(tangents.states) - 1)[None]
        lengths = _sweeping(paths, Moment(pieces, _piece_lengths(paths)))
        whole = np.zeros((len(tangents.states), swept.shape[1]))
        each = _by_state(lengths, tangents.states[:-1]) + lengths[:, 2:] @ tangents.laws[2:]
        np.cumsum(each, axis=0, out=whole[1:])
        first, last = first[across], last[across]
        swept[across] += whole[last] - whole[first]
        swept[across] -= _by_state(opened[across], tangents.states[first])
    return swept


def _by_state(sweeping: Floats, states: Floats) -> Floats:
    """Sum what the ball's state at the start of each piece adds, shape (times, columns)."""
    return np.asarray((sweeping[:, None, :2] @ states[:, 2:])[:, 0])


def _sweeping(paths: Paths, when: Moment) -> Floats:
    """Differentiate the integral of the ball's path since the start of a piece, at fixed times.

    By its place and velocity there, and by the law's rate and rest; shape (times, 4).
    """
    piece, since = when.piece[0], when.since[0]
    rate, rest = (float(value[0, 0]) for value in law_of(paths, "ball"))
    place, velocity = paths.states[2:, 0, piece]
    sine, cosine = np.sin(rate * since) / rate, np.cos(rate * since)
    risen = 2 * np.sin(rate * since / 2) ** 2 / rate**2
    by_rate = (place - rest) * (since * cosine - sine) / rate
    by_rate += velocity * (since * sine - 2 * risen) / rate
    return np.stack([sine, risen, by_rate, since - sine], axis=1)

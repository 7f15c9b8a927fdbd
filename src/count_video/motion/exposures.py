"""What a camera sees of modelled motions: the ball's mean place during each exposure.

A frame in the thick of it may hold several collisions; the mean over the exposure is exact all the
same, from the integral of the path: within a piece in closed form, across pieces by their sums.

How this changes with the motion's parameters is exact, too. The ball's path has no jumps, so the
mean over an exposure changes by the mean of the path's change, whichever collisions it holds: the
moving ends of the pieces do not matter.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from count_video.motion.parameters import Column
from count_video.motion.pendulums import Paths, Tangents, slopes, slowed, stepped, swung
from count_video.records import Floats


class Body(NamedTuple):
    """Where a body's numbers stand."""

    laws: slice
    states: slice


HEAVY, BALL = Body(slice(0, 2), slice(0, 2)), Body(slice(2, 5), slice(2, 4))


@dataclass(frozen=True)
class Flown:
    """A body at some times, in the pieces of its path that hold them; shape (sets, times)."""

    body: Body
    piece: np.ndarray
    laws: tuple[Floats, ...]
    """Shape (sets, 1) each; the last one is the rest."""
    state: tuple[Floats, Floats]
    """Place and velocity at the start of the piece."""
    since: Floats
    """Time since then."""

    def by(self, path: Callable[..., Any]) -> Any:
        """Give what follows by a function of its laws, its state and the time since."""
        return path(self.laws, *self.state, self.since)


@dataclass(frozen=True)
class Sampled:
    """Modelled places; arrays have shape (sets, frames)."""

    ball: Floats
    """Mean over the exposure."""
    heavy: Floats
    """At the middle of the exposure, as the outline of the face is measured."""
    pieces: Flown
    """The ball at the ends of all pieces but the last."""
    ends: tuple[Flown, Flown]
    """The ball where the exposures begin, and where they end."""
    middle: Flown
    """The heavy body where they are half over."""


def sample(paths: Paths, sets: Floats, frame: Floats) -> Sampled:
    """Sample the motions at times from the model's 0 on, shape (frames,) or (sets, frames)."""
    exposure = sets[:, Column.EXPOSURE, None]
    times = np.broadcast_to(frame, (len(sets), frame.shape[-1]))
    pieces = _pieces(paths)
    ends = flown(paths, BALL, times - exposure / 2), flown(paths, BALL, times + exposure / 2)
    middle = flown(paths, HEAVY, times)
    whole = _before(pieces.by(_swept))
    first, last = (_taken(whole, one.piece) + one.by(_swept) for one in ends)
    heavy, _ = middle.by(swung)
    from_rest = heavy - sets[:, Column.BALL_REST, None]
    outline = sets[:, Column.CONTACT, None] + sets[:, Column.PARALLAX, None] * from_rest
    return Sampled((last - first) / exposure, heavy + outline, pieces, ends, middle)


def flown(paths: Paths, body: Body, time: Floats) -> Flown:
    """Find the pieces that hold times, shape (sets, times)."""
    rows = zip(paths.time, time, strict=True)
    piece = np.stack([np.searchsorted(row, when, side="right") for row, when in rows])
    piece = np.maximum(piece - 1, 0)
    return _within(paths, body, piece, time - _taken(paths.time, piece))


def _pieces(paths: Paths) -> Flown:
    length = np.diff(paths.time, axis=1)
    piece = np.broadcast_to(np.arange(length.shape[1]), length.shape)
    return _within(paths, BALL, piece, np.where(np.isfinite(length), length, 0.0))


def _within(paths: Paths, body: Body, piece: np.ndarray, since: Floats) -> Flown:
    place, velocity = (_taken(one, piece) for one in paths.states[body.states])
    return Flown(body, piece, tuple(paths.laws[body.laws, :, None]), (place, velocity), since)


def _taken(values: Floats, piece: np.ndarray) -> Floats:
    return np.asarray(values[np.arange(len(piece))[:, None], piece])


def _before(pieces: Floats) -> Floats:
    """Sum over all pieces before each, along the second of the axes."""
    return np.concatenate([np.zeros_like(pieces[:, :1]), np.cumsum(pieces, axis=1)], axis=1)


def _swept(laws: Sequence[Any], place: Any, velocity: Any, since: Any) -> Any:
    """Integrate the ball's place from the start of a piece on.

    Its distance from its rest is exp(-c t) (a cos(w t) + b sin(w t)).
    """
    rate, decay, rest = laws
    angle, kept, squares = rate * since, np.exp(-decay * since), rate**2 + decay**2
    # 1 - exp(-c t) cos(w t) would lose its digits at small angles; these terms of it keep them.
    gone = 2 * kept * np.sin(angle / 2) ** 2 - np.expm1(-decay * since)
    sine = kept * np.sin(angle)
    offset = place - rest
    swept = offset * (decay * gone + rate * sine)
    swept += (velocity + decay * offset) / rate * (rate * gone - decay * sine)
    return rest * since + swept / squares


def sampled_tangents(sampled: Sampled, tangents: Tangents, values: Floats) -> tuple[Floats, Floats]:
    """Differentiate ball and heavy body of the first sampled motion by its parameters.

    Both results have shape (frames, columns); in ``SKIP`` is the velocity of all frames.
    """
    exposure, parallax = float(values[Column.EXPOSURE]), float(values[Column.PARALLAX])
    whole = _before(_by_parameters(_swept, sampled.pieces, tangents)[None])[0]
    first, last = (
        whole[end.piece[0]] + _by_parameters(_swept, end, tangents) for end in sampled.ends
    )
    begun, ended = (end.by(slowed)[0][0] for end in sampled.ends)
    ball = (last - first) / exposure
    ball[:, Column.EXPOSURE] += ((begun + ended) / 2 - sampled.ball[0]) / exposure
    ball[:, Column.SKIP] = (ended - begun) / exposure
    middle = sampled.middle
    heavy = _by_parameters(_place, middle, tangents)
    heavy[:, Column.SKIP] = middle.by(swung)[1][0]
    heavy *= 1 + parallax
    heavy[:, Column.BALL_REST] -= parallax
    heavy[:, Column.CONTACT] += 1.0
    from_rest = sampled.heavy[0] - values[Column.CONTACT] - values[Column.BALL_REST]
    heavy[:, Column.PARALLAX] += from_rest / (1 + parallax)
    return ball, heavy


def _by_parameters(path: Callable[..., Any], at: Flown, tangents: Tangents) -> Floats:
    """Differentiate a path of the first motion at some times, shape (times, columns)."""
    *laws, rest = (one[0] for one in at.laws)
    (place, velocity), since = (one[0] for one in at.state), at.since[0]
    by_steps = slopes([path([*stepped(np.array(laws)), rest], place, velocity, since)])[0]
    # It is linear in the others: the factor of each is what it gives where that one is 1 alone.
    rest, place, velocity = np.eye(3)[:, :, None]
    by_rest, by_place, by_velocity = path([*laws, rest], place, velocity, since)
    by_laws = np.stack([*by_steps, by_rest], axis=1) @ tangents.laws[at.body.laws]
    by_state = np.stack([by_place, by_velocity], axis=1)[:, None]
    return np.asarray(by_laws + (by_state @ tangents.states[at.piece[0], at.body.states])[:, 0])


def _place(laws: Sequence[Any], place: Any, velocity: Any, since: Any) -> Any:
    return swung(laws, place, velocity, since)[0]

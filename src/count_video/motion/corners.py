r"""Whether a path turns round by an impact or smoothly: one ratio of likelihoods for each turn.

    place                                      slope that an impact adds
     |\        /\        corners: the           |          ________
     | \      /  \       velocity jumps         |         /
     |  \    /    \      within a contact       |        /  half a contact to
     |   \__/      \                            |_______/   either side
     +-----------------> frame                  +-----------------> frame

To the law of a free body an impact adds the corner. Given its time and that of the contact all is
linear, and the evidence has a closed form (normal and inverse gamma priors: Bishop 2006, section
3.5). The formula, and what an impact is compared with, stand in docs/architecture.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.motion.errors_of_places import HALF_EXPOSURE
from count_video.motion.flight import Motion
from count_video.motion.priors import (
    CONTACT_PICTURES,
    CONTACT_SHARE,
    NO_BOUNCE,
    NOISE_KNOWN,
    TIME_MOVES_FRAMES,
    TURNS,
)
from count_video.records import Floats

HALF_CONTACTS = CONTACT_PICTURES * 2 ** (np.arange(-11.0, 1.0) / 2)
"""Half the times of a contact, in pictures, that are tried."""
LONGER_AT_MOST, PICTURES = 2.0, 6.0
"""Of two flights the longer one counts to this factor of the shorter, or for so many pictures."""
FINER, STEPS = (1.0, 0.2, 0.04), np.linspace(-1.0, 1.0, 13)
"""The time of a corner is sought in these steps within its reach, which are made finer."""
DEGREE_AT_MOST, ROWS_A_DEGREE = 11, 6
"""Polynomials of a path that a hand leads: up to the third one they resemble free flights."""
RESTITUTION_AT_MOST = 2.0
"""No body leaves a stop faster than it came; few pictures show its velocities to half of them."""
CERTAIN_LOG_ODDS = 9.0
"""An impact is as good as certain by its own shape."""
FLAT = 1e-9
"""Less curved evidence says nothing of the time."""
FAR = -36.0
"""Standard deviations beyond which ``erfc`` is hardly a number any more."""


@dataclass(frozen=True)
class Turn:
    """A turn of the path, which may be an impact."""

    side: int
    """-1 at smaller places, +1 at larger places."""
    frame: float
    """The outermost sample, or the middle of the pictures next to it that do not show the body."""
    unseen: float
    """How many pictures next to it do not show the body."""


@dataclass(frozen=True)
class Impact:
    """A turn taken for an impact of a body on a stop; times in pictures."""

    side: int
    """-1 for a stop at smaller places, +1 for one at larger places."""

    log_odds: float
    """Logarithm of the probability that the turn is an impact over that it is none."""
    by_contact: Floats
    """Log evidence for each of ``HALF_CONTACTS`` that is possible, shape (contacts,)."""
    frame: float
    place_px: float
    before: float
    """Velocity along the direction in which places are measured, in px per picture."""
    after: float
    pictures: int
    """How many show the body clear of the contact, on the side where fewer do."""
    chance: float
    """Probability that it is an impact."""

    @property
    def likely(self) -> bool:
        """Whether it is more probably an impact than not."""
        return self.chance > 0.5


def weigh(
    motion: Motion, turn: Turn, limits: tuple[float, float], flight: float, touching: float
) -> Impact:
    """Weigh whether a turn is an impact.

    Parameters
    ----------
    limits
        Frames of the impacts before and after it, if there are any.
    flight
        How many pictures usually lie between impacts: contacts are brief beside it.
    touching
        Half the time in pictures for which the impacts at the limits show.
    """
    path = _Path(motion, _rows_about(motion, turn, limits, (flight, touching)), turn.frame)
    longest, reach = HALF_EXPOSURE + CONTACT_SHARE * flight, TIME_MOVES_FRAMES + turn.unseen / 2
    half = HALF_CONTACTS[longest >= HALF_CONTACTS]
    evidence, times, values = _sought(path, half, reach, -turn.side)
    impact = np.logaddexp.reduce(evidence) - np.log(len(half))
    smooth, misplaced, *led = (path.evidence(one)[0][0] for one in path.without_impact())
    others = np.array([smooth, np.logaddexp.reduce(led) - np.log(len(led)), misplaced])
    shares = np.log(TURNS)
    odds = float(impact + shares[0] - np.logaddexp.reduce(others + shares[1:]))
    best = int(np.argmax(evidence))
    before, after, place = path.ends(values[best], times[best], half[best])
    clear = np.abs(path.time - times[best]) > half[best]
    sides = path.time[clear] > times[best]
    arrives, leaves = turn.side * before, -turn.side * after
    if not 0 < leaves < RESTITUTION_AT_MOST * arrives:
        odds = min(odds, NO_BOUNCE)
    return Impact(
        side=turn.side,
        log_odds=odds,
        by_contact=evidence,
        frame=turn.frame + float(times[best]),
        place_px=place,
        before=before,
        after=after,
        pictures=min(int(sides.sum()), int((~sides).sum())),
        chance=float(chance_of(odds)),
    )


def chance_of(log_odds: Floats | float) -> Floats:
    """Probability of what has such odds, the logarithm of which is given."""
    return np.asarray(np.exp(-np.logaddexp(0.0, -log_odds)))


def _rows_about(
    motion: Motion, turn: Turn, limits: tuple[float, float], lengths: tuple[float, float]
) -> NDArray[np.intp]:
    """Rows of both flights next to a turn, neither much longer than the other or than usual."""
    flight, touching = lengths
    rows = np.flatnonzero(motion.moving)
    time = motion.frame[rows] - turn.frame
    before = min(turn.frame - limits[0] - touching, -float(time[0]))
    after = min(limits[1] - touching - turn.frame, float(time[-1]))
    most = max(min(LONGER_AT_MOST * min(before, after), flight), PICTURES)
    inside = (time >= -min(before, most)) & (time <= min(after, most))
    return np.asarray(rows[inside | (np.abs(time) == np.abs(time).min())])


def _sought(path: _Path, half: Floats, reach: float, sign: int) -> tuple[Floats, Floats, Floats]:
    """Seek the time of a corner for each half contact, shape (m,), within a reach of the turn.

    Returns its evidence, its time, and its coefficients. ``sign`` is that of its jump.
    """
    every, best = np.arange(len(half)), np.zeros(len(half))
    for finer in FINER:
        times = np.clip(best[:, None] + finer * reach * STEPS, -reach, reach)
        columns = path.corners(times.ravel(), np.repeat(half, len(STEPS)))
        log, values = path.evidence(columns, sign)
        log = log.reshape(times.shape)
        at = np.argmax(log, axis=1)
        best = times[every, at]
    # About its peak the evidence is a normal density of the time (Laplace).
    inner = np.clip(at, 1, len(STEPS) - 2)
    bend = 2 * log[every, inner] - log[every, inner - 1] - log[every, inner + 1]
    step = FINER[-1] * reach * (STEPS[1] - STEPS[0])
    width = step * np.sqrt(2 * np.pi / np.maximum(bend, FLAT))
    found = log[every, at] + np.log(np.minimum(width / (2 * reach), 1.0))
    return found, best, values.reshape(*times.shape, -1)[every, at]


def _log_normal(x: Floats) -> Floats:
    """Logarithm of the probability that a standard normal value is below x, shape (m,).

    As ``scipy.special.log_ndtr``, whose library takes as much memory and time to load as a short
    clip. Where ``erfc`` would underflow its first asymptotic term serves, right to 1e-3 there.
    """
    far = -x
    tail = -(far**2) / 2 - np.log(np.maximum(far, 1.0) * np.sqrt(2 * np.pi))
    near = np.array([math.erfc(one / math.sqrt(2)) for one in np.minimum(far, -FAR).tolist()])
    return np.where(x < FAR, tail, np.log(near / 2))


class _Path:
    """Rows of a path, n in all, and the terms of the law that it may obey."""

    def __init__(self, motion: Motion, rows: NDArray[np.intp], origin: float) -> None:
        self.motion, self.time = motion, motion.frame[rows] - origin
        self.place = (motion.place_px[rows] - motion.middle_px) / motion.sigma_px
        grid = np.arange(self.time[0], self.time[-1] + 1.0)
        summed = np.cumsum(np.cumsum(np.interp(grid, self.time, self.place)))
        # The second difference of the sums before a row is the place there.
        summed = np.interp(self.time - 1.0, grid, summed, left=0.0) * motion.sigma_px
        self.law = np.stack([np.ones_like(self.time), self.time, self.time**2 / 2, -summed], 1)
        self.scales = np.array(
            [motion.way_px, motion.speed, motion.acceleration_sigma, motion.swing_sigma]
        )
        # The priors are rows of their own: each coefficient is 0 but for its standard deviation.
        scaled = self.law * self.scales / motion.sigma_px
        self.basis, self.triangle = np.linalg.qr(np.concatenate([scaled, np.eye(4)]))
        fall = motion.acceleration * self.law[:, 2] / motion.sigma_px
        self.target = np.concatenate([self.place - fall, np.zeros(4)])
        # What the law leaves over of the places.
        self.left = self.target - self.basis @ (self.basis.T @ self.target)

    def corners(self, at: Floats, half: Floats) -> Floats:
        """Give corners at some times, each rounded off for so long, shape (m, n, columns).

        The last column is the corner. Friction turns round with the body: where there is any, the
        first column is another acceleration from there on.
        """
        time, half = self.time - at[:, None], half[:, None]
        rounded = np.clip(time + half, 0.0, 2 * half) ** 2 / (4 * half)
        corner = self.motion.speed * (rounded + np.maximum(time - half, 0.0))
        if not self.motion.friction:
            return corner[:, :, None]
        friction = self.motion.friction * np.maximum(time, 0.0) ** 2 / 2
        return np.stack([friction, corner], axis=2)

    def without_impact(self) -> list[Floats]:
        """Give the law alone, with an error of the outermost picture, and polynomials.

        These have each degree and no law bends them. Shapes (1, n, columns).
        """
        nothing = np.empty((1, len(self.time), 0))
        error = self.motion.way_px * (np.abs(self.time) == np.abs(self.time).min())
        most = min(DEGREE_AT_MOST, 4 + len(self.time) // ROWS_A_DEGREE)
        middle, half = (self.time[-1] + self.time[0]) / 2, (self.time[-1] - self.time[0]) / 2
        basis = np.polynomial.legendre.legvander((self.time - middle) / max(half, 1.0), most)
        led = [basis[None, :, 3 : degree + 1] for degree in range(4, most + 1)]
        return [nothing, error[None, :, None], *(self.motion.way_px * columns for columns in led)]

    def evidence(self, columns: Floats, sign: int = 0) -> tuple[Floats, Floats]:
        """Log evidence of columns besides the law, shape (m, n, k), and their coefficients, (m, k).

        The coefficients are expected to be 0, but for a standard deviation of 1. With a sign, only
        coefficients of the last column that have it are possible.
        """
        added = np.zeros((len(columns), len(self.target), columns.shape[2]))
        added[:, : len(self.time)] = columns / self.motion.sigma_px
        added -= self.basis @ (self.basis.T @ added)
        inner = np.swapaxes(added, 1, 2) @ added + np.eye(columns.shape[2])
        projected = self.left @ added
        values = np.linalg.solve(inner, projected[:, :, None])[:, :, 0]
        squares = self.left @ self.left - np.sum(projected * values, axis=1) + NOISE_KNOWN
        freedom = len(self.time) + NOISE_KNOWN
        log = -np.linalg.slogdet(inner)[1] / 2 - freedom / 2 * np.log(squares)
        if sign:
            sigma = np.sqrt(np.linalg.inv(inner)[:, -1, -1] * squares / freedom)
            log += np.log(2) + _log_normal(sign * values[:, -1] / sigma)
        return log, values

    def ends(self, values: Floats, time: float, half: float) -> tuple[float, float, float]:
        """Velocities before and after a corner, and the place there, by the fitted law."""
        rest = self.target.copy()
        added = self.corners(np.array([time]), np.array([half]))[0] @ values
        rest[: len(self.time)] -= added / self.motion.sigma_px
        law = np.linalg.solve(self.triangle, self.basis.T @ rest) * self.scales
        path = self.law @ law + self.motion.acceleration * self.law[:, 2]
        # Between the rows it is the parabola through the nearest ones.
        nearest = np.sort(np.argsort(np.abs(self.time - time))[:5])
        order = min(2, len(nearest) - 1)
        smooth = np.polynomial.Polynomial.fit(self.time[nearest], path[nearest], order)
        low, here, high = smooth(np.array([time - 0.5, time, time + 0.5])).tolist()
        after = high - low + self.motion.speed * float(values[-1])
        return high - low, after, here + self.motion.middle_px

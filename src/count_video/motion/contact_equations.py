"""The equations of one contact: the places next to it, and what they are made of.

With s the time since the contact, and G the measured places integrated twice, a body's path is

    x(s) = p + v s + a s^2 / 2 - b G(s) + j max(s, 0) + c max(s, 0)^2 / 2,

of which docs/architecture.md says more.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from count_video.motion.errors_of_places import WINDOW_FRAMES, Errors
from count_video.motion.flight import Motion
from count_video.motion.priors import TIME_MOVES_FRAMES
from count_video.records import Floats
from count_video.signals import integral

BEND_CHANGES = 3.0
"""An acceleration changes at a contact by up to so many times what those of the flights scatter:
hands and slopes act on one side only."""
VELOCITY, ACCELERATION, JUMP, WIDTH = 1, 2, 4, 6
"""Columns of each body: p, v, a and b; then what changes at the contact: v, and a by little."""


class Body(NamedTuple):
    """One body's path, at which contacts its velocity jumps, shape (contacts,), and when else."""

    motion: Motion
    errors: Errors | None
    sigma_px: float
    jumps: NDArray[np.bool_]
    ends: Floats


class Equations:
    """The equations of one contact: of the n places next to it, in their standard deviations.

    Coefficients count in standard deviations of their priors: of a body that does not take part
    those of what changes have none, and stay 0. The last one is by how much the contact is later.
    """

    def __init__(self, bodies: Sequence[Body], times: Floats, number: int, touching: float) -> None:
        jumps = np.array([body.jumps[number] for body in bodies], dtype=np.float64)
        scales = [_scales(body.motion, jump) for body, jump in zip(bodies, jumps, strict=True)]
        self.scale = np.array([*np.concatenate(scales), TIME_MOVES_FRAMES])
        self.prior, self.wanted = np.eye(len(self.scale)), np.zeros(len(self.scale))
        self.sign = jumps * (np.array([-1.0, 1.0]) if jumps.sum() > 1 else 1.0)
        rows = [_near(body, times, number, touching) for body in bodies]
        self.middle_px = np.array([place.mean() if len(place) else 0.0 for _, place in rows])
        self.shown = np.array([[(t < 0).any(), (t >= 0).any()] for t, _ in rows]).T
        self.shown |= self.shown.any(axis=0) & (jumps == 0)
        ends = np.cumsum([0, *(len(since) for since, _ in rows)]).tolist()
        self.place, self.errors = np.zeros(ends[-1]), np.eye(ends[-1])
        self.design = np.zeros((ends[-1], len(self.scale)))
        own = [slice(*pair) for pair in pairwise(ends)]
        for k, (body, (since, place)) in enumerate(zip(bodies, rows, strict=True)):
            first, away = WIDTH * k, place - self.middle_px[k]
            self.place[own[k]] = away / body.sigma_px
            law = _law(since, away) * scales[k] / body.sigma_px
            self.design[own[k], first : first + WIDTH] = law
            usual = body.motion.acceleration / scales[k][ACCELERATION]
            self.wanted[first + ACCELERATION] = usual
            if body.errors is not None:
                self.errors[own[k], own[k]] = body.errors.covariance_of(since) / body.sigma_px**2
        # Taken for right, the time gives the jumps; by these a later one changes what follows.
        jump = (self.solved() * self.scale)[JUMP:-1:WIDTH]
        for k, (body, (since, _)) in enumerate(zip(bodies, rows, strict=True)):
            later = -jump[k] * (since > 0) / body.sigma_px
            self.design[own[k], -1] = later * TIME_MOVES_FRAMES

    def touch(self, values: Floats) -> Floats:
        """How the ball's place, or the bodies' distance, at the contact depends on the values.

        They move on until they touch.
        """
        touch = np.zeros(len(values))
        touch[:-1:WIDTH] = self.sign
        touch[-1] = self.sign @ (values * self.scale)[VELOCITY:-1:WIDTH]
        return np.asarray(touch * self.scale)

    def touch_px(self, values: Floats) -> float:
        """Place of the ball, or distance of the bodies, where they touch."""
        return float(self.touch(values) @ values + self.sign @ self.middle_px)

    def hold(self, level_px: float, sigma_px: float, values: Floats) -> None:
        """Add that the bodies touch at a place; ``values`` give their velocities."""
        self.prior = np.vstack([self.prior, self.touch(values) / sigma_px])
        level = (level_px - self.sign @ self.middle_px) / sigma_px
        self.wanted = np.append(self.wanted, level)

    def solved(self, weight: Floats | float = 1.0) -> Floats:
        """Least squares with weights of the places, shape (places,); shape (columns,)."""
        weighted = (weight * self.design.T).T
        hessian = weighted.T @ self.design + self.prior.T @ self.prior
        gradient = weighted.T @ self.place + self.prior.T @ self.wanted
        return np.asarray(np.linalg.solve(hessian, gradient))

    def covariance(self, weight: Floats) -> Floats:
        """Covariance of the values, shape (columns, columns), by what lasts of the errors."""
        weighted, known = weight[:, None] * self.design, self.prior.T @ self.prior
        inverse = np.linalg.inv(weighted.T @ self.design + known)
        return np.asarray(inverse @ (weighted.T @ self.errors @ weighted + known) @ inverse)


def _near(body: Body, times: Floats, number: int, touching: float) -> tuple[Floats, Floats]:
    """Frames since a contact, and places, of a body in its flights next to it."""
    time, jumps = float(times[number]), bool(body.jumps[number])
    others = times[body.jumps & (np.arange(len(times)) != number)]
    others = np.append(others, body.ends)
    low = float(others[others < time].max(initial=-np.inf)) + touching
    high = float(others[others > time].min(initial=np.inf)) - touching
    free = touching if jumps else 0.0
    frame, place_px = body.motion.frame, body.motion.place_px
    near = np.isfinite(place_px) & (np.abs(frame - time) < WINDOW_FRAMES)
    near &= (frame > low) & (frame < high) & ((frame < time - free) | (frame >= time + free))
    return frame[near] - time, place_px[near]


def _scales(motion: Motion, jumps: float) -> Floats:
    """Give the standard deviations of a body's coefficients, shape (WIDTH,)."""
    bend, speed = motion.acceleration_sigma, motion.speed
    changes = jumps * 2 * speed, jumps * BEND_CHANGES * bend
    return np.array([motion.way_px, speed, bend, motion.swing_sigma, *changes])


def _law(since: Floats, place: Floats) -> Floats:
    """Give the columns that a path next to a contact is made of, shape (n, WIDTH).

    For the swing, minus the double integral of the places, 0 with its slope at the contact.
    """
    if len(since) == 0:
        return np.empty((0, WIDTH))
    once = integral(since, place)
    twice = integral(since, once - np.interp(0.0, since, once))
    fallen, later = np.interp(0.0, since, twice) - twice, np.maximum(since, 0.0)
    columns = (np.ones(len(since)), since, since**2 / 2, fallen, later, later**2 / 2)
    return np.stack(columns, axis=1)

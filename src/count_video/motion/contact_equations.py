"""The equations of one contact: the places next to it, and what they are made of.

See ``contacts`` for the law.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

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
LAW = 4
"""Columns of a flight: p, v, a and b; then what changes at the contact: v, and a by little."""


@dataclass(frozen=True)
class Body:
    """One body's path, and the contacts at which its velocity jumps."""

    frame: Floats
    place_px: Floats
    motion: Motion
    errors: Errors | None
    sigma_px: float
    jumps: NDArray[np.bool_]
    """Whether each contact is one of this body, shape (contacts,)."""


@dataclass(frozen=True)
class Side:
    """What one body shows of one contact: n of its places next to it, and their design."""

    body: Body
    jumps: bool
    since: Floats
    """Frames since the contact, shape (n,)."""
    place: Floats
    """Shape (n,), from ``middle_px``."""
    middle_px: float
    design: Floats
    """Shape (n, columns)."""
    mean: Floats
    scales: Floats
    """Prior of the columns, shape (columns,) each."""
    shown: NDArray[np.bool_]
    """Whether there are places before, and after the contact, shape (2,)."""

    @classmethod
    def of(cls, body: Body, times: Floats, number: int, touching: float) -> Side:
        """Choose and describe the places of a body next to a contact."""
        time, jumps, motion = float(times[number]), bool(body.jumps[number]), body.motion
        others = times[body.jumps & (np.arange(len(times)) != number)]
        low = float(others[others < time].max(initial=-np.inf)) + touching
        high = float(others[others > time].min(initial=np.inf)) - touching
        free = touching if jumps else 0.0
        seen = np.isfinite(body.place_px) & (np.abs(body.frame - time) < WINDOW_FRAMES)
        before = seen & (body.frame > low) & (body.frame < time - free)
        after = seen & (body.frame >= time + free) & (body.frame < high)
        near = [np.flatnonzero(flight) for flight in (before, after)]
        rows, shown = np.concatenate(near), np.array([len(one) > 0 for one in near])
        since, place = body.frame[rows] - time, body.place_px[rows]
        middle = float(place.mean()) if len(rows) else 0.0
        flight = [np.ones(len(rows)), since, since**2 / 2, _fallen(since, place - middle)]
        scales = [motion.way_px, motion.speed, motion.acceleration_sigma, motion.swing_sigma]
        if jumps:
            later = np.maximum(since, 0.0)
            flight += [later, later**2 / 2]
            scales += [2 * motion.speed, BEND_CHANGES * motion.acceleration_sigma]
        mean = np.zeros(len(scales))
        mean[2] = motion.acceleration
        return cls(
            body, jumps, since, place - middle, middle, np.stack(flight, 1), mean,
            np.array(scales), shown if jumps else np.full(2, shown.any()),
        )  # fmt: skip


class Equations:
    """The equations of one contact: of all places next to it in sigmas, and of the priors.

    The last column is by how much the contact is later.
    """

    def __init__(self, sides: Sequence[Side]) -> None:
        self.sides = sides
        ends = np.cumsum([0, *(len(side.mean) for side in sides)]).tolist()
        self.columns = [slice(*pair) for pair in pairwise(ends)]
        ends = np.cumsum([0, *(len(side.since) for side in sides)]).tolist()
        self.rows = [slice(*pair) for pair in pairwise(ends)]
        scales = np.concatenate([*(side.scales for side in sides), [TIME_MOVES_FRAMES]])
        mean = np.concatenate([*(side.mean for side in sides), [0.0]])
        self.prior, self.wanted = np.diag(1 / scales), mean / scales
        self.place = np.concatenate([side.place / side.body.sigma_px for side in sides])
        self.design = np.zeros((len(self.place), len(scales)))
        self._touch = np.zeros(len(scales))
        self._offset_px = 0.0
        touching = [side.jumps for side in sides]
        for k, side in enumerate(sides):
            self.design[self.rows[k], self.columns[k]] = side.design / side.body.sigma_px
            if side.jumps:
                sign = -1.0 if k == 0 and sum(touching) > 1 else 1.0
                self._touch[self.columns[k].start] = sign
                self._offset_px += sign * side.middle_px

    def let_time_move(self, values: Floats) -> None:
        """Fill in the last column, given the other parameters, shape (columns,)."""
        for side, rows, columns in zip(self.sides, self.rows, self.columns, strict=True):
            if side.jumps:
                jump = values[columns][LAW]
                self.design[rows, -1] = -jump * (side.since > 0) / side.body.sigma_px

    def touch(self, values: Floats) -> Floats:
        """How the ball's place, or the bodies' distance, at the contact depends on the parameters.

        They move on until they touch: their velocities stand next to their places.
        """
        touch = self._touch.copy()
        touch[-1] = touch[:-2] @ values[1:-1]
        return touch

    def touch_px(self, values: Floats) -> float:
        """Place of the ball, or distance of the bodies, where they touch."""
        return float(self.touch(values) @ values) + self._offset_px

    def hold(self, level_px: float, sigma_px: float, values: Floats) -> None:
        """Add that the bodies touch at a place; ``values`` give their velocities."""
        self.prior = np.vstack([self.prior, self.touch(values) / sigma_px])
        self.wanted = np.append(self.wanted, (level_px - self._offset_px) / sigma_px)

    def solved(self, weight: Floats | float = 1.0) -> Floats:
        """Least squares with weights of the places, shape (places,); shape (columns,)."""
        weighted = (weight * self.design.T).T
        gradient = weighted.T @ self.place + self.prior.T @ self.wanted
        scale, unit = self._scaled(weighted)
        return np.asarray(np.linalg.solve(unit, gradient * scale) * scale)

    def covariance(self, weight: Floats) -> Floats:
        """Covariance of the parameters, shape (columns, columns), by what lasts of the errors."""
        weighted, total = weight[:, None] * self.design, self.prior.T @ self.prior
        scale, unit = self._scaled(weighted)
        inverse = np.linalg.inv(unit) * scale[:, None] * scale
        for side, rows in zip(self.sides, self.rows, strict=True):
            summed, errors = weighted[rows], side.body.errors
            if errors is None:
                total = total + summed.T @ summed
            else:
                covariance = errors.covariance_of(side.since) / side.body.sigma_px**2
                total = total + summed.T @ covariance @ summed
        return np.asarray(inverse @ total @ inverse)

    def _scaled(self, weighted: Floats) -> tuple[Floats, Floats]:
        """Scale of the columns, and the Hessian with a unit diagonal: their units differ much."""
        hessian = weighted.T @ self.design + self.prior.T @ self.prior
        scale = 1 / np.sqrt(np.diag(hessian))
        return scale, hessian * scale[:, None] * scale


def _fallen(since: Floats, place: Floats) -> Floats:
    """Minus the double integral of places, 0 with its slope at the contact; shape (n,)."""
    if len(since) == 0:
        return np.empty(0)
    once = integral(since, place)
    twice = integral(since, once - np.interp(0.0, since, once))
    return np.asarray(np.interp(0.0, since, twice) - twice)

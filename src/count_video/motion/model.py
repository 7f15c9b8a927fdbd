r"""The places of bodies between their contacts, by the contacts' times and places.

With the path F that the term -w^2 x adds (see ``pieces``), a flight from the contact at (t_a, p_a)
to the one at (t_b, p_b) is

    x(t) = p_a (t_b - t) / (t_b - t_a) + p_b (t - t_a) / (t_b - t_a) + k (t - t_a)(t - t_b) / 2
           + w^2 F(t),

and next to one contact alone

    x(t) = p + v (t - t_a) + k (t - t_a)^2 / 2 + w^2 F(t).

All contacts of the ball with one wall are at one place, all contacts of the bodies at one distance,
which may change evenly across the picture (parallax); each may stray from it by little. Nothing
else is shared: the accelerations k of the flights are their own, for hands, slopes and lenses act
on some of them, with a normal prior as wide as those of the flights that show theirs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from count_video.lasting import Errors, errors_of, flight_of
from count_video.motion.pieces import WINDOW_FRAMES, pieces_of
from count_video.records import Floats
from count_video.signals import sigma_of

Kind = Literal["wall", "far", "bodies"]
"""What touches: the ball and a wall at smaller places, one at larger places, or both bodies."""

PARALLAX_SIGMA = 0.05
"""Growth of the distance at contact with the place, px per px: cameras some metres away."""
TIME_MOVES_FRAMES = 1.5
"""A contact lies in one of the steps next to the frame where it is looked for."""
RATE_SQUARED_SIGMA = 0.01
"""Of w^2 in (radians per frame) squared: a swing of some sixty frames."""
BEND_SHOWN_ROWS = 9
"""So many rows of a piece show its acceleration; where none do, ..."""
BEND_FRAMES = 100.0
"""... the fastest body may change its velocity wholly within so many frames."""


@dataclass(frozen=True)
class Paths:
    """Places of one body or two over frames, shape (n,) each; NaN where not seen."""

    frame: Floats
    ball_px: Floats
    heavy_px: Floats | None

    @property
    def signals(self) -> tuple[Floats, ...]:
        """Places of each body."""
        return (self.ball_px,) if self.heavy_px is None else (self.ball_px, self.heavy_px)

    def moved(self, by_px: float) -> Paths:
        """Move all places along the line."""
        heavy = None if self.heavy_px is None else self.heavy_px + by_px
        return Paths(self.frame, self.ball_px + by_px, heavy)


class Model:
    """Places of bodies as a function of the parameters, in columns, with derivatives."""

    def __init__(
        self,
        paths: Paths,
        contacts: tuple[tuple[Kind, ...], Floats],
        stray_sigmas: float,
        touching: float,
    ) -> None:
        self.paths, self.touching, self.stray_sigmas = paths, touching, stray_sigmas
        self.kinds, self.times = contacts
        self.contacts_of = [
            [n for n, kind in enumerate(self.kinds) if body == 0 or kind == "bodies"]
            for body in range(len(paths.signals))
        ]
        self.pieces = [
            piece
            for body, signal in enumerate(paths.signals)
            for piece in pieces_of(
                paths.frame,
                signal,
                body,
                [(n, self.times[n]) for n in self.contacts_of[body]],
                touching,
            )
        ]
        self._lay_out()
        self.errors: list[Errors | None] = [None] * len(paths.signals)
        self.sigma = [sigma_of(signal) for signal in paths.signals]

    def measured_errors(self) -> list[Errors | None]:
        """Measure the errors of each body's places about its flights."""
        return [self._errors(body) for body in range(len(self.paths.signals))]

    def use_errors(self, errors: list[Errors | None]) -> None:
        """Take measured errors for those of the places, where they are larger than white noise."""
        self.errors = errors
        white = [sigma_of(signal) for signal in self.paths.signals]
        known = [error.sigma_px if error else 0.0 for error in errors]
        self.sigma = [max(pair) for pair in zip(white, known, strict=True)]

    def _lay_out(self) -> None:
        """Give each parameter its column."""
        count, pieces = len(self.times), len(self.pieces)
        self.stray = count
        self.wall, self.far = 2 * count, 2 * count + 1
        self.distance, self.parallax = 2 * count + 2, 2 * count + 3
        self.swings = 2 * count + 4
        self.bends = self.swings + len(self.paths.signals)
        open_ended = np.array([not piece.spans for piece in self.pieces], dtype=bool)
        # Where a piece has no slope of its own, or a contact no place of the heavy body: column -1.
        self.slopes = _numbered(open_ended, self.bends + pieces)
        touching = np.array([kind == "bodies" for kind in self.kinds], dtype=bool)
        self.heavy = _numbered(touching, self.bends + pieces + int(open_ended.sum()))
        self.columns = self.bends + pieces + int(open_ended.sum()) + int(touching.sum())

    def _errors(self, body: int) -> Errors | None:
        """Measure the errors of a body's places about its flights next to the contacts."""
        frame, signal = self.paths.frame, self.paths.signals[body]
        if not np.isfinite(signal).any():
            return None
        ends = [self.times[n] for n in self.contacts_of[body]]
        flights = []
        for low, high in pairwise([-np.inf, *ends, np.inf]):
            first = high - 2 * WINDOW_FRAMES if np.isinf(low) else low
            last = low + 2 * WINDOW_FRAMES if np.isinf(high) else high
            rows = (frame > first + self.touching) & (frame < last - self.touching)
            flight = flight_of(frame[rows], signal[rows] - np.nanmean(signal))
            flights += [] if flight is None else [flight]
        return errors_of(flights)

    @cached_property
    def prior(self) -> tuple[Floats, Floats]:
        """Mean and standard deviation of each parameter, shape (columns,)."""
        mean = np.zeros(self.columns)
        sigma = np.full(self.columns, np.inf)
        ball, *others = self.paths.signals
        at = [_interpolated(self.paths.frame, signal, self.times) for signal in self.paths.signals]
        walls = {kind: at[0][[k == kind for k in self.kinds]] for kind in ("wall", "far")}
        for column, kind in ((self.wall, "wall"), (self.far, "far")):
            mean[column] = np.median(walls[kind]) if len(walls[kind]) else np.nanmean(ball)
        sigma[[self.wall, self.far, self.distance]] = self.extent
        if others:
            touching = self.contacts_of[1]
            mean[self.heavy[touching]] = at[1][touching]
            apart = (at[1] - at[0])[touching]
            mean[self.distance] = np.median(apart) if len(apart) else 0.0
        mean[: self.stray] = self.times
        sigma[: self.stray] = TIME_MOVES_FRAMES
        sigma[self.stray : self.wall] = self.stray_sigmas * max(self.sigma)
        sigma[self.parallax] = PARALLAX_SIGMA
        sigma[self.swings : self.bends] = RATE_SQUARED_SIGMA
        for body in range(len(self.paths.signals)):
            bend = self._bend_sigma(body)
            for number, piece in enumerate(self.pieces):
                sigma[self.bends + number] = (
                    bend if piece.body == body else sigma[self.bends + number]
                )
        sigma[self.slopes[self.slopes >= 0]] = self.fastest
        sigma[self.heavy[self.heavy >= 0]] = self.extent
        return mean, sigma

    @cached_property
    def about(self) -> float:
        """Mean place of the heavy body at its contacts: the distance is told there."""
        return float(self.prior[0][self.heavy[self.contacts_of[1]]].mean())

    @cached_property
    def fastest(self) -> float:
        """Largest step of a body from picture to picture, px per frame."""
        step = np.diff(self.paths.frame)
        steps = [np.abs(np.diff(signal)) / step for signal in self.paths.signals]
        return max(float(np.nanmax(one, initial=0.0)) for one in steps) + max(self.sigma)

    @cached_property
    def extent(self) -> float:
        """How far the bodies come, px."""
        ends = [(np.nanmin(one), np.nanmax(one)) for one in self.paths.signals]
        return float(max(high for _, high in ends) - min(low for low, _ in ends)) + max(self.sigma)

    def _bend_sigma(self, body: int) -> float:
        bends = [
            2 * np.polynomial.Polynomial.fit(p.frame, p.place_px, 2).convert().coef[-1]
            for p in self.pieces
            if p.body == body and len(p.rows) >= BEND_SHOWN_ROWS
        ]
        if not bends:
            return self.fastest / BEND_FRAMES
        shown = float(np.sqrt(np.mean(np.square(bends))))
        return float(np.hypot(shown, self.sigma[body] / WINDOW_FRAMES**2))

    @cached_property
    def weight(self) -> Floats:
        """One over the prior's standard deviation, shape (columns,)."""
        return np.asarray(1 / self.prior[1])

    def node(self, values: Floats, body: int, contact: int) -> tuple[float, dict[int, float]]:
        """Place of a body at a contact, and its derivatives by column."""
        heavy = int(self.heavy[contact])
        if body == 1:
            return float(values[heavy]), {heavy: 1.0}
        kind, stray = self.kinds[contact], self.stray + contact
        if kind != "bodies":
            column = self.wall if kind == "wall" else self.far
            return float(values[column] + values[stray]), {column: 1.0, stray: 1.0}
        away = values[heavy] - self.about
        growth = values[self.parallax]
        place = values[heavy] - values[self.distance] - growth * away + values[stray]
        slopes = {heavy: 1.0 - growth, self.distance: -1.0, self.parallax: -away, stray: 1.0}
        return float(place), slopes

    def piece(self, values: Floats, number: int) -> tuple[Floats, Floats]:
        """Modelled places of a piece, shape (n,), and their Jacobian, shape (n, columns)."""
        piece = self.pieces[number]
        bend, slope, swing = self.bends + number, self.slopes[number], self.swings + piece.body
        jacobian = np.zeros((len(piece.rows), self.columns))
        jacobian[:, swing] = piece.swung
        swung = values[swing] * piece.swung
        if not piece.spans:
            time = piece.frame - values[piece.anchor]
            place, slopes = self.node(values, piece.body, piece.anchor)
            jacobian[:, slope], jacobian[:, bend] = time, time**2 / 2
            jacobian[:, piece.anchor] = -values[slope] - values[bend] * time
            for column, by in slopes.items():
                jacobian[:, column] += by
            return place + values[slope] * time + values[bend] * time**2 / 2 + swung, jacobian
        first, last = piece.ends
        since, until = piece.frame - values[first], piece.frame - values[last]
        length = values[last] - values[first]
        shares = (-until / length, since / length)
        places = [self.node(values, piece.body, contact) for contact in (first, last)]
        fall = (places[0][0] - places[1][0]) / length
        jacobian[:, bend] = since * until / 2
        jacobian[:, first] += fall * shares[0] - values[bend] * until / 2
        jacobian[:, last] += fall * shares[1] - values[bend] * since / 2
        for share, (_, slopes) in zip(shares, places, strict=True):
            for column, by in slopes.items():
                jacobian[:, column] += by * share
        path = places[0][0] * shares[0] + places[1][0] * shares[1]
        return path + values[bend] * since * until / 2 + swung, jacobian

    def rate(self, values: Floats, number: int, contact: int) -> tuple[float, Floats]:
        """Velocity of a piece's body at one of its contacts, and its gradient, shape (columns,)."""
        piece = self.pieces[number]
        gradient = np.zeros(self.columns)
        if not piece.spans:
            gradient[self.slopes[number]] = 1.0
            return float(values[self.slopes[number]]), gradient
        first, last = piece.ends
        length, bend = values[last] - values[first], values[self.bends + number]
        side = -0.5 if contact == first else 0.5
        (low, low_by), (high, high_by) = (self.node(values, piece.body, n) for n in (first, last))
        mean = (high - low) / length
        gradient[self.bends + number] = side * length
        gradient[[first, last]] = np.array([1.0, -1.0]) * (mean / length - side * bend)
        gradient[self.swings + piece.body] = swung = piece.end_rates[0 if side < 0 else 1]
        for sign, slopes in ((-1.0, low_by), (1.0, high_by)):
            for column, by in slopes.items():
                gradient[column] += sign * by / length
        return float(
            mean + side * bend * length + values[self.swings + piece.body] * swung
        ), gradient

    def piece_at(self, body: int, time: float) -> int | None:
        """Piece of a body's flight that comes nearest to a time."""
        nearest, away = None, np.inf
        for number, piece in enumerate(self.pieces):
            low = -np.inf if piece.before is None else self.times[piece.before]
            high = np.inf if piece.after is None else self.times[piece.after]
            apart = max(piece.frame[0] - time, time - piece.frame[-1], 0.0)
            if piece.body == body and low < time < high and apart < away:
                nearest, away = number, apart
        return nearest

    def rate_within(self, values: Floats, number: int, time: float) -> float:
        """Velocity of a piece's body at a time between its rows."""
        piece, contact = self.pieces[number], self.pieces[number].anchor
        at_contact, _ = self.rate(values, number, contact)
        swung = float(np.interp(time, piece.frame, piece.swung_rate)) - piece.end_rates[0]
        bend, swing = values[self.bends + number], values[self.swings + piece.body]
        return float(at_contact + bend * (time - values[contact]) + swing * swung)

    def residuals(self, values: Floats, floor_px: float = 0.0) -> tuple[Floats, Floats]:
        """Of all pieces, in sigmas of at least the floor, with their Jacobian."""
        sigma = np.hypot(self.sigma, floor_px)
        found, jacobians = [np.empty(0)], [np.empty((0, self.columns))]
        for number, piece in enumerate(self.pieces):
            place, jacobian = self.piece(values, number)
            found.append((place - piece.place_px) / sigma[piece.body])
            jacobians.append(jacobian / sigma[piece.body])
        return np.concatenate(found), np.concatenate(jacobians)


def _numbered(some: NDArray[np.bool_], first: int) -> NDArray[np.intp]:
    """Columns for those that have one, from the first on; -1 for the others."""
    return np.where(some, first + np.cumsum(some) - 1, -1)


def _interpolated(frame: Floats, signal: Floats, at: Floats) -> Floats:
    seen = np.isfinite(signal)
    return np.interp(at, frame[seen], signal[seen])

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
from functools import cached_property, partial
from typing import Literal

import numpy as np

from count_video.motion.pieces import WINDOW_FRAMES, errors_about, pieces_of
from count_video.motion.priors import (
    BEND_FRAMES,
    PARALLAX_SIGMA,
    RATE_SQUARED_SIGMA,
    TIME_MOVES_FRAMES,
)
from count_video.motion.sums import Sums
from count_video.records import Floats
from count_video.signals import Errors, sigma_of, weighted_median

Kind = Literal["wall", "far", "bodies"]
"""What touches: the ball and a wall at smaller places, one at larger places, or both bodies."""

BEND_SHOWN_ROWS = 5
"""So many rows of a piece show its acceleration; where none do, ..."""

FIRST, LAST, BEND, SWING, SLOPE = range(5)
NODE_SLOTS = 4
BEFORE, AFTER = slice(5, 5 + NODE_SLOTS), slice(5 + NODE_SLOTS, 5 + 2 * NODE_SLOTS)
"""Slots of a piece: times of its first and last contact, its acceleration, the body's w^2, its
velocity where one end is open, and what gives the places at these contacts."""


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
    """Places of bodies as a function of the parameters, in columns, with derivatives.

    Each place depends on few columns, those that ``slots`` lists for its piece. Derivatives are
    kept for these alone, shape (n, slots); a column after the last one takes slots without use.
    """

    def __init__(
        self,
        paths: Paths,
        contacts: tuple[tuple[Kind, ...], Floats],
        stray_sigmas: float,
        touching: float,
    ) -> None:
        self.paths, self.touching, self.stray_sigmas = paths, touching, stray_sigmas
        self.kinds, self.times = contacts
        self.meets = np.array([kind == "bodies" for kind in self.kinds], dtype=bool)
        self.contacts_of = [np.arange(len(self.kinds)), np.flatnonzero(self.meets)]
        self.pieces = [
            piece
            for body, signal in enumerate(paths.signals)
            for piece in pieces_of(
                paths.frame,
                signal,
                body,
                [(n, self.times[n]) for n in self.contacts_of[body].tolist()],
                touching,
            )
        ]
        self._gather()
        self._lay_out()
        self.errors: tuple[Errors | None, ...] = (None,) * len(paths.signals)
        self.sigma = np.array([sigma_of(signal) for signal in paths.signals])

    def use_errors(self, errors: tuple[Errors | None, ...]) -> None:
        """Take measured errors for those of the places, where they are larger than white noise."""
        self.errors = errors
        self.sigma = np.maximum(self.sigma, [error.sigma_px if error else 0.0 for error in errors])

    def _gather(self) -> None:
        """Put the rows of all pieces one after the other, n in all."""
        pieces = self.pieces
        self.body = np.array([piece.body for piece in pieces], dtype=np.intp)
        self.first, self.last = np.array([p.ends for p in pieces], np.intp).reshape(-1, 2).T
        self.spans = np.array([piece.spans for piece in pieces], dtype=bool)
        self.end_rates = np.array([piece.end_rates for piece in pieces]).reshape(-1, 2)
        lengths = np.array([len(piece.rows) for piece in pieces], dtype=np.intp)
        self.starts, self.rows = np.cumsum(lengths) - lengths, lengths
        self.piece_of = np.repeat(np.arange(len(pieces)), lengths)
        self.frame, self.place_px, self.swung = (
            np.concatenate([np.empty(0), *(getattr(piece, name) for piece in pieces)])
            for name in ("frame", "place_px", "swung")
        )

    def _lay_out(self) -> None:
        """Give each parameter its column."""
        count, pieces, bodies = len(self.times), len(self.pieces), len(self.paths.signals)
        self.stray = count
        self.wall, self.far, self.distance, self.parallax = 2 * count + np.arange(4)
        self.swings = 2 * count + 4
        self.bends = self.swings + bodies
        self.slopes = self.bends + pieces + np.cumsum(~self.spans) - 1
        first_heavy = self.bends + pieces + int((~self.spans).sum())
        self.heavy = first_heavy + np.cumsum(self.meets) - 1
        self.columns = none = first_heavy + int(self.meets.sum())
        # Which columns give the place at a contact of the ball, and of the heavy body.
        nodes = np.full((2, count, NODE_SLOTS), none)
        nodes[0, :, 0] = [self.far if kind == "far" else self.wall for kind in self.kinds]
        nodes[0, :, 1] = self.stray + np.arange(count)
        nodes[0, self.meets, 2:] = self.distance, self.parallax
        nodes[:, self.meets, 0] = self.heavy[self.meets]
        self.slots = np.column_stack(
            [
                self.first,
                np.where(self.spans, self.last, none),
                self.bends + np.arange(pieces),
                self.swings + self.body,
                np.where(self.spans, none, self.slopes),
                nodes[self.body, self.first],
                np.where(self.spans[:, None], nodes[self.body, self.last], none),
            ]
        )
        self.sums = Sums(self.columns, self.slots, self.frame, self.rows)

    def measured_errors(self) -> tuple[Errors | None, ...]:
        """Measure the errors of each body's places about its flights next to the contacts."""
        frame, signals = self.paths.frame, self.paths.signals
        # Of one body alone hands and rest, before the first contact and after the last, are no
        # flights; two bodies swing before and after.
        alone = len(signals) == 1
        return tuple(
            errors_about(frame, signal, self.times[contacts].tolist(), self.touching, inside=alone)
            for signal, contacts in zip(signals, self.contacts_of, strict=False)
        )

    @cached_property
    def prior(self) -> tuple[Floats, Floats]:
        """Mean and standard deviation of each parameter, shape (columns,)."""
        mean, sigma = np.zeros(self.columns), np.ones(self.columns)
        at = [_interpolated(self.paths.frame, signal, self.times) for signal in self.paths.signals]
        for column, kind in ((self.wall, "wall"), (self.far, "far")):
            here = at[0][[k == kind for k in self.kinds]]
            mean[column] = np.median(here) if len(here) else np.nanmean(self.paths.ball_px)
        sigma[[self.wall, self.far, self.distance]] = self.extent
        if self.meets.any():
            mean[self.heavy[self.meets]] = at[1][self.meets]
            mean[self.distance] = np.median((at[1] - at[0])[self.meets])
        mean[: self.stray] = self.times
        sigma[: self.stray] = TIME_MOVES_FRAMES
        sigma[self.stray : self.wall] = self.stray_sigmas * self.sigma.max()
        sigma[self.parallax] = PARALLAX_SIGMA
        sigma[self.swings : self.bends] = RATE_SQUARED_SIGMA
        bends = slice(self.bends, self.bends + len(self.pieces))
        mean[bends], sigma[bends] = self._usual_bends()[:, self.body]
        sigma[self.slopes[~self.spans]] = self.fastest
        sigma[self.heavy[self.meets]] = self.extent
        return mean, sigma

    @cached_property
    def about(self) -> float:
        """Mean place of the heavy body at its contacts: the distance is measured there."""
        return float(self.prior[0][self.heavy[self.meets]].mean()) if self.meets.any() else 0.0

    @cached_property
    def fastest(self) -> float:
        """Largest step of a body from picture to picture, px per frame."""
        step = np.diff(self.paths.frame)
        steps = [np.abs(np.diff(signal)) / step for signal in self.paths.signals]
        return max(float(np.nanmax(one, initial=0.0)) for one in steps) + float(self.sigma.max())

    @cached_property
    def extent(self) -> float:
        """How far the bodies come, px."""
        ends = [(np.nanmin(one), np.nanmax(one)) for one in self.paths.signals]
        way = max(high for _, high in ends) - min(low for low, _ in ends)
        return float(way + self.sigma.max())

    def _usual_bends(self) -> Floats:
        """Mean acceleration of each body and its standard deviation, shape (2, bodies).

        They come from the pieces that show theirs. Where n of these agree, others may still differ
        from them by one n-th: a single one says no more than how large accelerations are.
        """
        total = partial(np.add.reduceat, indices=self.starts)
        bodies = len(self.paths.signals)
        found = np.array([np.zeros(bodies), np.full(bodies, self.fastest / BEND_FRAMES)])
        shown = self.rows >= BEND_SHOWN_ROWS
        if not shown.any():
            return found
        time = self.frame - (total(self.frame) / self.rows)[self.piece_of]
        # The part of time squared that a line does not take up: its coefficient is half the bend.
        squares = total(time**2)
        skew = total(time**3) / np.maximum(squares, np.finfo(np.float64).tiny)
        curved = time**2 - (squares / self.rows)[self.piece_of] - skew[self.piece_of] * time
        with np.errstate(invalid="ignore", divide="ignore"):
            bends = 2 * total(curved * self.place_px) / total(curved**2)
            noise = 2 * self.sigma[self.body] / np.sqrt(total(curved**2))
        for body in set(self.body[shown].tolist()):
            own, unsure = bends[shown & (self.body == body)], noise[shown & (self.body == body)]
            weight = 1 / (unsure**2 + np.median(unsure) ** 2)
            usual = weighted_median(own, weight)
            scatter = np.sqrt(weight @ (own - usual) ** 2 / weight.sum())
            unlike = usual / len(own) if len(own) > 1 else max(abs(usual), scatter)
            found[:, body] = usual * (len(own) > 1), np.hypot(scatter, unlike)
            found[1, body] = np.hypot(found[1, body], self.sigma[body] / WINDOW_FRAMES**2)
        return found

    @cached_property
    def weight(self) -> Floats:
        """One over the prior's standard deviation, shape (columns,)."""
        return np.asarray(1 / self.prior[1])

    def nodes(self, values: Floats) -> tuple[Floats, Floats]:
        """Places of both bodies at the contacts, shape (2, contacts), and their derivatives.

        These have shape (2, contacts, NODE_SLOTS). At a wall there is no place of the heavy body.
        """
        meets, stray, growth = self.meets, values[self.stray : self.wall], values[self.parallax]
        place, slopes = np.full((2, len(meets)), np.nan), np.zeros((2, len(meets), NODE_SLOTS))
        place[0] = stray + np.where(
            [kind == "far" for kind in self.kinds], values[self.far], values[self.wall]
        )
        slopes[0, :, :2] = 1.0
        place[1, meets] = heavy = values[self.heavy[meets]]
        away = heavy - self.about
        place[0, meets] = heavy - values[self.distance] - growth * away + stray[meets]
        slopes[0, meets] = np.stack(np.broadcast_arrays(1.0 - growth, 1.0, -1.0, -away), axis=-1)
        slopes[1, meets, 0] = 1.0
        return place, slopes

    def modelled(self, values: Floats) -> tuple[Floats, Floats]:
        """Places of all rows, shape (n,), and their derivatives by slot, shape (n, slots)."""
        padded = np.append(values, 0.0)
        bend, swing, slope = (padded[self.slots[self.piece_of, n]] for n in (BEND, SWING, SLOPE))
        place, by = self.nodes(values)
        piece, spans = self.piece_of, self.spans[self.piece_of]
        first, last, body = self.first[piece], self.last[piece], self.body[piece]
        since, until = self.frame - values[first], self.frame - values[last]
        length = np.where(spans, until - since, -1.0) * -1.0
        until = np.where(spans, until, since)
        share = np.where(spans, since / length, 0.0)
        fall = np.where(spans, (place[body, first] - place[body, last]) / length, -slope)
        path = place[body, first] - fall * since + bend * since * until / 2 + swing * self.swung
        jacobian = np.zeros((len(path), self.slots.shape[1]))
        jacobian[:, FIRST] = fall * (1 - share) - bend * np.where(spans, until / 2, since)
        jacobian[:, LAST] = np.where(spans, fall * share - bend * since / 2, 0.0)
        jacobian[:, BEND], jacobian[:, SWING] = since * until / 2, self.swung
        jacobian[:, SLOPE] = np.where(spans, 0.0, since)
        jacobian[:, BEFORE] = by[body, first] * (1 - share)[:, None]
        jacobian[:, AFTER] = by[body, last] * share[:, None]
        return path, jacobian

    def residuals(self, values: Floats, floor_px: float = 0.0) -> tuple[Floats, Floats]:
        """Of all rows, in sigmas of at least the floor, with their derivatives by slot."""
        sigma = np.hypot(self.sigma, floor_px)[self.body][self.piece_of]
        path, jacobian = self.modelled(values)
        return (path - self.place_px) / sigma, jacobian / sigma[:, None]

    def rates(self, values: Floats) -> tuple[Floats, Floats]:
        """Velocities of each piece's body at both ends, shape (pieces, 2), and their gradients.

        These have shape (pieces, 2, columns). A piece with one contact has it at both ends.
        """
        place, by = self.nodes(values)
        body, first, last, spans = self.body, self.first, self.last, self.spans
        bend, swing, slope = (
            np.append(values, 0.0)[self.slots[:, n]] for n in (BEND, SWING, SLOPE)
        )
        length = np.where(spans, values[last] - values[first], 1.0)
        mean = np.where(spans, (place[body, last] - place[body, first]) / length, slope)
        bend = np.where(spans, bend, 0.0)
        rates = mean[:, None] + swing[:, None] * self.end_rates
        gradients = np.zeros((len(body), 2, self.slots.shape[1]))
        for end, side in enumerate((-0.5, 0.5)):
            rates[:, end] += side * bend * length
            turned = np.where(spans, mean / length - side * bend, 0.0)
            gradients[:, end, FIRST], gradients[:, end, LAST] = turned, -turned
            gradients[:, end, BEND] = np.where(spans, side * length, 0.0)
            gradients[:, end, BEFORE] = -by[body, first] * (spans / length)[:, None]
            gradients[:, end, AFTER] = by[body, last] * (spans / length)[:, None]
        gradients[:, :, SWING], gradients[:, :, SLOPE] = self.end_rates, ~spans[:, None]
        full = np.zeros((len(body), 2, self.columns + 1))
        np.add.at(
            full, (np.arange(len(body))[:, None, None], np.arange(2)[:, None], self.slots[:, None]),
            gradients,
        )  # fmt: skip
        return rates, full[:, :, :-1]

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

    def rate_within(
        self, values: Floats, number: int, time: float, at_contact: tuple[float, Floats]
    ) -> tuple[float, Floats]:
        """Velocity of a piece's body at a time between its rows, and its gradient, by columns.

        ``at_contact`` is the same at the piece's first contact.
        """
        piece, contact = self.pieces[number], self.pieces[number].anchor
        swung = float(np.interp(time, piece.frame, piece.swung_rate)) - piece.end_rates[0]
        bend, swing = values[self.bends + number], values[self.swings + piece.body]
        since, gradient = time - values[contact], at_contact[1].copy()
        gradient[[self.bends + number, self.swings + piece.body]] += since, swung
        gradient[contact] -= bend
        return float(at_contact[0] + bend * since + swing * swung), gradient


def _interpolated(frame: Floats, signal: Floats, at: Floats) -> Floats:
    seen = np.isfinite(signal)
    return np.interp(at, frame[seen], signal[seen])

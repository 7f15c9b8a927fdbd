r"""All contacts of a clip fitted together: their times and places, and the flights between them.

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

Large residuals count like Cauchy errors. The uncertainties hold what lasts of the errors of places
from frame to frame (see ``lasting``): with H the Hessian, J the Jacobian and C the covariance of
the places, that of the parameters is H^-1 (J' C J + P) H^-1, where P comes from the priors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from count_video.lasting import LASTS_FRAMES, Errors, errors_of, flight_of
from count_video.motion.pieces import HALF_EXPOSURE, WINDOW_FRAMES, pieces_of
from count_video.records import Floats
from count_video.signals import sigma_of

Kind = Literal["wall", "far", "bodies"]
"""What touches: the ball and a wall at smaller places, one at larger places, or both bodies."""

CAUCHY_SIGMAS = 3.0
"""From here on a residual counts less than its square."""
PARALLAX_SIGMA = 0.05
"""Growth of the distance at contact with the place, px per px: cameras some metres away."""
STRAY_SIGMAS = 0.4
"""Contacts stray from one place by this share of the noise of a frame: outlines are measured a
little off where they lie unluckily on the pixels (0.02 px on rendered clips, truth known)."""
TIME_MOVES_FRAMES = 1.5
"""A contact lies in one of the steps next to the frame where it is looked for."""
RATE_SQUARED_SIGMA = 0.01
"""Of w^2 in (radians per frame) squared: a swing of some sixty frames."""
BEND_SHOWN_ROWS = 9
"""So many rows of a piece show its acceleration; where none do, ..."""
BEND_FRAMES = 100.0
"""... the fastest body may change its velocity wholly within so many frames."""
ROUNDS = 4
SETTLED_FRAMES = 0.02
"""The fit is repeated with rows chosen by its times until these move by less than this."""
FLOOR_SHARE = 0.1
"""In the first round frames count as no surer than this share of the fastest body's step."""
EVALUATIONS = 40
CONVERGED = 1e-5
"""Relative fall of the loss that is not worth another step."""


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


@dataclass(frozen=True)
class Motion:
    """Velocities at the contacts, before and after; shape (contacts, 2), NaN where not shown."""

    rate: Floats
    """px per frame."""
    sigma: Floats
    jump_sigma: Floats
    """Standard uncertainty of the jump, shape (contacts,)."""
    rows: Floats
    """How many rows support each side, shape (contacts, 2)."""

    @property
    def jump(self) -> Floats:
        """After less before, shape (contacts,)."""
        return np.asarray(self.rate[:, 1] - self.rate[:, 0])


@dataclass(frozen=True)
class Contacts:
    """All contacts as fitted; arrays have shape (contacts,)."""

    kinds: tuple[Kind, ...]
    frame: Floats
    frame_sigma: Floats
    ball_px: Floats
    """Place of the ball."""
    stray_px: Floats
    """By how much each strays from the common place or distance."""
    stray_sigma: Floats
    bodies: tuple[Motion, ...]
    """Of the ball, then of the heavy body, where there is one."""
    distance_px: float
    """Between the bodies' reference points where they touch; NaN where they do not."""
    misfit: float
    """Sum of squares of residuals in sigmas, robust, with the priors."""


def fit_contacts(
    paths: Paths,
    kinds: Sequence[Kind],
    frames: Sequence[float],
    stray_sigmas: float = STRAY_SIGMAS,
    rounds: int = ROUNDS,
) -> Contacts:
    """Fit contacts of known kinds, in order of time, from rough frame coordinates.

    Rows are chosen by the times, so the fit is repeated until these settle, at most ``rounds``
    times. ``stray_sigmas`` is the standard deviation by which contacts of a kind stray from one
    place, in standard deviations of a frame.
    """
    times = np.array(frames, dtype=np.float64)
    # Where the picture begins must not matter, not even to when the fit is taken for settled.
    origin = float(np.nanmean(paths.ball_px))
    near = paths.moved(-origin)
    for number in range(rounds):
        fit = _Fit(near, tuple(kinds), times, stray_sigmas)
        values = fit.solve(FLOOR_SHARE if number == 0 else 0.0)
        found = values[: len(times)]
        moved = float(np.abs(found - times).max(initial=0.0))
        times = found
        if number and moved < SETTLED_FRAMES:
            break
    return fit.contacts(values, origin)


class _Fit:
    """One fit with given rows."""

    def __init__(
        self, paths: Paths, kinds: tuple[Kind, ...], times: Floats, stray_sigmas: float
    ) -> None:
        self.paths, self.kinds, self.times = paths, kinds, times
        self.stray_sigmas = stray_sigmas
        self.contacts_of = [
            [n for n, kind in enumerate(kinds) if body == 0 or kind == "bodies"]
            for body in range(len(paths.signals))
        ]
        self.pieces = [
            piece
            for body, signal in enumerate(paths.signals)
            for piece in pieces_of(
                paths.frame, signal, body, [(n, times[n]) for n in self.contacts_of[body]]
            )
        ]
        self._lay_out()
        self.errors = [self._errors(body) for body in range(len(paths.signals))]
        self.sigma = [
            max(sigma_of(signal), error.sigma_px if error else 0.0)
            for signal, error in zip(paths.signals, self.errors, strict=True)
        ]

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
            rows = (frame > first + HALF_EXPOSURE) & (frame < last - HALF_EXPOSURE)
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

    def start(self) -> Floats:
        """Parameters at the rough times, in all of which the paths are linear; shape (columns,)."""
        values, weight = self.prior[0].copy(), self.weight[self.stray :]
        found, jacobian = self.residuals(values)
        linear = jacobian[:, self.stray :]
        hessian = linear.T @ linear + np.diag(weight**2)
        values[self.stray :] -= np.linalg.lstsq(hessian, linear.T @ found, rcond=None)[0]
        return values

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

    def residuals(self, values: Floats, floor_px: float = 0.0) -> tuple[Floats, Floats]:
        """Of all pieces, in sigmas of at least the floor, with their Jacobian."""
        sigma = np.hypot(self.sigma, floor_px)
        found, jacobians = [np.empty(0)], [np.empty((0, self.columns))]
        for number, piece in enumerate(self.pieces):
            place, jacobian = self.piece(values, number)
            found.append((place - piece.place_px) / sigma[piece.body])
            jacobians.append(jacobian / sigma[piece.body])
        return np.concatenate(found), np.concatenate(jacobians)

    def solve(self, floor_share: float) -> Floats:
        """Least squares from the rough parameters, shape (columns,).

        Residuals of less than a share of the fastest body's step count alike: rough times must not
        be taken for frames that mislead.
        """
        from scipy.optimize import least_squares  # noqa: PLC0415 - half a second to load

        mean, weight = self.prior[0], self.weight
        floor_px = floor_share * self.fastest
        reach = np.full(len(self.times), TIME_MOVES_FRAMES)
        if len(self.times) > 1:
            room = 0.45 * np.diff(self.times)
            reach = np.minimum(reach, np.minimum(np.append(room, np.inf), np.append(np.inf, room)))
        low, high = np.full(self.columns, -np.inf), np.full(self.columns, np.inf)
        low[: self.stray], high[: self.stray] = self.times - reach, self.times + reach

        def function(values: Floats) -> Floats:
            found, _ = self.residuals(values, floor_px)
            return np.concatenate([_robust(found)[0], (values - mean) * weight])

        def jacobian(values: Floats) -> Floats:
            found, by = self.residuals(values, floor_px)
            return np.concatenate([by * _robust(found)[1][:, None], np.diag(weight)])

        return np.asarray(
            least_squares(
                function,
                self.start(),
                jacobian,
                bounds=(low, high),
                x_scale="jac",
                max_nfev=EVALUATIONS,
                xtol=None,
                ftol=CONVERGED,
            ).x
        )

    def covariance(self, values: Floats) -> tuple[Floats, float]:
        """Covariance of the parameters, shape (columns, columns), and the sum of squares."""
        found, jacobian = self.residuals(values)
        mean, weight = self.prior[0], self.weight
        robust = 1 / (1 + (found / CAUCHY_SIGMAS) ** 2)
        weighted = jacobian * robust[:, None]
        inverse = np.linalg.pinv(weighted.T @ jacobian + np.diag(weight**2), hermitian=True)
        gain = inverse @ weighted.T
        total = (inverse * weight**2) @ inverse
        body = np.concatenate([np.empty(0), *(np.full(len(p.rows), p.body) for p in self.pieces)])
        frame = np.concatenate([np.empty(0), *(p.frame for p in self.pieces)])
        for number, error in enumerate(self.errors):
            rows = body == number
            total += (
                gain[:, rows]
                @ _correlation(error, self.sigma[number], frame[rows])
                @ gain[:, rows].T
            )
        away = (values - mean) * weight
        return total, float(_robust(found)[0] @ _robust(found)[0] + away @ away)

    def contacts(self, values: Floats, origin: float) -> Contacts:
        """Tell the contacts of a solution, with places from an origin."""
        covariance, misfit = self.covariance(values)
        sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        count = len(self.times)
        return Contacts(
            kinds=self.kinds,
            frame=values[:count],
            frame_sigma=sigma[:count],
            ball_px=np.array([origin + self.node(values, 0, n)[0] for n in range(count)]),
            stray_px=values[self.stray : self.wall],
            stray_sigma=sigma[self.stray : self.wall],
            bodies=tuple(
                self._motion(values, covariance, body) for body in range(len(self.paths.signals))
            ),
            distance_px=float(values[self.distance]) if "bodies" in self.kinds else np.nan,
            misfit=misfit,
        )

    def _motion(self, values: Floats, covariance: Floats, body: int) -> Motion:
        count = len(self.times)
        rate, rows = np.full((count, 2), np.nan), np.zeros((count, 2))
        gradients = np.zeros((count, 2, self.columns))
        for number, piece in enumerate(self.pieces):
            if piece.body != body:
                continue
            for side, contact in ((1, piece.before), (0, piece.after)):
                if contact is not None:
                    rate[contact, side], gradients[contact, side] = self.rate(
                        values, number, contact
                    )
                    rows[contact, side] = len(piece.rows)
        for contact in set(range(count)) - set(self.contacts_of[body]):
            near = self._piece_at(body, float(values[contact]))
            if near is not None:
                rate[contact] = self.rate_within(values, near, float(values[contact]))
        jump = gradients[:, 1] - gradients[:, 0]
        sigma = np.sqrt(
            np.einsum("csp,pq,csq->cs", gradients, covariance, gradients, optimize=True)
        )
        jump_sigma = np.sqrt(np.einsum("cp,pq,cq->c", jump, covariance, jump, optimize=True))
        return Motion(rate, sigma, jump_sigma, rows)

    def _piece_at(self, body: int, time: float) -> int | None:
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


def _numbered(some: NDArray[np.bool_], first: int) -> NDArray[np.intp]:
    """Columns for those that have one, from the first on; -1 for the others."""
    return np.where(some, first + np.cumsum(some) - 1, -1)


def _robust(residuals: Floats) -> tuple[Floats, Floats]:
    """Residuals whose squares are Cauchy's losses, and their derivatives by the residuals."""
    unit = residuals / CAUCHY_SIGMAS
    loss = np.sqrt(np.log1p(unit**2))
    slope = np.divide(unit, (1 + unit**2) * loss, out=np.ones_like(unit), where=loss > 1e-6)
    return CAUCHY_SIGMAS * np.copysign(loss, unit), np.abs(slope)


def _interpolated(frame: Floats, signal: Floats, at: Floats) -> Floats:
    seen = np.isfinite(signal)
    return np.interp(at, frame[seen], signal[seen])


def _correlation(error: Errors | None, sigma: float, frame: Floats) -> Floats:
    """Covariance of residuals in sigmas, shape (n, n)."""
    if error is None:
        return np.eye(len(frame))
    apart = np.abs(frame[:, None] - frame)
    total = error.white_px2 * np.eye(len(frame))
    for lasts, variance in zip(LASTS_FRAMES, error.lasting_px2, strict=True):
        total += variance * np.exp(-apart / lasts)
    return np.asarray(total / sigma**2)

r"""All contacts of a clip fitted together: their times and places, and the flights between them.

Least squares over the parameters of ``model``, with normal priors. Large residuals count like
Cauchy errors. The uncertainties hold what lasts of the errors of places from frame to frame (see
``signals``): with H the Hessian, J the Jacobian and C the covariance of the places, that of the
parameters is H^-1 (J' C J + P) H^-1, where P comes from the priors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from count_video.motion.descent import descend, loss_of, step, weights_of
from count_video.motion.model import Kind, Model, Paths
from count_video.motion.pieces import HALF_EXPOSURE
from count_video.motion.priors import STRAY_SIGMAS, TIME_MOVES_FRAMES
from count_video.records import Collision, Floats, Velocities
from count_video.signals import Errors

BodyErrors = tuple[Errors | None, ...]
"""How the places of each body vary together; None where its flights say too little."""

ROUNDS = 4
SETTLED_FRAMES = 0.02
"""The fit is repeated with rows chosen by its times until these move by less than this."""
FLOOR_SHARE = 0.1
"""In the first round frames count as no surer than this share of the fastest body's step."""


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
    errors: BodyErrors
    """Of the places of each body."""


@dataclass(frozen=True)
class Fitting:
    """How contacts are fitted."""

    stray_sigmas: float = STRAY_SIGMAS
    """Standard deviation by which contacts of a kind stray from one place, in standard deviations
    of a frame."""
    touching: float = HALF_EXPOSURE
    """Frames on either side of a contact that may show it; more of them for soft bodies."""
    rounds: int = ROUNDS
    errors: BodyErrors | None = None
    """Of the places of each body, where they are known from a fit before, whose times are good."""
    fitted: bool = False
    """Whether the times are good, so that the errors can be measured at once."""


USUAL = Fitting()


def fit_together(
    paths: Paths, kinds: Sequence[Kind], frames: Sequence[float], how: Fitting = USUAL
) -> Contacts:
    """Fit contacts of known kinds, in order of time, from rough frame coordinates.

    Rows are chosen by the times, so the fit is repeated until these settle, at most ``how.rounds``
    times.
    """
    times = np.array(frames, dtype=np.float64)
    # Where the picture begins must not matter, not even to when the fit is taken for settled.
    origin = float(np.nanmean(paths.ball_px))
    near = paths.moved(-origin)
    errors, measured_in = how.errors, 0 if how.fitted else 1
    for number in range(how.rounds):
        model = Model(near, (tuple(kinds), times), how.stray_sigmas, how.touching)
        if number == measured_in:
            errors = model.measured_errors()
        rough = errors is None
        if errors is not None:
            model.use_errors(errors)
        values = _solved(model, FLOOR_SHARE if rough else 0.0)
        moved = float(np.abs(values[: len(times)] - times).max(initial=0.0))
        times = values[: len(times)]
        if number >= measured_in and moved < SETTLED_FRAMES:
            break
    return _contacts(model, values, origin)


class _Fit:
    """The model at one set of parameters.

    Residuals of less than the floor count alike: rough times must not be taken for frames that
    mislead. The normal equations are put together piece by piece, which a solver for dense
    equations cannot.
    """

    def __init__(self, model: Model, floor_px: float, values: Floats) -> None:
        self.model, self.values = model, values
        self.found, self.jacobian = model.residuals(values, floor_px)
        self.away = (values - model.prior[0]) * model.weight
        self.loss = loss_of(self.found) + float(self.away @ self.away) / 2

    @cached_property
    def weighted(self) -> Floats:
        """Derivatives of the residuals, those of large ones count less."""
        return np.asarray(self.jacobian * weights_of(self.found)[:, None])

    @cached_property
    def gradient(self) -> Floats:
        """Of the loss, shape (columns,)."""
        return self.model.sums.weighted(self.weighted, self.found) + self.away * self.model.weight

    @cached_property
    def hessian(self) -> Floats:
        """Of the loss, shape (columns, columns)."""
        hessian = self.model.sums.products(self.weighted, self.jacobian)
        hessian[np.diag_indices(self.model.columns)] += self.model.weight**2
        return hessian


def _solved(model: Model, floor_share: float) -> Floats:
    """Least squares from the rough times, shape (columns,).

    The floor is a share of the fastest body's step. Times keep their order.
    """
    floor_px = floor_share * model.fastest
    reach = np.full(len(model.times), TIME_MOVES_FRAMES)
    if len(model.times) > 1:
        between = 0.45 * np.diff(model.times)
        reach = np.minimum(reach, np.append(between, np.inf))
        reach = np.minimum(reach, np.append(np.inf, between))
    low, high = np.full(model.columns, -np.inf), np.full(model.columns, np.inf)
    low[: model.stray], high[: model.stray] = model.times - reach, model.times + reach
    at = partial(_Fit, model, floor_px)
    # At the rough times the paths are linear in all parameters.
    start = model.prior[0].copy()
    free = np.arange(model.columns) >= model.stray
    start -= step(at(start), 0.0, np.zeros(model.columns), free)
    return descend(at, start, (low, high)).values


def _covariance(model: Model, values: Floats) -> Floats:
    """Covariance of the parameters, shape (columns, columns)."""
    fit = _Fit(model, 0.0, values)
    hessian = fit.hessian
    scale = 1 / np.sqrt(np.diag(hessian))
    inverse = np.linalg.inv(hessian * scale[:, None] * scale) * scale[:, None] * scale
    total = np.diag(model.weight**2)
    for body, (errors, sigma) in enumerate(zip(model.errors, model.sigma.tolist(), strict=True)):
        pieces = np.flatnonzero(model.body == body)
        total += model.sums.covariance(fit.weighted, pieces, errors, sigma)
    return np.asarray(inverse @ total @ inverse)


def _contacts(model: Model, values: Floats, origin: float) -> Contacts:
    """Contacts of a solution, with places from an origin."""
    covariance = _covariance(model, values)
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    count = len(model.times)
    return Contacts(
        kinds=model.kinds,
        frame=values[:count],
        frame_sigma=sigma[:count],
        ball_px=origin + model.nodes(values)[0][0],
        stray_px=values[model.stray : model.wall],
        stray_sigma=sigma[model.stray : model.wall],
        bodies=tuple(
            _motion(model, values, covariance, body) for body in range(len(model.paths.signals))
        ),
        distance_px=float(values[model.distance]) if "bodies" in model.kinds else np.nan,
        errors=model.errors,
    )


def _motion(model: Model, values: Floats, covariance: Floats, body: int) -> Motion:
    count = len(model.times)
    rate, rows = np.full((count, 2), np.nan), np.zeros((count, 2))
    gradients = np.zeros((count, 2, model.columns))
    rates, slopes = model.rates(values)
    for number, piece in enumerate(model.pieces):
        if piece.body != body:
            continue
        for side, end, contact in ((1, 0, piece.before), (0, 1, piece.after)):
            if contact is not None:
                rate[contact, side] = rates[number, end]
                gradients[contact, side] = slopes[number, end]
                rows[contact, side] = len(piece.rows)
    for contact in set(range(count)) - set(model.contacts_of[body].tolist()):
        near = model.piece_at(body, float(values[contact]))
        if near is not None:
            time = float(values[contact])
            here = (float(rates[near, 0]), slopes[near, 0])
            rate[contact], gradients[contact] = model.rate_within(values, near, time, here)
    jump = gradients[:, 1] - gradients[:, 0]
    flat = gradients.reshape(-1, model.columns)
    sigma = np.sqrt(np.einsum("cp,cp->c", flat @ covariance, flat)).reshape(count, 2)
    jump_sigma = np.sqrt(np.einsum("cp,cp->c", jump @ covariance, jump))
    return Motion(rate, sigma, jump_sigma, rows)


def collisions_of(fitted: Contacts, sign: int = 1) -> list[Collision]:
    """Contacts as collisions, all of them seen, at places and velocities times a sign."""
    rates, sigmas = (np.full((len(fitted.kinds), 2, 2), np.nan) for _ in range(2))
    for place, body in enumerate(fitted.bodies):
        rates[:, :, place], sigmas[:, :, place] = sign * body.rate, body.sigma
    velocities = np.concatenate([rates, sigmas], axis=-1).tolist()
    return [
        Collision(
            number=number + 1,
            kind="bodies" if kind == "bodies" else "wall",
            frame=float(fitted.frame[number]),
            frame_sigma=float(fitted.frame_sigma[number]),
            time_s=None,
            seen=True,
            position_px=sign * float(fitted.ball_px[number]),
            velocity_before=Velocities(*velocities[number][0]),
            velocity_after=Velocities(*velocities[number][1]),
        )
        for number, kind in enumerate(fitted.kinds)
    ]

r"""All contacts of a clip fitted together: their times and places, and the flights between them.

Least squares over the parameters of ``model``, with normal priors. Large residuals count like
Cauchy errors. The uncertainties hold what lasts of the errors of places from frame to frame (see
``signals``): with H the Hessian, J the Jacobian and C the covariance of the places, that of the
parameters is H^-1 (J' C J + P) H^-1, where P comes from the priors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.motion.model import Kind, Model, Paths
from count_video.motion.pieces import HALF_EXPOSURE
from count_video.motion.priors import CAUCHY_SIGMAS, STRAY_SIGMAS, TIME_MOVES_FRAMES
from count_video.records import Collision, Floats, Velocities
from count_video.signals import Errors

ROUNDS = 4
SETTLED_FRAMES = 0.02
"""The fit is repeated with rows chosen by its times until these move by less than this."""
FLOOR_SHARE = 0.1
"""In the first round frames count as no surer than this share of the fastest body's step."""
EVALUATIONS = 40
DAMPING, DAMPING_RISES, DAMPING_FALLS, DAMPING_AT_MOST = 1e-4, 10.0, 0.1, 1e8
"""Of the steps, as a share of the diagonal of the normal equations."""
CONVERGED = 1e-5
"""Relative fall of the loss that is not worth another step."""


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
    errors: tuple[Errors | None, ...]
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
    errors: tuple[Errors | None, ...] | None = None
    """Of the places of each body, where they are known from a fit before, whose times are good."""


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
    errors = how.errors
    for number in range(how.rounds):
        model = Model(near, (tuple(kinds), times), how.stray_sigmas, how.touching)
        if number == 1:
            errors = model.measured_errors()
        rough = errors is None
        if errors is not None:
            model.use_errors(errors)
        values = _solved(model, FLOOR_SHARE if rough else 0.0)
        moved = float(np.abs(values[: len(times)] - times).max(initial=0.0))
        times = values[: len(times)]
        if number and moved < SETTLED_FRAMES:
            break
    return _contacts(model, values, origin)


def _solved(model: Model, floor_share: float) -> Floats:
    """Least squares from the rough times, by Levenberg's and Marquardt's method, shape (columns,).

    Residuals of less than a share of the fastest body's step count alike: rough times must not
    be taken for frames that mislead. The normal equations are put together piece by piece, which
    a general solver for dense equations cannot.
    """
    mean, weight = model.prior[0], model.weight
    floor_px = floor_share * model.fastest
    low, high = _reach(model)
    values = _start(model, floor_px)
    found, jacobian = model.residuals(values, floor_px)
    loss, damping = _loss(model, found, values), DAMPING
    for _ in range(EVALUATIONS):
        robust, slope = _robust(found)
        scaled = jacobian * slope[:, None]
        gradient = model.sums(scaled, robust) + (values - mean) * weight**2
        hessian = model.products(scaled, scaled)
        hessian[np.diag_indices(model.columns)] += weight**2
        kept = ~(((values <= low) & (gradient > 0)) | ((values >= high) & (gradient < 0)))
        before = loss
        while damping < DAMPING_AT_MOST:
            step = np.zeros(model.columns)
            step[kept] = _step(hessian[np.ix_(kept, kept)], gradient[kept], damping)
            trial = np.clip(values - step, low, high)
            found_there, jacobian_there = model.residuals(trial, floor_px)
            loss_there = _loss(model, found_there, trial)
            if loss_there <= loss:
                values, found, jacobian, loss = trial, found_there, jacobian_there, loss_there
                damping *= DAMPING_FALLS
                break
            damping *= DAMPING_RISES
        if before - loss <= CONVERGED * before:
            break
    return values


def _reach(model: Model) -> tuple[Floats, Floats]:
    """Bounds of the parameters: times keep their order; shape (columns,) each."""
    reach = np.full(len(model.times), TIME_MOVES_FRAMES)
    if len(model.times) > 1:
        between = 0.45 * np.diff(model.times)
        reach = np.minimum(reach, np.append(between, np.inf))
        reach = np.minimum(reach, np.append(np.inf, between))
    low, high = np.full(model.columns, -np.inf), np.full(model.columns, np.inf)
    low[: model.stray], high[: model.stray] = model.times - reach, model.times + reach
    return low, high


def _start(model: Model, floor_px: float) -> Floats:
    """Parameters at the rough times, in all of which the paths are linear; shape (columns,)."""
    values, free = model.prior[0].copy(), slice(model.stray, None)
    found, jacobian = model.residuals(values, floor_px)
    hessian = model.products(jacobian, jacobian)
    hessian[np.diag_indices(model.columns)] += model.weight**2
    gradient = model.sums(jacobian, found)
    values[free] -= _step(hessian[free, free], gradient[free], 0.0)
    return values


def _step(hessian: Floats, gradient: Floats, damping: float) -> Floats:
    """Solve damped normal equations, scaled to a diagonal of ones."""
    scale = 1 / np.sqrt(np.diag(hessian))
    scaled = hessian * scale[:, None] * scale
    scaled[np.diag_indices(len(scaled))] += damping
    return np.asarray(scale * np.linalg.solve(scaled, scale * gradient))


def _loss(model: Model, found: Floats, values: Floats) -> float:
    """Sum of squares of residuals in sigmas, robust, with the priors."""
    away = (values - model.prior[0]) * model.weight
    return float(CAUCHY_SIGMAS**2 * np.log1p((found / CAUCHY_SIGMAS) ** 2).sum() + away @ away)


def _covariance(model: Model, values: Floats) -> Floats:
    """Covariance of the parameters, shape (columns, columns)."""
    found, jacobian = model.residuals(values)
    weight = model.weight
    weighted = jacobian / (1 + (found / CAUCHY_SIGMAS) ** 2)[:, None]
    hessian = model.products(weighted, jacobian)
    hessian[np.diag_indices(model.columns)] += weight**2
    scale = 1 / np.sqrt(np.diag(hessian))
    inverse = np.linalg.inv(hessian * scale[:, None] * scale) * scale[:, None] * scale
    total = np.diag(weight**2)
    for body in range(len(model.errors)):
        total += model.covariance(weighted, body)
    return np.asarray(inverse @ total @ inverse)


def _contacts(model: Model, values: Floats, origin: float) -> Contacts:
    """Tell the contacts of a solution, with places from an origin."""
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


def _robust(residuals: Floats) -> tuple[Floats, Floats]:
    """Residuals whose squares are Cauchy's losses, and their derivatives by the residuals."""
    unit = residuals / CAUCHY_SIGMAS
    loss = np.sqrt(np.log1p(unit**2))
    slope = np.divide(unit, (1 + unit**2) * loss, out=np.ones_like(unit), where=loss > 1e-6)
    return CAUCHY_SIGMAS * np.copysign(loss, unit), np.abs(slope)


def collisions_of(fitted: Contacts, sign: int = 1) -> list[Collision]:
    """Tell contacts as collisions, all of them seen, at places and velocities times a sign."""
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

r"""All contacts of a clip fitted together: their times and places, and the flights between them.

Least squares over the parameters of ``model``, with normal priors. Large residuals count like
Cauchy errors. The uncertainties hold what lasts of the errors of places from frame to frame (see
``lasting``): with H the Hessian, J the Jacobian and C the covariance of the places, that of the
parameters is H^-1 (J' C J + P) H^-1, where P comes from the priors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.lasting import LASTS_FRAMES, Errors
from count_video.motion.model import TIME_MOVES_FRAMES, Kind, Model, Paths
from count_video.motion.pieces import HALF_EXPOSURE
from count_video.records import Floats

CAUCHY_SIGMAS = 3.0
"""From here on a residual counts less than its square."""
STRAY_SIGMAS = 0.4
"""Contacts stray from one place by this share of the noise of a frame: outlines are measured a
little off where they lie unluckily on the pixels (0.02 px on rendered clips, truth known)."""
ROUNDS = 4
SETTLED_FRAMES = 0.02
"""The fit is repeated with rows chosen by its times until these move by less than this."""
FLOOR_SHARE = 0.1
"""In the first round frames count as no surer than this share of the fastest body's step."""
EVALUATIONS = 40
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
    misfit: float
    """Sum of squares of residuals in sigmas, robust, with the priors."""


def fit_contacts(
    paths: Paths,
    kinds: Sequence[Kind],
    frames: Sequence[float],
    stray_sigmas: float = STRAY_SIGMAS,
    rounds: int = ROUNDS,
    touching: float = HALF_EXPOSURE,
) -> Contacts:
    """Fit contacts of known kinds, in order of time, from rough frame coordinates.

    Rows are chosen by the times, so the fit is repeated until these settle, at most ``rounds``
    times. ``stray_sigmas`` is the standard deviation by which contacts of a kind stray from one
    place, in standard deviations of a frame; ``touching`` the frames on either side of a contact
    that may show it, more of them where the bodies are soft.
    """
    times = np.array(frames, dtype=np.float64)
    # Where the picture begins must not matter, not even to when the fit is taken for settled.
    origin = float(np.nanmean(paths.ball_px))
    near = paths.moved(-origin)
    for number in range(rounds):
        model = Model(near, (tuple(kinds), times), stray_sigmas, touching)
        if number == 1:
            errors = model.measured_errors()
        if number:
            model.use_errors(errors)
        values = _solved(model, FLOOR_SHARE if number == 0 else 0.0)
        found = values[: len(times)]
        moved = float(np.abs(found - times).max(initial=0.0))
        times = found
        if number and moved < SETTLED_FRAMES:
            break
    return _contacts(model, values, origin)


def _start(model: Model) -> Floats:
    """Parameters at the rough times, in all of which the paths are linear; shape (columns,)."""
    values, weight = model.prior[0].copy(), model.weight[model.stray :]
    found, jacobian = model.residuals(values)
    linear = jacobian[:, model.stray :]
    hessian = linear.T @ linear + np.diag(weight**2)
    values[model.stray :] -= np.linalg.lstsq(hessian, linear.T @ found, rcond=None)[0]
    return values


def _solved(model: Model, floor_share: float) -> Floats:
    """Least squares from the rough parameters, shape (columns,).

    Residuals of less than a share of the fastest body's step count alike: rough times must not
    be taken for frames that mislead.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 - half a second to load

    mean, weight = model.prior[0], model.weight
    floor_px = floor_share * model.fastest
    reach = np.full(len(model.times), TIME_MOVES_FRAMES)
    if len(model.times) > 1:
        room = 0.45 * np.diff(model.times)
        reach = np.minimum(reach, np.minimum(np.append(room, np.inf), np.append(np.inf, room)))
    low, high = np.full(model.columns, -np.inf), np.full(model.columns, np.inf)
    low[: model.stray], high[: model.stray] = model.times - reach, model.times + reach

    # Both are asked for at the same values, one after the other.
    last: list[tuple[Floats, tuple[Floats, Floats]]] = []

    def modelled(values: Floats) -> tuple[Floats, Floats]:
        if not last or not np.array_equal(last[0][0], values):
            last[:] = [(values.copy(), model.residuals(values, floor_px))]
        return last[0][1]

    def function(values: Floats) -> Floats:
        return np.concatenate([_robust(modelled(values)[0])[0], (values - mean) * weight])

    def jacobian(values: Floats) -> Floats:
        found, by = modelled(values)
        return np.concatenate([by * _robust(found)[1][:, None], np.diag(weight)])

    return np.asarray(
        least_squares(
            function,
            _start(model),
            jacobian,
            bounds=(low, high),
            x_scale="jac",
            max_nfev=EVALUATIONS,
            xtol=None,
            ftol=CONVERGED,
        ).x
    )


def _covariance(model: Model, values: Floats) -> tuple[Floats, float]:
    """Covariance of the parameters, shape (columns, columns), and the sum of squares."""
    found, jacobian = model.residuals(values)
    mean, weight = model.prior[0], model.weight
    robust = 1 / (1 + (found / CAUCHY_SIGMAS) ** 2)
    weighted = jacobian * robust[:, None]
    inverse = np.linalg.pinv(weighted.T @ jacobian + np.diag(weight**2), hermitian=True)
    gain = inverse @ weighted.T
    total = (inverse * weight**2) @ inverse
    body = np.concatenate([np.empty(0), *(np.full(len(p.rows), p.body) for p in model.pieces)])
    frame = np.concatenate([np.empty(0), *(p.frame for p in model.pieces)])
    for number, error in enumerate(model.errors):
        rows = body == number
        total += (
            gain[:, rows] @ _correlation(error, model.sigma[number], frame[rows]) @ gain[:, rows].T
        )
    away = (values - mean) * weight
    return total, float(_robust(found)[0] @ _robust(found)[0] + away @ away)


def _contacts(model: Model, values: Floats, origin: float) -> Contacts:
    """Tell the contacts of a solution, with places from an origin."""
    covariance, misfit = _covariance(model, values)
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    count = len(model.times)
    return Contacts(
        kinds=model.kinds,
        frame=values[:count],
        frame_sigma=sigma[:count],
        ball_px=np.array([origin + model.node(values, 0, n)[0] for n in range(count)]),
        stray_px=values[model.stray : model.wall],
        stray_sigma=sigma[model.stray : model.wall],
        bodies=tuple(
            _motion(model, values, covariance, body) for body in range(len(model.paths.signals))
        ),
        distance_px=float(values[model.distance]) if "bodies" in model.kinds else np.nan,
        misfit=misfit,
    )


def _motion(model: Model, values: Floats, covariance: Floats, body: int) -> Motion:
    count = len(model.times)
    rate, rows = np.full((count, 2), np.nan), np.zeros((count, 2))
    gradients = np.zeros((count, 2, model.columns))
    for number, piece in enumerate(model.pieces):
        if piece.body != body:
            continue
        for side, contact in ((1, piece.before), (0, piece.after)):
            if contact is not None:
                rate[contact, side], gradients[contact, side] = model.rate(values, number, contact)
                rows[contact, side] = len(piece.rows)
    for contact in set(range(count)) - set(model.contacts_of[body]):
        near = model.piece_at(body, float(values[contact]))
        if near is not None:
            rate[contact] = model.rate_within(values, near, float(values[contact]))
    jump = gradients[:, 1] - gradients[:, 0]
    sigma = np.sqrt(np.einsum("csp,pq,csq->cs", gradients, covariance, gradients, optimize=True))
    jump_sigma = np.sqrt(np.einsum("cp,pq,cq->c", jump, covariance, jump, optimize=True))
    return Motion(rate, sigma, jump_sigma, rows)


def _robust(residuals: Floats) -> tuple[Floats, Floats]:
    """Residuals whose squares are Cauchy's losses, and their derivatives by the residuals."""
    unit = residuals / CAUCHY_SIGMAS
    loss = np.sqrt(np.log1p(unit**2))
    slope = np.divide(unit, (1 + unit**2) * loss, out=np.ones_like(unit), where=loss > 1e-6)
    return CAUCHY_SIGMAS * np.copysign(loss, unit), np.abs(slope)


def _correlation(error: Errors | None, sigma: float, frame: Floats) -> Floats:
    """Covariance of residuals in sigmas, shape (n, n)."""
    if error is None:
        return np.eye(len(frame))
    apart = np.abs(frame[:, None] - frame)
    total = error.white_px2 * np.eye(len(frame))
    for lasts, variance in zip(LASTS_FRAMES, error.lasting_px2, strict=True):
        total += variance * np.exp(-apart / lasts)
    return np.asarray(total / sigma**2)

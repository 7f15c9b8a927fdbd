"""What fits give: parameters, the set-up, energies and the collisions themselves.

Parameters are means over all fits that come into question, not of one alone. The scatter of the
restitution from collision to collision is not known, and in long bursts neither is the count. Each
has its own best mass ratio, from which a single fit's uncertainty knows nothing.

The fits' parameters are the motion at the first collision; what a person set up by hand follows
from them: the gap, the release (the swing's amplitude before the first collision), the gap between
the bodies at rest, and the periods of the threads. Their uncertainties are those of draws from each
fit's uncertainty, and the differences between the fits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from count_video.motion.left_out import LeftOut
from count_video.motion.observations import Observations
from count_video.motion.parameters import Column
from count_video.motion.pendulums import Paths, follow, tangents_of
from count_video.motion.pieces import HALF_EXPOSURE
from count_video.motion.posterior import Weighed, draws_of
from count_video.motion.resolution import RESOLVED_FRAMES
from count_video.motion.seen import SeenCollisions
from count_video.motion.solving import Solution
from count_video.records import (
    Collision,
    Ending,
    EndingKind,
    Estimate,
    FittedSetup,
    Floats,
    Velocities,
)


def mixed(shares: Floats, values: Floats, variances: Floats) -> tuple[Floats, Floats]:
    """Mean and standard deviation over fits with shares that sum to 1: in each and between them.

    ``values`` and ``variances`` have shape (fits, ...), the results (...).
    """
    mean = np.tensordot(shares, values, 1)
    return mean, np.sqrt(np.tensordot(shares, variances + (values - mean) ** 2, 1))


def estimate(weighed: Weighed, shares: Floats, column: Column) -> Estimate:
    """Give mean and standard deviation of a parameter over all fits and their uncertainties."""
    values = np.array([fit.values[column] for _, fit in weighed.values()])
    variances = np.array([variances_of(fit)[column] for _, fit in weighed.values()])
    mean, sigma = mixed(shares, values, variances)
    return Estimate(float(mean), float(sigma))


def mass_ratio(weighed: Weighed, shares: Floats) -> Estimate:
    """Heavy over light, from the logarithm of the lightness."""
    lightness = estimate(weighed, shares, Column.LIGHTNESS)
    ratio = float(np.exp(-lightness.value))
    return Estimate(ratio, ratio * lightness.sigma)


def variances_of(solution: Solution) -> Floats:
    """Variances of a fit's parameters, shape (columns,)."""
    return np.asarray(np.maximum(np.diag(np.linalg.pinv(solution.hessian, hermitian=True)), 0.0))


def fitted_setup(weighed: Weighed, shares: Floats) -> FittedSetup:
    """Mean and standard uncertainty of the set-up over all fits, of which each has its share."""
    fits = [fit for _, fit in weighed.values()]
    values = np.array([_arranged(fit.values) for fit in fits])
    variances = np.array([np.var(_arranged(draws_of(fit).T), axis=1) for fit in fits])
    mean, sigma = mixed(shares, values, variances)
    return FittedSetup(*(Estimate(float(m), float(s)) for m, s in zip(mean, sigma, strict=True)))


def _arranged(values: Floats) -> Floats:
    """Derive the set-up, in the order of its record, from parameters, shape (columns, ...)."""
    rate = np.exp(values[Column.SWING])
    from_rest = -values[Column.HEAVY_PULL] / rate**2
    gap = values[Column.BALL_REST] - values[Column.WALL]
    release = np.hypot(from_rest, values[Column.HEAVY_RATE] / rate)
    bodies_gap = values[Column.HEAVY] - from_rest - values[Column.BALL_REST]
    period = 2.0 * np.pi / rate
    return np.array([gap, release, bodies_gap, period, period * np.exp(-values[Column.BALL_SWING])])


DISSIPATED_BELOW = 0.1
"""With less than this share of the energy left, losses have ended the burst."""
AT_REST_SHARE = 0.02
"""A velocity within this share of the first one is as good as none."""


def energy_kept(paths: Paths, values: Floats) -> Floats:
    """Energy after each collision over that before the first, shape (events,).

    Kinetic and, on the threads, potential energy of both bodies, in units of the heavy mass.
    """
    after = _energy(paths, values, paths.states[:, 0, 1:])
    start = _energy(paths, values, paths.before[:, 0, 1:2])
    return np.asarray(after / start)


def _energy(paths: Paths, values: Floats, states: Floats) -> Floats:
    rate, rest, ball_rate, ball_rest = paths.laws[:, 0]
    heavy, heavy_velocity, ball, ball_velocity = states
    swung, ball_swung = rate * (heavy - rest), ball_rate * (ball - ball_rest)
    light = np.exp(values[Column.LIGHTNESS]) * (ball_velocity**2 + ball_swung**2)
    return np.asarray(heavy_velocity**2 + swung**2 + light) / 2


def ending_of(paths: Paths, values: Floats) -> Ending:
    """How the burst ended, by its state after the last collision."""
    kept = float(energy_kept(paths, values)[-1])
    first = abs(float(paths.before[1, 0, 1]))
    heavy, ball = float(paths.states[1, 0, -1]) / first, float(paths.states[3, 0, -1]) / first
    kind: EndingKind = "pendulum"
    if kept < DISSIPATED_BELOW:
        kind = "dissipative"
    elif -AT_REST_SHARE <= ball <= heavy + AT_REST_SHARE:
        kind = "geometric"
    return Ending(kind, kept, heavy, ball)


def left_out_of(observed: Observations, values: Floats) -> LeftOut | None:
    """Frames left out that a fit found besides those that the track allows for."""
    frames = round(values[Column.SKIP])
    if frames == 0:
        return None
    before = observed.frame[observed.after == 0]
    return LeftOut(observed.origin + float(before[-1]), frames)


SAME_SIGMAS = 3.0
"""A modelled collision is the one seen if they are not further apart than so many times their
uncertainty: in a zigzag of which corners are missing the others are not where they seem, ..."""
SAME_FRAMES = 0.5
"""... or, where the frames resolve it, than so many frames, ..."""
SAME_SHARE = 0.5
"""... and never further than this share of the way to the next one."""


def collisions_of(
    observed: Observations, fits: Sequence[Solution], shares: Floats, found: SeenCollisions
) -> tuple[Collision, ...]:
    """Collisions of a burst by fits with one count, numbered from 1."""
    events = [_events(observed, fit) for fit in fits]
    # What never happens lies at infinity: such a fit has no part in a mean, or is all there is.
    happens = np.array([np.isfinite(values).all() for values, _ in events])
    likeliest = int(np.argmax(shares))
    values, sigmas = events[likeliest]
    if happens.any():
        kept = [event for event, finite in zip(events, happens, strict=True) if finite]
        each, spread = (np.array(part) for part in zip(*kept, strict=True))
        values, sigmas = mixed(shares[happens] / shares[happens].sum(), each, spread**2)
    rows = zip(values, sigmas, strict=True)
    modelled = [_modelled(observed.sign, event, *row) for event, row in enumerate(rows)]
    hidden = np.zeros(len(modelled), dtype=bool)
    gap = left_out_of(observed, fits[likeliest].values)
    if gap is not None:
        base = gap.time_base(observed.origin + observed.frame)
        hidden = base.in_gap(values[:, 0])
        modelled = [base.shown(collision) for collision in modelled]
    return _confirmed(
        modelled, hidden, [one for one in found.collisions[: found.burst] if one.seen]
    )


def _events(observed: Observations, solution: Solution) -> tuple[Floats, Floats]:
    """Time, state before and state after each event, and their uncertainties; (events, 9) each."""
    paths = follow(solution.values[None], solution.count, float(observed.frame[0]) - 1.0)
    tangents = tangents_of(paths, solution.values)
    covariance = np.linalg.pinv(solution.hessian, hermitian=True)
    sigmas = []
    for jacobian in (tangents.time[:, None], tangents.arriving, tangents.states[1:]):
        known = np.where(np.isfinite(jacobian), jacobian, 0.0)
        variances = np.einsum("...p,pq,...q->...", known, covariance, known, optimize=True)
        sigmas.append(np.sqrt(np.maximum(variances, 0.0)))
    frames = observed.origin + paths.time[0, 1:]
    values = (frames[:, None], paths.before[:, 0, 1:].T, paths.states[:, 0, 1:].T)
    return np.hstack(values), np.hstack(sigmas)


def _modelled(sign: int, event: int, values: Floats, sigmas: Floats) -> Collision:
    """One collision by the model, in whose motion all frames share."""
    # After the time come place and velocity of the heavy body and those of the ball, before and
    # after the event.
    before, after = (
        Velocities(
            ball_px_frame=sign * float(values[first + 3]),
            heavy_px_frame=sign * float(values[first + 1]),
            ball_sigma_px_frame=float(sigmas[first + 3]),
            heavy_sigma_px_frame=float(sigmas[first + 1]),
        )
        for first in (1, 5)
    )
    return Collision(
        number=event + 1,
        kind="wall" if event % 2 else "bodies",
        frame=float(values[0]),
        frame_sigma=float(sigmas[0]),
        time_s=None,
        seen=False,
        position_px=sign * float(values[7]),
        velocity_before=before,
        velocity_after=after,
    )


def _confirmed(
    modelled: Sequence[Collision], hidden: NDArray[np.bool_], seen: Sequence[Collision]
) -> tuple[Collision, ...]:
    """Let frames confirm the collisions that they show, but for those that must be ``hidden``.

    The time is the mean of both, weighted by their precisions. Where they differ by more than their
    uncertainties, something else acted there or frames misled, and the mean is less sure by the
    Birge ratio (Birge 1932).
    """
    # What never happens lies at infinity, and may do so more than once.
    frames = np.minimum([one.frame for one in modelled], np.finfo(np.float64).max)
    apart = np.diff(frames, prepend=-np.inf, append=np.inf)
    shares = SAME_SHARE * np.minimum(apart[:-1], apart[1:])
    # No frame is clear of its neighbours on either side of it: the exposures hold them all.
    hidden = hidden | (np.maximum(apart[:-1], apart[1:]) < 2 * HALF_EXPOSURE)
    confirmed = []
    for one, share, unseen in zip(modelled, shares.tolist(), hidden, strict=True):
        least = SAME_FRAMES if share >= SAME_SHARE * RESOLVED_FRAMES else 0.0
        same = [other for other in seen if other.kind == one.kind and not unseen]
        partner = min(same, key=lambda other: abs(other.frame - one.frame), default=one)
        off = partner.frame - one.frame
        sigma = float(np.hypot(one.frame_sigma, partner.frame_sigma))
        if partner is one or abs(off) > min(share, max(least, SAME_SIGMAS * sigma)):
            confirmed.append(one)
            continue
        frame = one.frame + off * one.frame_sigma**2 / sigma**2
        # Both rest on the same frames, so that the mean is no surer than the better one.
        surest = min(one.frame_sigma, partner.frame_sigma) * max(1.0, abs(off) / sigma)
        confirmed.append(replace(one, frame=frame, frame_sigma=surest, seen=True))
    return tuple(confirmed)

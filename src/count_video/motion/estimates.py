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
from typing import NamedTuple

import numpy as np

from count_video.motion.observations import Observations
from count_video.motion.parameters import Column
from count_video.motion.pendulums import Paths, follow_one
from count_video.motion.pieces import HALF_EXPOSURE
from count_video.motion.posterior import Weighed, draws_of
from count_video.motion.resolution import RESOLVED_FRAMES
from count_video.motion.seen import SeenCollisions
from count_video.motion.solving import Solution
from count_video.motion.tangents import tangents_of
from count_video.records import (
    Collision,
    CollisionKind,
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


class _Arrangement(NamedTuple):
    gap_px: Floats
    release_px: Floats
    bodies_gap_px: Floats
    heavy_period_frames: Floats
    ball_period_frames: Floats


def fitted_setup(weighed: Weighed, shares: Floats) -> FittedSetup:
    """Mean and standard uncertainty of the set-up over all fits, of which each has its share."""
    fits = [fit for _, fit in weighed.values()]
    values = np.array([_arranged(fit.values) for fit in fits])
    variances = np.array([np.var(_arranged(draws_of(fit).T), axis=1) for fit in fits])
    mean, sigma = mixed(shares, values, variances)
    return FittedSetup(*(Estimate(float(m), float(s)) for m, s in zip(mean, sigma, strict=True)))


def _arranged(values: Floats) -> _Arrangement:
    """Derive the set-up from parameters, shape (columns,) or (columns, sets)."""
    rate = np.exp(values[Column.SWING])
    from_rest = -values[Column.HEAVY_PULL] / rate**2
    rest = values[Column.HEAVY] - from_rest
    period = 2.0 * np.pi / rate
    return _Arrangement(
        gap_px=values[Column.BALL_REST] - values[Column.WALL],
        release_px=np.hypot(from_rest, values[Column.HEAVY_RATE] / rate),
        bodies_gap_px=rest - values[Column.BALL_REST],
        heavy_period_frames=period,
        ball_period_frames=period * np.exp(-values[Column.BALL_SWING]),
    )


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
    laws = paths.pendulums
    heavy, heavy_velocity, ball, ball_velocity = states
    swung = laws.heavy_rate[0] * (heavy - laws.heavy_rest[0])
    ball_swung = laws.ball_rate[0] * (ball - laws.ball_rest[0])
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
    values, sigmas = events[int(np.argmax(shares))]
    if happens.any():
        kept = [event for event, finite in zip(events, happens, strict=True) if finite]
        each, spread = (np.array(part) for part in zip(*kept, strict=True))
        values, sigmas = mixed(shares[happens] / shares[happens].sum(), each, spread**2)
    partners = _partners(values[:, 0], sigmas[:, 0], found.collisions[: found.burst])
    begin, end = _left_out(observed, fits[int(np.argmax(shares))].values)
    for event in np.flatnonzero((values[:, 0] > begin) & (values[:, 0] < end)):
        partners.pop(int(event), None)
    return tuple(
        _collision(observed.sign, event, (values[event], sigmas[event]), partners.get(event))
        for event in range(len(values))
    )


def _events(observed: Observations, solution: Solution) -> tuple[Floats, Floats]:
    """Time, state before and state after each event, and their uncertainties; (events, 9) each."""
    paths = follow_one(solution.values, solution.count, float(observed.frame[0]) - 1.0)
    time, before, after = _sigmas(solution, paths)
    frames, time = _shown(observed, solution.values, (paths.time[0, 1:], time))
    values = (frames[:, None], paths.before[:, 0, 1:].T, paths.states[:, 0, 1:].T)
    return np.hstack(values), np.hstack([time[:, None], before, after])


def _left_out(observed: Observations, values: Floats) -> tuple[float, float]:
    """Frames before and after the place where others are left out; inf where none are."""
    gap = np.flatnonzero(np.diff(observed.after))
    if len(gap) == 0 or not values[Column.SKIP]:
        return np.inf, np.inf
    begin, end = observed.origin + observed.frame[gap[0] : gap[0] + 2]
    return float(begin), float(end)


def _shown(
    observed: Observations, values: Floats, when: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Give times and uncertainties by the frames that are there, where others are left out."""
    begin, end = _left_out(observed, values)
    times, sigmas = observed.origin + when[0], when[1]
    if np.isinf(begin):
        return times, sigmas
    skip, since, there = values[Column.SKIP], times - begin, end - begin
    inside = (since > 0) & (since < there + skip)
    shown = np.where(since > 0, since - skip, since)
    shown[inside] = since[inside] * there / (there + skip)
    return begin + shown, np.where(inside, np.maximum(sigmas, SAME_FRAMES * there), sigmas)


def _sigmas(solution: Solution, paths: Paths) -> list[Floats]:
    """Give the standard uncertainties of the events.

    Returns
    -------
    list
        Of the times, shape (events,); of the state before and of that after, shape (events, 4).
    """
    tangents = tangents_of(paths, solution.values)
    covariance = np.linalg.pinv(solution.hessian, hermitian=True)
    sigmas = []
    for jacobian in (tangents.time, tangents.arriving, tangents.states[1:]):
        known = np.where(np.isfinite(jacobian), jacobian, 0.0)
        variances = np.einsum("...p,pq,...q->...", known, covariance, known, optimize=True)
        sigmas.append(np.asarray(np.sqrt(np.maximum(variances, 0.0))))
    return sigmas


def _partners(frames: Floats, sigmas: Floats, seen: Sequence[Collision]) -> dict[int, Collision]:
    """Find the collision seen for each modelled one, as far as there is one; nearest first."""
    # What never happens lies at infinity, and may do so more than once.
    apart = np.diff(np.minimum(frames, np.finfo(np.float64).max), prepend=-np.inf, append=np.inf)
    share = SAME_SHARE * np.minimum(apart[:-1], apart[1:])
    # No frame is clear of its neighbours on either side of it: the exposures hold them all.
    hidden = np.maximum(apart[:-1], apart[1:]) < 2 * HALF_EXPOSURE
    pairs = []
    for event, frame in enumerate(frames):
        if hidden[event]:
            continue
        for place, collision in enumerate(seen):
            sigma = float(np.hypot(sigmas[event], collision.frame_sigma))
            least = SAME_FRAMES if share[event] >= SAME_SHARE * RESOLVED_FRAMES else 0.0
            reach = min(share[event], max(least, SAME_SIGMAS * sigma))
            apart = abs(collision.frame - frame)
            if collision.seen and collision.kind == _kind(event) and apart <= reach:
                pairs.append((apart, event, place))
    pairs.sort()
    partners: dict[int, Collision] = {}
    used: set[int] = set()
    for _, event, place in pairs:
        if event not in partners and place not in used:
            partners[event] = seen[place]
            used.add(place)
    return partners


def _kind(event: int) -> CollisionKind:
    return "wall" if event % 2 else "bodies"


def _collision(
    sign: int, event: int, known: tuple[Floats, Floats], partner: Collision | None
) -> Collision:
    """One collision: by the model, in whose motion all frames share, and as its frames show it.

    Its time is the mean of both, weighted by their precisions. Where they differ by more than their
    uncertainties, something else acted there or frames misled, and the mean is less sure by the
    Birge ratio (Birge 1932).
    """
    values, sigmas = known
    frame, sigma = values[0], sigmas[0]
    if partner is not None:
        share = sigma**2 / (sigma**2 + partner.frame_sigma**2)
        apart = partner.frame - frame
        birge = abs(apart) / np.hypot(sigma, partner.frame_sigma)
        frame += share * apart
        # Both rest on the same frames, so that the mean is no surer than the better one.
        sigma = min(sigma, partner.frame_sigma) * max(1.0, birge)
    heavy, ball = slice(2, None, 4), slice(4, None, 4)
    before, after = (
        Velocities(*each)
        for each in zip(
            (sign * values[ball]).tolist(),
            (sign * values[heavy]).tolist(),
            sigmas[ball].tolist(),
            sigmas[heavy].tolist(),
            strict=True,
        )
    )
    return Collision(
        number=event + 1,
        kind=_kind(event),
        frame=float(frame),
        frame_sigma=float(sigma),
        time_s=None,
        seen=partner is not None,
        position_px=sign * float(values[7]),
        velocity_before=before,
        velocity_after=after,
    )

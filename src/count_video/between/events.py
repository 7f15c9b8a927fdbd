"""From a fitted model to the collisions of the burst, those that the frames show marked so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from count_video.between.model import Paths, follow_one
from count_video.between.observations import Observations
from count_video.between.solving import Solution
from count_video.between.tangents import tangents_of
from count_video.motion.seen import SeenCollisions
from count_video.records import Collision, CollisionKind, Floats, Velocities

SAME_FRAMES = 0.5
"""A modelled collision is the one seen if they are not further apart than this, ..."""
SAME_SIGMAS = 3.0
"""... or so many times their uncertainty, ..."""
SAME_SHARE = 0.5
"""... but never further than this share of the way to the next one."""


def collisions_of(
    observed: Observations, solution: Solution, found: SeenCollisions
) -> tuple[Collision, ...]:
    """Collisions of the fitted burst, numbered from 1."""
    start = float(observed.frame[0]) - 1.0
    paths = follow_one(solution.values, solution.count, start)
    frames = observed.origin + paths.time[0, 1:]
    sigmas, *state_sigmas = _sigmas(solution, paths)
    partners = _partners(frames, sigmas, found.collisions[: found.burst])
    return tuple(
        _with_sigmas(
            _collision(observed, paths, event, (frames[event], sigmas[event]), partners.get(event)),
            *(state_sigma[event] for state_sigma in state_sigmas),
        )
        for event in range(solution.count)
    )


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


def _with_sigmas(collision: Collision, before: Floats, after: Floats) -> Collision:
    """Give velocities the uncertainties of their states: the heavy body's 2nd, the ball's 4th."""

    def known(velocities: Velocities, state: Floats) -> Velocities:
        ball, heavy = float(state[3]), float(state[1])
        return replace(velocities, ball_sigma_px_frame=ball, heavy_sigma_px_frame=heavy)

    return replace(
        collision,
        velocity_before=known(collision.velocity_before, before),
        velocity_after=known(collision.velocity_after, after),
    )


def _partners(frames: Floats, sigmas: Floats, seen: Sequence[Collision]) -> dict[int, Collision]:
    """Find the collision seen for each modelled one, as far as there is one; nearest first."""
    # What never happens lies at infinity, and may do so more than once.
    room = np.diff(np.minimum(frames, np.finfo(np.float64).max), prepend=-np.inf, append=np.inf)
    share = SAME_SHARE * np.minimum(room[:-1], room[1:])
    pairs = []
    for event, frame in enumerate(frames):
        for place, collision in enumerate(seen):
            sigma = float(np.hypot(sigmas[event], collision.frame_sigma))
            reach = min(share[event], max(SAME_FRAMES, SAME_SIGMAS * sigma))
            apart = abs(collision.frame - frame)
            if collision.kind == _kind(event) and apart <= reach:
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
    observed: Observations,
    paths: Paths,
    event: int,
    when: tuple[float, float],
    partner: Collision | None,
) -> Collision:
    """One collision; its time is the seen one where there is one, the rest is the model's."""
    before, after = paths.before[:, 0, event + 1], paths.states[:, 0, event + 1]
    sign = observed.sign
    frame, sigma = when if partner is None else (partner.frame, partner.frame_sigma)
    return Collision(
        number=event + 1,
        kind=_kind(event),
        frame=float(frame),
        frame_sigma=float(sigma),
        time_s=None,
        seen=partner is not None,
        position_px=sign * float(after[2]),
        velocity_before=Velocities(sign * float(before[3]), sign * float(before[1])),
        velocity_after=Velocities(sign * float(after[3]), sign * float(after[1])),
    )

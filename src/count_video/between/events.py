"""From a fitted model to the collisions of the burst, those that the frames show marked so."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from count_video.between.model import Paths, follow_one
from count_video.between.observations import Observations
from count_video.between.solving import Solution
from count_video.between.tangents import tangents_of
from count_video.motion.pieces import HALF_EXPOSURE
from count_video.motion.resolution import RESOLVED_FRAMES
from count_video.motion.seen import SeenCollisions
from count_video.records import Collision, CollisionKind, Floats, Velocities

SAME_SIGMAS = 3.0
"""A modelled collision is the one seen if they are not further apart than so many times their
uncertainty: in a zigzag of which corners are missing the others are not where they seem, ..."""
SAME_FRAMES = 0.5
"""... or, where the frames resolve it, than so many frames, ..."""
SAME_SHARE = 0.5
"""... and never further than this share of the way to the next one."""


def collisions_of(
    observed: Observations, solution: Solution, found: SeenCollisions
) -> tuple[Collision, ...]:
    """Collisions of the fitted burst, numbered from 1."""
    start = float(observed.frame[0]) - 1.0
    paths = follow_one(solution.values, solution.count, start)
    frames = observed.origin + paths.time[0, 1:]
    sigmas = _time_sigmas(solution, paths)
    partners = _partners(frames, sigmas, found.collisions[: found.burst])
    return tuple(
        _collision(observed, paths, event, (frames[event], sigmas[event]), partners.get(event))
        for event in range(solution.count)
    )


def _time_sigmas(solution: Solution, paths: Paths) -> Floats:
    """Give the standard uncertainties of the event times, shape (events,)."""
    times = tangents_of(paths, solution.values).time
    jacobian = np.where(np.isfinite(times), times, 0.0)
    covariance = np.linalg.pinv(solution.hessian, hermitian=True)
    variances = np.einsum("ep,pq,eq->e", jacobian, covariance, jacobian, optimize=True)
    return np.asarray(np.sqrt(np.maximum(variances, 0.0)))


def _partners(frames: Floats, sigmas: Floats, seen: Sequence[Collision]) -> dict[int, Collision]:
    """Find the collision seen for each modelled one, as far as there is one; nearest first."""
    # What never happens lies at infinity, and may do so more than once.
    room = np.diff(np.minimum(frames, np.finfo(np.float64).max), prepend=-np.inf, append=np.inf)
    share = SAME_SHARE * np.minimum(room[:-1], room[1:])
    # No frame is clear of its neighbours on either side of it: the exposures hold them all.
    hidden = np.maximum(room[:-1], room[1:]) < 2 * HALF_EXPOSURE
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
    observed: Observations,
    paths: Paths,
    event: int,
    when: tuple[float, float],
    partner: Collision | None,
) -> Collision:
    """One collision by the model; its time is the seen one where that contradicts the model's.

    The model knows more, as all frames share its motion, and is wrong where something else acted.
    """
    before, after = paths.before[:, 0, event + 1], paths.states[:, 0, event + 1]
    sign = observed.sign
    frame, sigma = when
    if partner is not None:
        apart = abs(partner.frame - frame)
        if apart > SAME_SIGMAS * np.hypot(sigma, partner.frame_sigma):
            frame, sigma = partner.frame, partner.frame_sigma
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

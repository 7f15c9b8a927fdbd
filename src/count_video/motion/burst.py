"""The burst that counts: where it begins, where it ends, and whether the clip shows all of it.

It begins with the first contact of the heavy body with the ball at rest. It ends when the heavy
body, driven back, turns round again. A clip supports a count if it shows the ball at rest before,
and either that turn or, at its end, bodies that part and no wall that the ball could reach before.

What follows the clip's last frame is left to the fit of the whole burst, which knows the threads:
here a clip ends too early if the velocities after the last collision lead to another one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from count_video.motion.gaps import Gaps
from count_video.reasons import Cause, Reason
from count_video.records import Collision
from count_video.signals import low_points, running_median, sigma_of

AT_REST_SHARE = 0.3
"""A ball slower than this share of the approach speed is at rest before the first collision; in
the midst of a burst it is never slower than the heavy body itself, ..."""
REST_SIGMAS = 1.5
"""... so that it has half the approach speed at least. A speed that is 0 lies so many standard
uncertainties from that: a likelihood ratio of 3 for rest; and one clip of thirty, at most, begins
that late."""
CLEAR_VELOCITY_SIGMAS = 4.0
"""A velocity or a change of it counts from this many standard uncertainties on."""
TURN_SIGMAS = 12.0
"""The heavy body has turned round when it came back by so many standard deviations."""
TURN_AT_LEAST_PX = 1.0


def find_burst(collisions: Sequence[Collision], gaps: Gaps) -> tuple[int, tuple[Reason, ...]]:
    """Find the first burst among collisions in order of time.

    Returns how many collisions belong to it, and why the clip does not support a count, if so.
    """
    end = turn_round(gaps, collisions)
    inside = [c for c in collisions if c.frame <= end]
    goes_on = bool(inside) and not np.isfinite(end) and _may_go_on(inside, gaps.sign)
    causes = (_beginning(inside), Cause.ENDS_WITHIN if goes_on else None)
    return len(inside), tuple(Reason(cause) for cause in causes if cause)


def turn_round(gaps: Gaps, collisions: Sequence[Collision]) -> float:
    """Frame at which the heavy body, driven back, turns toward the wall again; inf if never.

    It is driven back from where it is nearest to the wall after the first collision. The furthest
    of many noisy places says little about when: it is put after collisions nearby at which the
    heavy body still moves away. A body that leaves the picture is misplaced in its last places.
    """
    seen = np.isfinite(gaps.heavy_px)
    if not seen.any():
        return float("inf")
    depth = max(TURN_AT_LEAST_PX, TURN_SIGMAS * sigma_of(gaps.heavy_px))
    frame, place_px = gaps.frame[seen], running_median(gaps.heavy_px[seen])
    near, away = frame[low_points(place_px, depth)], -place_px
    first = collisions[0].frame if collisions else np.inf
    nearest = near[near >= first].min(initial=np.inf)
    turns = low_points(np.where(frame > nearest, away, np.nan), depth)
    if len(turns) == 0:
        return float("inf")
    turn = float(frame[turns[0]])
    back = frame[(away > away[turns[0]] + depth) & (frame > turn)].min(initial=np.inf)
    for one in collisions:
        before = one.velocity_before
        leaves = gaps.sign * before.heavy_px_frame
        if one.frame < back and leaves > CLEAR_VELOCITY_SIGMAS * before.heavy_sigma_px_frame:
            turn = max(turn, one.frame)
    return turn


def _beginning(inside: Sequence[Collision]) -> Cause | None:
    if not inside:
        return None
    first = inside[0]
    if first.kind == "wall":
        return Cause.STARTS_MOVING
    before = first.velocity_before
    speed, sigma = abs(before.ball_px_frame), before.ball_sigma_px_frame
    approach = abs(before.heavy_px_frame - before.ball_px_frame)
    approach = approach if np.isfinite(approach) else np.inf
    if speed - CLEAR_VELOCITY_SIGMAS * sigma > AT_REST_SHARE * approach:
        return Cause.STARTS_LATE
    too_slow = max(approach / 2 - speed, 0.0)
    at_rest = too_slow**2 - speed**2 > (REST_SIGMAS * sigma) ** 2
    return None if at_rest else Cause.STARTS_CLOSE


def _may_go_on(inside: Sequence[Collision], sign: int) -> bool:
    """Whether another collision may follow: not where the bodies part and leave the wall.

    A heavy body that is not seen any more goes on as it was last seen: where it turns round later,
    the burst is over.
    """
    seen = [one for one in inside if np.isfinite(one.velocity_after.heavy_px_frame)]
    after, parted = inside[-1].velocity_after, (seen or inside)[-1].velocity_after
    ball, heavy = sign * after.ball_px_frame, sign * parted.heavy_px_frame
    sigmas = np.array([after.ball_sigma_px_frame, parted.heavy_sigma_px_frame])
    unsure = CLEAR_VELOCITY_SIGMAS * sigmas
    leave = ball >= -unsure[0] and heavy >= -unsure[1]
    return not (leave and heavy - ball >= -np.hypot(*unsure))

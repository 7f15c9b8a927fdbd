"""The burst that counts: where it begins, where it ends, and whether the clip shows all of it.

It begins with the first contact of the heavy body with the ball at rest. It ends when the heavy
body, driven back, turns round again. A clip supports a count if it shows the ball at rest before,
and either that turn or, at its end, bodies that part and no wall that the ball could reach before.

Of two collisions shortly before and after the turn, the first belongs to the burst and the second
does not. The heavy body's places hardly show which, for near the turn it stands still; its fitted
velocity before the collision does. Where even that leaves it open, the fit of the whole burst gives
the chance of either.

What follows the clip's last frame is left to the fit of the whole burst, which knows the threads:
here a clip ends too early if the velocities after the last collision lead to another one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from count_video.motion.contacts import Contacts
from count_video.motion.gaps import Gaps
from count_video.reasons import Cause, Reason
from count_video.records import Collision
from count_video.signals import low_points, sigma_of

AT_REST_SHARE = 0.3
"""A ball slower than this share of the approach speed is at rest before the first collision; in
the midst of a burst it is never slower than the heavy body itself, ..."""
REST_SIGMAS = 1.5
"""... so that it has half the approach speed at least. A speed that is 0 lies so many standard
uncertainties from that: a likelihood ratio of 3 for rest; and one clip of thirty, at most, begins
that late."""
SIGMAS = 4.0
"""A velocity or a change of it counts from this many standard uncertainties on."""
TURN_SIGMAS = 12.0
"""The heavy body has turned round when it came back by so many standard deviations."""
TURN_AT_LEAST_PX = 1.0


def find_burst(
    collisions: Sequence[Collision], contacts: Contacts, gaps: Gaps
) -> tuple[int, tuple[Reason, ...]]:
    """Find the first burst among collisions in order of time, and their fitted contacts.

    Returns how many collisions belong to it, and why the clip does not support a count, if so.
    """
    end = turn_round(gaps, contacts)
    inside = [c for c in collisions if c.frame <= end]
    goes_on = bool(inside) and not np.isfinite(end) and _may_go_on(contacts, len(inside) - 1)
    causes = (_beginning(inside, contacts), Cause.ENDS_WITHIN if goes_on else None)
    return len(inside), tuple(Reason(cause) for cause in causes if cause)


def turn_round(gaps: Gaps, contacts: Contacts) -> float:
    """Frame at which the heavy body, driven back, turns toward the wall again; inf if never.

    It is driven back from where it is nearest to the wall after the first contact. The furthest of
    many noisy places says little about when: it is put after collisions nearby at which the heavy
    body still moves away.
    """
    depth, away = max(TURN_AT_LEAST_PX, TURN_SIGMAS * sigma_of(gaps.heavy_px)), -gaps.heavy_px
    near = gaps.frame[low_points(gaps.heavy_px, depth)]
    nearest = near[near >= contacts.frame.min(initial=np.inf)].min(initial=np.inf)
    turns = low_points(np.where(gaps.frame > nearest, away, np.nan), depth)
    if len(turns) == 0:
        return float("inf")
    turn = turns[0]
    back = gaps.frame[(away > away[turn] + depth) & (gaps.frame > gaps.frame[turn])]
    rate, sigma = contacts.rate[:, 0, 1], contacts.rate_sigma[:, 0, 1]
    leaving = (contacts.frame < back.min(initial=np.inf)) & (rate > SIGMAS * sigma)
    return max(float(gaps.frame[turn]), float(contacts.frame[leaving].max(initial=-np.inf)))


def _beginning(inside: Sequence[Collision], contacts: Contacts) -> Cause | None:
    if not inside:
        return None
    first = inside[0]
    if first.kind == "wall":
        return Cause.STARTS_MOVING
    speed, sigma = abs(contacts.rate[0, 0, 0]), contacts.rate_sigma[0, 0, 0]
    approach = _approach(first)
    if speed - SIGMAS * sigma > AT_REST_SHARE * approach:
        return Cause.STARTS_LATE
    too_slow = max(approach / 2 - speed, 0.0)
    at_rest = too_slow**2 - speed**2 > (REST_SIGMAS * sigma) ** 2
    return None if at_rest else Cause.STARTS_CLOSE


def _approach(first: Collision) -> float:
    """Speed at which the bodies close in before the first collision; inf if it is not shown."""
    speed = abs(first.velocity_before.heavy_px_frame - first.velocity_before.ball_px_frame)
    return speed if np.isfinite(speed) else np.inf


def _may_go_on(contacts: Contacts, last: int) -> bool:
    """Whether another contact may follow one: not where the bodies part and leave the wall."""
    ball, heavy = contacts.rate[last, 1]
    unsure = SIGMAS * contacts.rate_sigma[last, 1]
    leave = ball >= -unsure[0] and heavy >= -unsure[1]
    return not (leave and heavy - ball >= -np.hypot(*unsure))

"""What came before the first impact that is seen: a blow, or impacts that no picture shows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from count_video.motion.corners import CERTAIN_LOG_ODDS, Impact
from count_video.motion.flight import HYSTERESIS_SIGMAS, LAW_SHARE, LAW_SIGMAS, Motion
from count_video.motion.priors import CHANCE_CLEAR, CHANCE_UNSEEN, FLIGHT_FACTOR
from count_video.records import Collision, Floats, Velocities

STARTS, FINER = np.arange(-24.0, 1.25, 0.25), np.linspace(-0.25, 0.25, 51)
"""When a body at rest was set in motion, in pictures from that which first shows it; the best of
them is sought again in finer steps, for a small error of it looks like a slow blow later on."""
PICTURES_AT_LEAST = 4
"""Fewer at rest, or in motion, show no blow."""


@dataclass(frozen=True)
class Blow:
    """What sets a body in motion that was at rest."""

    frame: float
    """Frame coordinate, in pictures."""
    velocity: float
    """That it gives the body, in px per picture."""


def struck_at_rest(motion: Motion, until: float) -> Blow | None:
    """Find the blow that sets a body in motion which was at rest when the clip began.

    Let go, or led by a hand, it gathers speed over some pictures; a blow gives it all at once:

        x(t) = p + v s + a s^2 / 2,     s = max(t - t0, 0),     v = 0 without a blow.

    Only what comes before the frame ``until`` is judged. None if there was no such blow: if one is
    not far likelier, does not describe the start either, as where a hand throws, or takes the body
    less far than its acceleration does.
    """
    rows = np.flatnonzero(np.isfinite(motion.place_px) & (motion.frame < until))
    if len(rows) < 2 * PICTURES_AT_LEAST:
        return None
    rest = np.median(motion.place_px[rows[:PICTURES_AT_LEAST]])
    away = np.abs(motion.place_px[rows] - rest) > HYSTERESIS_SIGMAS * motion.sigma_px
    gone = np.lib.stride_tricks.sliding_window_view(away, PICTURES_AT_LEAST).all(axis=1)
    begin = motion.frame[rows[max(int(np.argmax(gone)) - 1, 0)]]
    rows = rows[np.abs(motion.frame[rows] - begin) <= -STARTS[0]]
    time, place = motion.frame[rows] - begin, motion.place_px[rows]
    if min((time < 0).sum(), (time > 0).sum()) < PICTURES_AT_LEAST:
        return None
    (_, _, smooth), (start, velocity, struck) = (_start(time, place, k) for k in (2, 3))
    noise = motion.sigma_px**2
    log_ratio = len(time) / 2 * np.log((smooth + noise) / (struck + noise))
    described = struck / len(time) < max(LAW_SIGMAS**2 * noise, LAW_SHARE**2 * np.var(place))
    way = place[-1] - place[0]
    sent = velocity * (time[-1] - start) * np.sign(way) > abs(way) / 2
    if log_ratio < CERTAIN_LOG_ODDS or not (described and sent):
        return None
    return Blow(float(begin + start), velocity)


def _start(time: Floats, place_px: Floats, columns: int) -> tuple[float, float, float]:
    """When a body was set in motion, by the first columns of the law.

    The last coefficient and the sum of squares that is left over come with it.
    """
    start, last, left_over = 0.0, 0.0, np.inf
    for starts in (STARTS, FINER):
        since = np.maximum(time - start - starts[:, None], 0.0)
        law = np.stack([np.ones_like(since), since**2, since], axis=2)[..., :columns]
        away = (place_px - place_px[0])[:, None]
        solution = np.linalg.pinv(law) @ away
        squares = ((away - law @ solution) ** 2).sum(axis=(1, 2))
        best = int(np.argmin(squares))
        start += float(starts[best])
        last, left_over = float(solution[best, -1, 0]), float(squares[best])
    return start, last, left_over


@dataclass(frozen=True)
class Unseen:
    """An impact before the first one that is seen, or after the last, that no picture shows."""

    frame: float
    """Frame coordinate, in pictures, at which the flight next to it would begin, or end."""
    frame_sigma: float
    """Its standard uncertainty."""
    chance: float
    """Probability that there was one."""
    likely: bool
    """Whether it is more probable than not, and at the stop of the one that is seen."""


def before_first(motion: Motion, impacts: Sequence[Impact]) -> list[Unseen]:
    """Find impacts before the first one that may lie in pictures that do not show the body.

    There the flight that ends at the first impact would have to begin, and no sooner; the flights
    before it are longer, as one impact takes the same share of the speed as the next. A body that
    is seen next on its way away from the stop has most probably been there; surely if it was seen
    before as well, for by that flight it would have come through the stop.
    """
    first, flights = impacts[0], np.diff([impact.frame for impact in impacts])
    pull = first.side * motion.acceleration
    came, left = first.side * first.before, -first.side * first.after
    rests = np.isfinite(motion.place_px) & ~motion.moving & (motion.frame < first.frame)
    if came <= 0 or rests.any():  # what is let go comes from no impact
        return []
    kept = min(1.0, left / came) if left > 0 else 1.0
    back = 2 * came / pull if pull > 0 else np.inf
    if len(impacts) > 1 and impacts[1].side == first.side:
        back = float(flights[0]) / kept
    same_stop = bool(np.isfinite(back))
    back = min(back, FLIGHT_FACTOR * flights.max(initial=0.0) or back)
    following = motion.frame[np.isfinite(motion.place_px) & (motion.frame < first.frame)]
    last = np.append(motion.frame[0] - 1.0, following[:-1])
    found: list[Unseen] = []
    ends, all_later = first.frame, 1.0
    while (begins := ends - back) >= motion.frame[0] - 1.0:
        unseen = (following - last > 1.0) & (last <= begins + 1.0) & (begins < following)
        if not unseen.any():
            break
        until, since = following[unseen][-1], last[unseen][-1]
        away = until - begins < ends - until
        chance = CHANCE_UNSEEN
        if away:
            chance = CHANCE_CLEAR if since in following else 1 - CHANCE_UNSEEN
        all_later *= chance  # none comes before one that did not happen
        sigma = float(until - since) / math.sqrt(12.0)  # it lies anywhere in between
        found.append(Unseen(float(begins), sigma, all_later, same_stop and all_later > 0.5))
        ends, back = begins, back / kept
    return found


def inferred(unseen: Unseen, shown: Collision) -> Collision:
    """Make a collision, in pictures, of an impact at the stop of one that is seen."""
    unknown = Velocities(np.nan, np.nan)
    return replace(
        shown,
        frame=unseen.frame,
        frame_sigma=unseen.frame_sigma,
        seen=False,
        velocity_before=unknown,
        velocity_after=unknown,
    )

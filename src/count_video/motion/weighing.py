"""What speaks for the impacts found in a clip, what is in doubt, and why it supports no count.

Every impact and every doubt is one independent chance. The count's probabilities are those of their
sum.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import astuple
from itertools import pairwise, takewhile

import numpy as np

from count_video.motion.beginnings import Unseen, inferred, struck_at_rest
from count_video.motion.burst import CLEAR_VELOCITY_SIGMAS
from count_video.motion.corners import CERTAIN_LOG_ODDS, Impact
from count_video.motion.flight import (
    HYSTERESIS_SIGMAS,
    PULL_SHARE,
    Motion,
)
from count_video.motion.gaps import UNSEEN_FRAMES
from count_video.motion.priors import (
    CHANCE_CLEAR,
    CHANCE_CUT_OFF,
    CHANCE_DYING,
    CHANCE_UNSEEN,
    CHANCES_LOST,
    FLIGHT_FACTOR,
)
from count_video.motion.seen import RESOLVED_FRAMES, SeenCollisions
from count_video.motion.time_base import in_frames
from count_video.reasons import Cause, Reason
from count_video.records import Collision, Floats, Mask, Velocities

CERTAIN_PICTURES = 4
"""One impact at least shows itself by so many pictures on either side, as certain as can be."""
CHANCE_AT_LEAST = 0.005
"""Less probable counts, and less probable impacts, are left out."""
GAIN_FACTOR = 1.1
"""No stop at rest gives a body a higher speed than it had; an oblique view and a lens change a
speed by less than a tenth from one flight to the next."""
TAIL_PICTURES = 4.0
"""A flight shorter than this holds too few pictures clear of its ends to show its impacts."""
FLIGHTS_AT_LEAST = 3
"""Fewer flights do not show that they shrink by a constant share."""


def weighed(
    motion: Motion,
    turns: Sequence[Impact],
    earlier: Sequence[Unseen],
    contact: float,
    pace: float,
    collisions: Sequence[Collision],
) -> SeenCollisions:
    """Weigh the turns at stops, of which the likely ones are impacts.

    ``earlier`` are impacts before them in pictures that do not show the body, ``contact`` is half
    the time of a contact in pictures, ``pace`` the frames a picture; ``collisions`` are the impacts
    as they will be given.
    """
    impacts = [turn for turn in turns if turn.likely]
    if not impacts:
        return SeenCollisions((), 0, (Reason(Cause.NO_IMPACT),), probability={0: 1.0})
    unlikely = [turn for turn in turns if turn.chance > CHANCE_AT_LEAST and not turn.likely]
    dying = dies_out(motion, impacts)
    last = [] if dying else _last_unseen(motion, impacts)
    lost = not dying and _lost(motion, impacts, last)
    cut = 0 if dying or lost or last else _ends_at_stop(motion, turns)
    likely = list(takewhile(lambda one: one.likely, earlier))
    unsure = earlier[len(likely) :]
    first_ones = [in_frames(inferred(one, collisions[0]), pace) for one in likely[::-1]]
    last_ones = [in_frames(inferred(one, collisions[-1]), pace) for one in last]
    unturned = {
        impact.frame: chance
        for impact, chance in zip(impacts, map(_not_turned, impacts, collisions), strict=True)
        if chance > CHANCE_AT_LEAST
    }
    doubts: list[tuple[Cause, Sequence[float], Iterable[float]]] = [
        (Cause.FIRST_UNSEEN, [e.chance for e in likely], [e.frame for e in likely[-1:]]),
        (Cause.BEFORE_UNSEEN, [one.chance for one in unsure], ()),
        (Cause.LAST_UNSEEN, [one.chance for one in last], [one.frame for one in last]),
        (Cause.TURNS_OPEN, [one.chance for one in unlikely], [one.frame for one in unlikely]),
        (Cause.NOT_TURNED, [*unturned.values()], unturned),
        (Cause.DIES_OUT, (CHANCE_DYING,) * dying, ()),
        (Cause.TOO_FREQUENT, CHANCES_LOST * lost, ()),
        (Cause.CUT_AT_STOP, (CHANCE_CUT_OFF,) * cut, ()),
    ]
    every = (*first_ones, *collisions, *last_ones)
    chances = [min(impact.chance, CHANCE_CLEAR) for impact in impacts]
    chances += [chance for _, more, _ in doubts for chance in more]
    return SeenCollisions(
        every,
        len(every),
        _shortcomings(motion, impacts, contact, pace) or _gains(collisions),
        tuple(Reason(why, tuple(pace * f for f in frames)) for why, more, frames in doubts if more),
        probability=chances_of_sum(chances),
    )


def _not_turned(impact: Impact, collision: Collision) -> float:
    """Probability that an impact does not turn round the body, or the gap between two.

    The flights next to it say that it does, as odds; the fit of all flights may say of the
    velocities before and after it that it does not, and its odds count as much. Then flights do not
    lead from one impact to the next: one more lies between them.
    """
    turned, sides = 1.0, (impact.side, -impact.side)
    both = collision.velocity_before, collision.velocity_after
    for side, velocities in zip(sides, both, strict=True):
        velocity, sigma = _velocity(velocities)
        if sigma > 0:
            turned *= math.erfc(-side * velocity / sigma / math.sqrt(2)) / 2
    known = min(impact.chance, CHANCE_CLEAR)
    either = known * turned + (1 - known) * (1 - turned)
    return max(0.0, 1 - turned / either)


def _velocity(velocities: Velocities) -> tuple[float, float]:
    """Velocity of a body alone, or of the gap between two, and its uncertainty."""
    ball, heavy, ball_sigma, heavy_sigma = astuple(velocities)
    if math.isnan(heavy):
        return ball, ball_sigma
    return heavy - ball, math.hypot(ball_sigma, heavy_sigma)


def _shortcomings(
    motion: Motion, impacts: Sequence[Impact], contact: float, pace: float
) -> tuple[Reason, ...]:
    certain = (i.log_odds > CERTAIN_LOG_ODDS and i.pictures >= CERTAIN_PICTURES for i in impacts)
    if not any(certain):
        return (Reason(Cause.TOO_FAINT),)
    blow = struck_at_rest(motion, impacts[0].frame - contact)
    return () if blow is None else (Reason(Cause.STRUCK, (pace * blow.frame,)),)


def _gains(collisions: Sequence[Collision]) -> tuple[Reason, ...]:
    """Name the first impact of one body that gives it speed: what it struck was no stop at rest."""
    for one in collisions:
        before, after = one.velocity_before, one.velocity_after
        speed = abs(before.ball_px_frame), abs(after.ball_px_frame)
        sigma = float(np.hypot(before.ball_sigma_px_frame, after.ball_sigma_px_frame))
        if one.kind == "wall" and speed[1] - GAIN_FACTOR * speed[0] > CLEAR_VELOCITY_SIGMAS * sigma:
            return (Reason(Cause.STRUCK_MOVING, (one.frame,)),)
    return ()


def _last_unseen(motion: Motion, impacts: Sequence[Impact]) -> list[Unseen]:
    """Infer the impact after the last one seen, if no picture shows the body when it is due.

    There is none if it may be due after the clip's end, or one more before.
    """
    flight = _next_flight(impacts)
    if flight is None or impacts[-1].side * motion.acceleration <= 0:
        return []
    due, unsure = impacts[-1].frame + flight, PULL_SHARE * flight
    one_more = flight**2 / (impacts[-1].frame - impacts[-2].frame)
    left = float(motion.frame[-1]) - due
    inferred_there = _unseen_at(motion, due) and unsure < left < (1 - PULL_SHARE) * one_more
    return [Unseen(due, unsure, 1 - CHANCE_UNSEEN, likely=True)] if inferred_there else []


def _unseen_at(motion: Motion, frame: Floats | float) -> Mask:
    """Whether no picture shows the body about frames, shape (n,) or none."""
    seen = motion.frame[np.isfinite(motion.place_px)]
    after = seen.searchsorted(frame)
    before, after = (np.append(seen, np.inf)[after + step] for step in (-1, 0))
    return np.asarray(after - before > UNSEEN_FRAMES)


def _lost(motion: Motion, impacts: Sequence[Impact], last: Sequence[Unseen]) -> bool:
    """Whether impacts follow each other too fast, or the body came back to its stop unseen.

    It does if a flight to the same stop, or the time that is left after the last impact, is longer
    than one lasts. Flights last as long as they begin fast, or longer: their median says how long
    that is, if it is not less. The last one follows from those before it, or from the speed that it
    begins with. A body that no picture shows when it is due has come back, but for the ``last``
    impact that is inferred.
    """
    if len(impacts) < 2:
        return False
    if min(b.frame - a.frame for a, b in pairwise(impacts)) < RESOLVED_FRAMES:
        return True
    side = np.array([impact.side for impact in impacts])
    falls = (side == np.append(side[1:], side[-2])) & (side * motion.acceleration > 0)
    inner = np.flatnonzero(falls[:-1])
    if len(inner) == 0:
        return False
    speed = np.abs([impact.after for impact in impacts]) + motion.sigma_px
    ends = last[0].frame if last else float(motion.frame[-1])
    flights = np.diff([*(impact.frame for impact in impacts), ends])
    usual, by_speed = (
        np.quantile(one[inner], 0.5, method="lower") for one in (flights, flights / speed)
    )
    lasts = np.maximum(usual, by_speed * speed)
    lasts[-1] = _next_flight(impacts) or flights[-2] * speed[-1] / speed[-2]
    due = np.array([impact.frame for impact in impacts]) + lasts
    lasts[_unseen_at(motion, due)] *= (1 + PULL_SHARE) / FLIGHT_FACTOR
    return bool((falls & (flights > FLIGHT_FACTOR * lasts)).any())


def dies_out(motion: Motion, impacts: Sequence[Impact]) -> bool:
    """Whether the flights shrink by a nearly constant share until pictures show none any more."""
    following = _next_flight(impacts)
    if following is None:
        return False
    # A flight of t pictures rises by pull t^2 / 8, which the noise of both its ends must not hide.
    pull = abs(motion.acceleration)
    shown = pull * following**2 / 8 > 2 * HYSTERESIS_SIGMAS * motion.sigma_px
    return bool(following < TAIL_PICTURES or (pull > motion.acceleration_spread and not shown))


def _next_flight(impacts: Sequence[Impact]) -> float | None:
    """How long the flight after the last impact is, in pictures; None if those before do not say.

    A body that bounces on one stop keeps the same share e of its speed at every impact, so its
    flights under a constant pull form a geometric series: endlessly many within a finite time, of
    which pictures show the first ones. ``e`` is the median ratio of neighbours; most are nearer to
    it than to half or twice of it. By it each flight says how long the next one after the last
    would be, and the median of them is taken.
    """
    flights = np.diff([impact.frame for impact in impacts])
    if len({impact.side for impact in impacts}) != 1 or len(flights) < FLIGHTS_AT_LEAST:
        return None
    ratios = flights[1:] / flights[:-1]
    kept = float(np.median(ratios))
    steady = np.abs(np.log2(ratios / kept)) < 0.5
    if kept >= 1.0 or steady.mean() <= 0.5:
        return None
    return float(np.median(flights * kept ** np.arange(len(flights), 0, -1)))


def _ends_at_stop(motion: Motion, turns: Sequence[Impact]) -> int:
    """At how many ends of the clip an impact may lie that no turn shows.

    There the body comes to the stop, and its last step leads to it, or is too short to lead on.
    """
    seen, number = np.flatnonzero(np.isfinite(motion.place_px)), 0
    for rows in (seen[:4], seen[::-1][:4]):
        frame, place = motion.frame[rows], motion.place_px[rows]
        steps = np.diff(place) / np.diff(frame)
        speed = float(np.abs(steps).max())
        turned = 2.0 if abs(steps[0]) < 0.75 * speed else 0.6
        side = float(np.sign(place[0] - place[-1]))
        at_stop = [turn for turn in turns if turn.side == side]
        if at_stop and all(abs(one.frame - frame[0]) > 4 for one in turns if one.likely):
            chances = [turn.chance for turn in at_stop]
            stop = float(np.average([turn.place_px for turn in at_stop], weights=chances))
            number += side * (stop - place[0]) < turned * speed
    return int(number)


def chances_of_sum(chances: Sequence[float]) -> dict[int, float]:
    """Probability of each number of independent events that come true, given the chance of each."""
    sums = np.ones(1)
    for chance in chances:
        sums = np.convolve(sums, [1.0 - chance, chance])
    likely = {number: float(p) for number, p in enumerate(sums) if p >= CHANCE_AT_LEAST}
    return {number: share / sum(likely.values()) for number, share in likely.items()}

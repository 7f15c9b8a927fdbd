r"""Impacts of one body alone: where its velocity turns round by a jump, at a stop.

    place                                          place
     |\        /\                                   |   .-.       .-.
     | \      /  \      /\                          |  /   \     /   \
     |  \    /    \    /  \    /\                   | /     \   /     \
     |   \  /      \  /    \  /  \  /\              |        `-'       `-
     +----1----------2------3-----4----> frame      +-------------------> frame

Every turn of the path is looked at, on both sides. A thrown ball, a pendulum or a cart on a spring
comes to rest before it goes back; at an impact (1 to 4) the body arrives at speed and leaves at
speed. So on both sides of an impact the speed right at it is a good part of the highest in that
flight, and the places of all impacts on a side lie at one stop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from count_video.motion.flight import Motion, Rows, flies_freely, straying
from count_video.motion.onesided import BENT_FROM, Side, crossing, fit_side, side_frames
from count_video.motion.swinging import excess, is_sharp, is_smooth
from count_video.motion.turns import Turn, find_turns, usual_flight
from count_video.records import Floats

JUMP_SIGMAS = 5.0
SPEED_SHARE = 0.5
"""Speed at an impact over the highest speed on that side of it; a body that turns round smoothly
is slow there."""
FREE_POINTS_AT_LEAST = 3
FREE_SHRINK = 0.8
"""A side is cut down to this share of its pictures until the body flies freely in all of them."""
BEND_SIGMAS = 2.0
"""A flight seen from the falling frame is straight unless a bend takes more than so many standard
deviations off what a line leaves."""
ROUNDS = 4
MOVES_AT_MOST = 1.5
"""Pictures between the outermost sample and the corner of the fits."""
CONTACT_TIMES = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
CONTACT_SHARE = 0.06
"""Half the time that a contact takes, in pictures, and as a share of the usual flight: bumpers are
springs, and soft balls touch for several pictures of a fast camera."""
STOP_SHARE = 0.08
"""Impacts on one stop lie within this share of the body's whole way."""
STOP_SIGMAS = 6.0
STOP_PICTURES = 0.3
"""A fast body's place at an impact is as uncertain as its time, by what it moves meanwhile."""


@dataclass(frozen=True)
class Impact:
    """One impact of a body on a stop; times in pictures."""

    frame: float
    frame_sigma: float
    side: int
    """-1 for a stop at smaller places, +1 for one at larger places."""
    place_px: float
    velocity_before: float
    """Along the direction in which places are measured, in px per picture."""
    velocity_after: float
    clarity: float
    """Jump of the velocity over its standard uncertainty; 0 where too few pictures show it, or tell
    it from the turn of a swing."""
    pictures: int
    """How many show the body flying freely, on the side where fewer do."""


def find_impacts(motion: Motion) -> tuple[list[Impact], float]:
    """Find the impacts of one body, in order of time, and half the time that a contact takes."""
    turns = find_turns(motion)
    longest = CONTACT_SHARE * usual_flight(turns)
    best: tuple[list[Impact], float, int] | None = None
    for contact in CONTACT_TIMES:
        if best is not None and contact > longest:
            break
        found = at_stops(_sharp(turns, motion, contact), motion)
        bad = len(straying(motion, [impact.frame for impact in found], contact))
        if best is None or len(found) - 2 * bad > len(best[0]) - 2 * best[2]:
            best = found, contact, bad
    return (best[0], best[1]) if best else ([], CONTACT_TIMES[0])


def _sharp(turns: Sequence[Turn], motion: Motion, contact: float) -> list[Impact]:
    """Keep the turns that are corners; those that are smooth no longer limit their neighbours.

    Turns that too few pictures show limit them still, until their own flights have grown.
    """
    kept = list(turns)
    for _ in range(ROUNDS):
        ends = [-np.inf, *(turn.frame for turn in kept), np.inf]
        limits = [_limits(*three) for three in zip(ends[:-2], ends[1:-1], ends[2:], strict=True)]
        kept = [
            sharper
            for turn, limit in zip(kept, limits, strict=True)
            if (sharper := _sharpened(turn, motion, limit, contact)) is not None
        ]
    return [_impact(turn, motion) for turn in kept]


def _limits(before: float, here: float, after: float) -> tuple[float, float]:
    """How far the sides of a turn reach: to the neighbours, the outermost as far as the other."""
    if np.isinf(before) and np.isfinite(after):
        before = 2 * here - after
    elif np.isinf(after) and np.isfinite(before):
        after = 2 * here - before
    return before, after


def _sharpened(
    turn: Turn, motion: Motion, limits: tuple[float, float], contact: float
) -> Turn | None:
    """Give a turn its corner; None where it is smooth, no corner where it is hardly shown."""
    before, after = (_side(turn, motion, limit, contact) for limit in limits)
    if before is None or after is None:
        return replace(turn, corner=None)
    corner = crossing(before, after, turn.frame)
    moves = MOVES_AT_MOST + contact + unseen_around(motion, turn.outermost)
    if corner is None or abs(corner.frame - turn.outermost) > moves:
        return None
    sharper = replace(turn, frame=corner.frame, corner=corner)
    if not _is_impact(sharper, motion, limits, contact):
        return None
    return _unlike_a_swing(sharper, motion, limits, contact)


def _unlike_a_swing(
    turn: Turn, motion: Motion, limits: tuple[float, float], contact: float
) -> Turn | None:
    """Leave a turn out where a swing explains it; mark it where too few pictures tell."""
    left = excess(motion, turn.frame, limits, contact)
    if left is not None and is_smooth(left):
        return None
    return replace(turn, told_from_swing=left is not None and is_sharp(left))


def unseen_around(motion: Motion, frame: float) -> float:
    """Pictures next to one that do not show the body."""
    seen = motion.frame[np.isfinite(motion.place_px)]
    before, after = seen[seen < frame], seen[seen > frame]
    if len(before) == 0 or len(after) == 0:
        return 0.0
    return max(frame - float(before[-1]), float(after[0]) - frame) - 1.0


def _side(turn: Turn, motion: Motion, limit: float, contact: float) -> Side | None:
    """Fit one side of a turn, as far away from it as the body flies freely."""
    rows = _side_rows(turn, motion, limit, contact)
    frame, places = motion.frame[rows], motion.levelled_px[rows]
    straight = fit_side(frame, places, turn.frame, motion.sigma_px, bent=False)
    if straight is not None and _is_straight(frame, places, motion.sigma_px):
        return straight
    return fit_side(frame, places, turn.frame, motion.sigma_px)


def _is_straight(frame: Floats, places: Floats, sigma: float) -> bool:
    """Whether a flight that is levelled has no bend left that would stand out from the noise."""
    if len(frame) < BENT_FROM:
        return True
    straight, bent = (
        float(np.sum((places - np.polynomial.Polynomial.fit(frame, places, order)(frame)) ** 2))
        for order in (1, 2)
    )
    return straight - bent < (BEND_SIGMAS * sigma) ** 2


def _side_rows(turn: Turn, motion: Motion, limit: float, contact: float) -> Rows:
    chosen = side_frames(motion.frame, motion.place_px, turn.frame, limit)
    clear = np.abs(motion.frame[chosen] - turn.frame) > contact
    clear &= np.abs(motion.frame[chosen] - limit) > contact
    rows = chosen[clear]
    while len(rows) > FREE_POINTS_AT_LEAST and not flies_freely(motion, rows):
        # What lies beyond is a hand, rest, or something else that is no flight: nearer is better.
        kept = max(FREE_POINTS_AT_LEAST, round(FREE_SHRINK * len(rows)))
        rows = rows[-kept:] if limit < turn.frame else rows[:kept]
    return rows


def _is_impact(turn: Turn, motion: Motion, limits: tuple[float, float], contact: float) -> bool:
    """Whether a turn has a jump, and a good part of its flights' highest speed on both sides."""
    corner = turn.corner
    if corner is None:
        return False
    jump = -turn.side * (corner.slope_after - corner.slope_before)
    if jump <= JUMP_SIGMAS * corner.slope_sigma:
        return False
    speeds = (
        turn.side * motion.slope_back(corner.slope_before, corner.frame),
        -turn.side * motion.slope_back(corner.slope_after, corner.frame),
    )
    return all(
        _arrives_at_speed(motion, _side_rows(turn, motion, limit, contact), speed)
        for speed, limit in zip(speeds, limits, strict=True)
    )


def _arrives_at_speed(motion: Motion, rows: Rows, speed: float) -> bool:
    """Whether a body is about as fast at a turn, by the fit, as at its fastest on that side."""
    if len(rows) < 2:
        return True
    step = np.abs(np.diff(motion.place_px[rows])) / np.diff(motion.frame[rows])
    return speed > SPEED_SHARE * float(np.quantile(step, 0.9))


def _impact(turn: Turn, motion: Motion) -> Impact:
    corner = turn.corner
    if corner is None:
        row = int(np.argmin(np.abs(motion.frame - turn.outermost)))
        place = float(motion.place_px[row])
        return Impact(turn.outermost, 0.5, turn.side, place, np.nan, np.nan, 0.0, 0)
    return Impact(
        frame=corner.frame,
        frame_sigma=corner.frame_sigma,
        side=turn.side,
        place_px=motion.place_back(corner.value, corner.frame),
        velocity_before=motion.slope_back(corner.slope_before, corner.frame),
        velocity_after=motion.slope_back(corner.slope_after, corner.frame),
        clarity=corner.clarity if turn.told_from_swing else 0.0,
        pictures=min(corner.points),
    )


def at_stops(impacts: Sequence[Impact], motion: Motion) -> list[Impact]:
    """Keep the impacts at the stops: one place on either side, where the hardest impacts are."""
    kept = []
    for side in (-1, 1):
        here = [impact for impact in impacts if impact.side == side]
        stop, tolerance = stop_of(here), stop_tolerance(motion)
        for impact in here:
            speeds = abs(impact.velocity_before), abs(impact.velocity_after)
            slack = STOP_PICTURES * float(np.nan_to_num(min(speeds)))
            if abs(impact.place_px - stop) < tolerance + slack:
                kept.append(impact)
    return sorted(kept, key=lambda impact: impact.frame)


def stop_tolerance(motion: Motion) -> float:
    """How far from each other, in px, the places of a slow body's impacts on one stop may lie."""
    way = float(np.ptp(motion.place_px[np.isfinite(motion.place_px)]))
    return STOP_SHARE * way + STOP_SIGMAS * motion.sigma_px


def stop_of(impacts: Sequence[Impact]) -> float:
    """Median place, each impact with the weight of its jump; NaN where no jump is shown."""
    shown = [impact for impact in impacts if impact.clarity > 0]
    if not shown:
        return float("nan")
    order = sorted(shown, key=lambda impact: impact.place_px)
    share = np.cumsum([abs(i.velocity_after - i.velocity_before) for i in order])
    return order[int(np.searchsorted(share, share[-1] / 2))].place_px

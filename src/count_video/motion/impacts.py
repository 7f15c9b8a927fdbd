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

from count_video.motion.batches import fit_contacts
from count_video.motion.finding import (
    JUMP_SIGMAS,
    OWN_PLACE_SIGMAS,
    SELECTION_ROUNDS,
    peaks,
    smoothness_of,
)
from count_video.motion.flight import Motion, straying, strays
from count_video.motion.joint import Contacts, Fitting
from count_video.motion.model import Kind, Paths
from count_video.motion.pieces import WINDOW_FRAMES
from count_video.motion.priors import TURN_LOG_RATIO
from count_video.motion.swinging import excess, is_sharp, is_smooth
from count_video.records import Floats
from count_video.signals import low_points

HYSTERESIS_SIGMAS = 3.0
"""What is no more than noise has no jump, and lies at no stop."""
PULL_AT_MOST = 1.5
TURN_PICTURES = (1, 2)
TURN_SIGMAS = 3.0
"""Within so many pictures of the highest point of a throw, the path bends by no more than this
factor of what the usual acceleration does, and the noise."""
PICTURES_AT_LEAST = 2
"""Fewer on one side show no velocity."""
SPEED_SHARE = 0.5
"""Speed at an impact over the highest speed on that side of it; a body that turns round smoothly
is slow there."""
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


@dataclass(frozen=True)
class Turn:
    """A turn of the path, which may be an impact."""

    side: int
    outermost: float
    """Frame of the outermost sample."""
    frame: float


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


def find_turns(motion: Motion) -> list[Turn]:
    """Find turns deeper than the noise that free fall does not explain, in order of time."""
    depth = HYSTERESIS_SIGMAS * motion.sigma_px
    turns = [
        Turn(side, float(motion.frame[row]), float(motion.frame[row]))
        for side in (-1, 1)
        for row in low_points(-side * motion.place_px, depth)
        if not _falls_back(motion, int(row), side)
    ]
    return sorted(turns, key=lambda turn: turn.frame)


def _falls_back(motion: Motion, row: int, side: int) -> bool:
    """Whether a body turns round there as it does when nothing but its weight acts on it."""
    pull = -side * motion.acceleration
    if pull <= 0:
        return False
    bends = []
    for reach in TURN_PICTURES:
        if reach <= row < len(motion.frame) - reach:
            before, here, after = motion.place_px[[row - reach, row, row + reach]]
            bends.append(-side * (before - 2 * here + after) / reach**2)
    slack = TURN_SIGMAS * np.sqrt(6.0) * motion.sigma_px
    shown = [bend for bend in bends if np.isfinite(bend)]
    return bool(shown) and max(shown) < PULL_AT_MOST * pull + slack


def usual_flight(turns: Sequence[Turn]) -> float:
    """Median time between turns on one side, in pictures; 0 for fewer than two."""
    flights = [
        step
        for side in (-1, 1)
        for step in np.diff([turn.frame for turn in turns if turn.side == side])
    ]
    return float(np.median(flights)) if flights else 0.0


def _sharp(turns: Sequence[Turn], motion: Motion, contact: float) -> list[Impact]:
    """Keep the turns that are impacts, by fits of all of them, each with a place of its own.

    Of neighbours that are none the least clear is left out first: it may have misled the others.
    """
    kept, paths = list(turns), Paths(motion.frame, motion.place_px, None)
    how = Fitting(OWN_PLACE_SIGMAS, contact, SELECTION_ROUNDS)
    while kept:
        kinds: list[Kind] = ["wall" if turn.side < 0 else "far" for turn in kept]
        fitted = fit_contacts(paths, kinds, [turn.frame for turn in kept], how)
        how = replace(how, rounds=1, errors=fitted.errors)
        found = [_impact(turn, fitted, number) for number, turn in enumerate(kept)]
        clear = _clarity(found, kept, motion, contact)
        clear[smoothness_of(fitted) > TURN_LOG_RATIO] = np.nan
        for number in np.flatnonzero(np.isnan(clear)).tolist():
            if _needed(found, number, motion, contact):
                clear[number] = 0.0
        if np.isfinite(clear).all():
            return [replace(i, clarity=one) for i, one in zip(found, clear.tolist(), strict=True)]
        smooth = [-i.clarity if np.isnan(c) else -np.inf for i, c in zip(found, clear, strict=True)]
        worst = peaks(np.array(smooth), -np.inf)
        left = [
            pair for number, pair in enumerate(zip(kept, found, strict=True)) if number not in worst
        ]
        kept = [replace(turn, frame=impact.frame) for turn, impact in left]
    return []


def _clarity(
    found: Sequence[Impact], turns: Sequence[Turn], motion: Motion, contact: float
) -> Floats:
    """Clarity of each impact, shape (n,); 0 where it may be a turn, NaN where it is one."""
    ends = [-np.inf, *(impact.frame for impact in found), np.inf]
    limits = zip(ends[:-2], ends[2:], strict=True)
    return np.array(
        [
            _told(impact, turn, motion, limit, contact)
            for impact, turn, limit in zip(found, turns, limits, strict=True)
        ]
    )


def _needed(found: Sequence[Impact], number: int, motion: Motion, contact: float) -> bool:
    """Whether without a turn the path from the one before it to the next would not be free flight.

    The last turn before a crowd of small bounces is followed by no flight and looks smooth; but if
    it were, the flight before it would go on past it.
    """
    if not 0 < number < len(found) - 1:
        return False
    return strays(motion, (found[number - 1].frame, found[number + 1].frame), contact)


def _impact(turn: Turn, fitted: Contacts, number: int) -> Impact:
    ball = fitted.bodies[0]
    before, after = ball.rate[number].tolist()
    clarity = -turn.side * ball.jump[number] / ball.jump_sigma[number]
    return Impact(
        frame=float(fitted.frame[number]),
        frame_sigma=float(fitted.frame_sigma[number]),
        side=turn.side,
        place_px=float(fitted.ball_px[number]),
        velocity_before=before,
        velocity_after=after,
        clarity=float(np.nan_to_num(clarity)),
        pictures=int(ball.rows[number].min()),
    )


def _told(
    impact: Impact, turn: Turn, motion: Motion, limits: tuple[float, float], contact: float
) -> float:
    """Clarity of an impact; 0 where too few pictures tell it from a turn, NaN where it is one."""
    left = excess(motion, impact.frame, limits, contact)
    if left is not None and is_smooth(left):
        return np.nan
    if impact.pictures < PICTURES_AT_LEAST:
        return 0.0
    speeds = turn.side * impact.velocity_before, -turn.side * impact.velocity_after
    if impact.clarity < JUMP_SIGMAS:
        return impact.clarity if min(speeds) > 0 else np.nan
    moves = MOVES_AT_MOST + contact + unseen_around(motion, turn.outermost)
    arrives = all(
        _arrives_at_speed(motion, (impact.frame, limit), speed)
        for speed, limit in zip(speeds, limits, strict=True)
    )
    if not arrives or abs(impact.frame - turn.outermost) > moves:
        return np.nan
    return impact.clarity if left is not None and is_sharp(left) else 0.0


def _arrives_at_speed(motion: Motion, between: tuple[float, float], speed: float) -> bool:
    """Whether a body is about as fast at a turn, by the fit, as at its fastest on that side."""
    near, far = sorted(np.clip(between, between[0] - WINDOW_FRAMES, between[0] + WINDOW_FRAMES))
    inside = (motion.frame > near) & (motion.frame < far) & np.isfinite(motion.place_px)
    if inside.sum() < 2:
        return True
    step = np.abs(np.diff(motion.place_px[inside])) / np.diff(motion.frame[inside])
    return speed > SPEED_SHARE * float(np.quantile(step, 0.9))


def unseen_around(motion: Motion, frame: float) -> float:
    """Pictures next to one that do not show the body."""
    seen = motion.frame[np.isfinite(motion.place_px)]
    before, after = seen[seen < frame], seen[seen > frame]
    if len(before) == 0 or len(after) == 0:
        return 0.0
    return max(frame - float(before[-1]), float(after[0]) - frame) - 1.0


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

r"""Impacts of one body alone: where its velocity turns round by a jump, at a stop.

    place                                          place
     |\        /\                                   |   .-.       .-.
     | \      /  \      /\                          |  /   \     /   \
     |  \    /    \    /  \    /\                   | /     \   /     \
     |   \  /      \  /    \  /  \  /\              |        `-'       `-
     +----1----------2------3-----4----> frame      +-------------------> frame

Every turn of the path is judged, on both sides. A thrown ball, a pendulum or a cart on a spring
comes to rest before it goes back; at an impact (1 to 4) the body arrives at speed and leaves at
speed: its velocity jumps. The places of all impacts on a side lie at one stop.
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
from count_video.motion.flight import Motion, straying
from count_video.motion.joint import Contacts, Fitting
from count_video.motion.model import Kind, Paths
from count_video.motion.priors import TURN_LOG_RATIO
from count_video.motion.swinging import SECOND_DIFFERENCE, excess, is_sharp, is_smooth
from count_video.records import Floats
from count_video.signals import low_points

HYSTERESIS_SIGMAS = 3.0
"""What is no more than noise has no jump, and lies at no stop."""
BEND_PICTURES = (1, 2)
"""A turn shows in the bend of the path over so many pictures on either side of it."""
PULL_AT_MOST, TURN_SIGMAS = 1.5, 3.0
"""At the highest point of a throw the path bends by no more than this factor of what the usual
acceleration does, and the noise."""
OPEN = -1.0
"""Clarity of what is no impact for all that is seen, but no smooth turn either: what follows it is
another flight."""
GAP_PICTURES = 2.0
"""Pictures that do not show the body come between samples that are so many apart."""
PICTURES_AT_LEAST = 2
"""Fewer on one side show no velocity."""
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
    """Jump of the velocity, by the flights next to it or by the law of a swing through both, over
    its standard uncertainty; 0 where too few pictures show it, or that it is no swing's turn."""
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
    """Find turns deeper than the noise, in order of time."""
    depth = HYSTERESIS_SIGMAS * motion.sigma_px
    turns = [
        Turn(side, float(motion.frame[row]), _middle_of_gap(motion, int(row)))
        for side in (-1, 1)
        for row in low_points(-side * motion.place_px, depth)
        if not _falls_back(motion, int(row), side)
    ]
    # Lowest samples on both sides of a gap are one turn within it.
    once = {(turn.side, turn.frame): turn for turn in turns}
    return sorted(once.values(), key=lambda turn: turn.frame)


def _middle_of_gap(motion: Motion, row: int) -> float:
    """Frame of a turn's outermost sample, or the middle of a gap in the samples next to it."""
    seen = np.flatnonzero(np.isfinite(motion.place_px))
    at = int(np.searchsorted(seen, row))
    around = motion.frame[seen[max(at - 1, 0) : at + 2]]
    longest = int(np.argmax(np.diff(around))) if len(around) > 1 else 0
    if len(around) < 2 or np.diff(around)[longest] < GAP_PICTURES:
        return float(motion.frame[row])
    return float(around[longest : longest + 2].mean())


def _falls_back(motion: Motion, row: int, side: int) -> bool:
    """Whether a body turns round there as it does when nothing but its weight acts on it."""
    pull = -side * motion.acceleration
    if pull <= 0:
        return False
    shown = _bends(motion, row, side)
    return bool(shown) and max(shown) < PULL_AT_MOST * pull + TURN_SIGMAS * _bend_sigma(motion)


def _against_pull(motion: Motion, turn: Turn, impact: Impact) -> float:
    """By how many standard uncertainties a body turns against what pulls it all the time.

    No free body does: where its weight pulls it to the stop, only an impact sends it back. It shows
    in the pictures about the turn or by the flights on both sides of it. 0 where nothing pulls it
    there for most of the clip, or the flights show no arrival and departure.
    """
    pull = turn.side * motion.acceleration
    bounces = turn.side * impact.velocity_before > 0 > turn.side * impact.velocity_after
    if not bounces or pull <= motion.acceleration_spread:
        return 0.0
    bends = _bends(motion, int(np.searchsorted(motion.frame, turn.outermost)), turn.side)
    by_bends = (max(bends) + pull) / _bend_sigma(motion) if bends else 0.0
    return max(by_bends, impact.clarity)


def _bends(motion: Motion, row: int, side: int) -> list[float]:
    """Bends of the path about a turn away from a stop, in px per picture squared, where seen."""
    bends = []
    for reach in BEND_PICTURES:
        if reach <= row < len(motion.frame) - reach:
            before, here, after = motion.place_px[[row - reach, row, row + reach]]
            bends.append(-side * float(before - 2 * here + after) / reach**2)
    return [bend for bend in bends if np.isfinite(bend)]


def _bend_sigma(motion: Motion) -> float:
    """Return the standard uncertainty of such a bend over one picture."""
    return float(np.sqrt(SECOND_DIFFERENCE)) * motion.sigma_px


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
        # Jumps are expected to be large: small ones are left open.
        clear[(smoothness_of(fitted) > TURN_LOG_RATIO) & (clear <= JUMP_SIGMAS)] = OPEN
        if np.isfinite(clear).all():
            paired = zip(found, clear.tolist(), strict=True)
            return [replace(i, clarity=one) for i, one in paired if one != OPEN]
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
            _clarity_of(impact, turn, motion, limit, contact)
            for impact, turn, limit in zip(found, turns, limits, strict=True)
        ]
    )


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


def _clarity_of(
    impact: Impact, turn: Turn, motion: Motion, limits: tuple[float, float], contact: float
) -> float:
    """Clarity of an impact; 0 where too few pictures show it to be none, NaN for a turn."""
    left = excess(motion, impact.frame, limits, contact)
    if left is not None and is_smooth(left):
        return np.nan
    against = _against_pull(motion, turn, impact)
    if against > JUMP_SIGMAS:
        return against
    if impact.pictures < PICTURES_AT_LEAST:
        return 0.0
    speeds = turn.side * impact.velocity_before, -turn.side * impact.velocity_after
    if impact.clarity < JUMP_SIGMAS:
        return impact.clarity if min(speeds) > 0 else OPEN
    moves = MOVES_AT_MOST + contact + unseen_around(motion, turn.outermost)
    if abs(impact.frame - turn.outermost) > moves:
        return OPEN
    return max(impact.clarity, left.share / left.sigma) if left and is_sharp(left) else 0.0


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
    shown = [
        i for i in impacts if i.clarity > 0 and np.isfinite(i.velocity_after - i.velocity_before)
    ]
    if not shown:
        return float("nan")
    order = sorted(shown, key=lambda impact: impact.place_px)
    share = np.cumsum([abs(i.velocity_after - i.velocity_before) for i in order])
    return order[int(np.searchsorted(share, share[-1] / 2))].place_px

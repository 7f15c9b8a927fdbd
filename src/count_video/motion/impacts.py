r"""Impacts of one body alone: where its velocity turns round by a jump, at a stop.

    place                                          place
     |\        /\                                   |   .-.       .-.
     | \      /  \      /\                          |  /   \     /   \
     |  \    /    \    /  \    /\                   | /     \   /     \
     |   \  /      \  /    \  /  \  /\              |        `-'       `-
     +----1----------2------3-----4----> frame      +-------------------> frame

Every turn of the path is weighed (see ``corners``), between those that may be impacts. On each side
there is one stop or none: the place at which the turns are most probably impacts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from count_video.motion.corners import HALF_CONTACTS, Impact, Turn, chance_of, weigh
from count_video.motion.errors_of_places import HALF_EXPOSURE
from count_video.motion.flight import HYSTERESIS_SIGMAS, Motion
from count_video.motion.priors import HAND_JUMPS, NO_BOUNCE, STOP_SHARE
from count_video.signals import low_points

STOP_SIGMAS, STOP_PICTURES = 6.0, 0.3
"""A stop's place is also uncertain by noise, and by what a fast body moves within its time."""


def find_impacts(
    motion: Motion,
    touching_px: float | None = None,
    depth_sigmas: float = HYSTERESIS_SIGMAS,
    struck: Sequence[float] = (),
) -> tuple[list[Impact], float]:
    """Find the impacts of one body, or of two by the gap between them.

    The gap closes to 0 at every impact, but for ``touching_px`` to either side. Turns are as deep
    as so many standard deviations of a place; at the frames ``struck`` something else strikes the
    body, which need not turn it.

    Returns all turns at stops in order of time, and half the time of a contact in pictures.
    """
    weighed, contact = weigh_turns(find_turns(motion, depth_sigmas), motion, struck)
    if touching_px is None:
        found = [impact for side in (-1, 1) for impact in at_stop(weighed, side, motion)]
    else:
        found = [one for one in weighed if one.side < 0 and abs(one.place_px) < touching_px]
    return sorted(found, key=lambda impact: impact.frame), contact


def find_turns(motion: Motion, depth_sigmas: float = HYSTERESIS_SIGMAS) -> list[Turn]:
    """Find turns deeper than the noise, in order of time."""
    depth = depth_sigmas * motion.sigma_px
    place = np.where(motion.moving, motion.place_px, np.nan)
    # Lowest samples on both sides of a gap are one turn within it.
    turns = {
        _turn(motion, int(row), side)
        for side in (-1, 1)
        for row in low_points(-side * place, depth)
    }
    return sorted(turns, key=lambda turn: turn.frame)


def _turn(motion: Motion, row: int, side: int) -> Turn:
    """Turn at a row, or in the middle of the pictures next to it that do not show the body."""
    frame, seen = float(motion.frame[row]), motion.frame[motion.moving]
    at = int(np.searchsorted(seen, frame))
    before, after = float(seen[max(at - 1, 0)]), float(seen[min(at + 1, len(seen) - 1)])
    # Where pictures on both sides do not show it, it may turn on either.
    first, last = (end if abs(end - frame) >= 2.0 else frame for end in (before, after))
    return Turn(side, (first + last) / 2, max(last - first - 1.0, 0.0))


def usual_flight(turns: Sequence[Turn], motion: Motion) -> float:
    """Median time between turns on one side, in pictures; half the clip for lack of two."""
    sides = ([turn.frame for turn in turns if turn.side == side] for side in (-1, 1))
    flights = np.concatenate([np.diff(frames) for frames in sides])
    return float(np.median(flights) if len(flights) else motion.moving.sum() / 2)


def weigh_turns(
    turns: Sequence[Turn], motion: Motion, struck: Sequence[float]
) -> tuple[list[Impact], float]:
    """Weigh all turns, and half the time that a contact takes, in pictures."""
    flight = usual_flight(turns, motion)

    @cache
    def weigh_once(turn: Turn, limits: tuple[float, float], contact: float) -> Impact:
        return weigh(motion, turn, limits, flight, contact)

    best: dict[Turn, Impact] = {}
    kept, contact, worst = list(turns), HALF_EXPOSURE, [0]
    while worst:
        ends = np.array([-np.inf, *(turn.frame for turn in kept), *struck, np.inf])
        for turn in kept:
            before = float(ends[ends < turn.frame - HALF_EXPOSURE].max())
            after = float(ends[ends > turn.frame + HALF_EXPOSURE].min())
            corner = weigh_once(turn, (before, after), contact)
            # An impact is one by some of the flights next to it; others may hold what misleads.
            if turn not in best or corner.log_odds > best[turn].log_odds:
                best[turn] = corner
        odds = np.array([best[turn].log_odds for turn in kept])
        contact = _contact([best[turn] for turn in kept if best[turn].log_odds > 0])
        # Of neighbours that are none the least likely is left out first: it may mislead the others.
        near = np.pad(odds, 1, constant_values=np.inf)
        worst = np.flatnonzero((odds < near[:-2]) & (odds <= near[2:]) & (odds < 0)).tolist()
        kept = [turn for number, turn in enumerate(kept) if number not in worst]
    return [best[turn] for turn in turns], contact


def _contact(corners: Sequence[Impact]) -> float:
    """Half the time that a contact takes, in pictures: the most probable for all of them.

    Most are briefer than an exposure: it is expected to be exponential.
    """
    if not corners:
        return HALF_EXPOSURE
    total = np.sum([corner.by_contact for corner in corners], axis=0)
    half = HALF_CONTACTS[: len(total)]
    return max(HALF_EXPOSURE, float(half[np.argmax(total - half / HALF_EXPOSURE)]))


def at_stop(turns: Sequence[Impact], side: int, motion: Motion) -> list[Impact]:
    """List the turns at the stop of one side, if any: smooth ones there speak against it."""
    corners = [one for one in turns if one.side == side]
    if not corners:
        return []
    odds = np.array([corner.log_odds for corner in corners])
    place = np.array([corner.place_px for corner in corners])
    slack = np.array([min(abs(corner.before), abs(corner.after)) for corner in corners])
    allowed = STOP_SHARE * motion.way_px + STOP_SIGMAS * motion.sigma_px + STOP_PICTURES * slack
    near = np.abs(place[:, None] - place) < allowed
    together = near @ np.maximum(odds, NO_BOUNCE)
    stop = near[int(np.argmax(together))]
    if together.max() <= 0:
        return []
    sure = int(np.sum(stop & (odds > 0)))
    # That hands made all of these corners at one place, by chance.
    hands = HAND_JUMPS * STOP_SHARE ** (sure - 1)
    known = -np.log(STOP_SHARE) * (1 if sure > 1 else -1)
    chances = (1 - hands) * chance_of(odds + known)
    return [
        replace(corners[number], chance=float(chances[number]))
        for number in np.flatnonzero(stop).tolist()
    ]

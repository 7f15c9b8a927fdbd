"""What speaks for the impacts found in a clip, what is in doubt, and why it supports no count."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from count_video.collisions.certainty import chances_of_sum
from count_video.collisions.flight import Motion, flies_freely, straying
from count_video.collisions.impacts import FREE_POINTS_AT_LEAST, Impact
from count_video.collisions.resolution import RESOLVED_FRAMES
from count_video.records import Collision

CLEAR_SIGMAS = 10.0
CERTAIN_SIGMAS = 20.0
CERTAIN_PICTURES = 4
"""One impact at least must be as clear as this, and shown by so many pictures on either side."""
CHANCE_CLEAR = 0.995
CHANCE_WEAK = 0.9
CHANCE_HARDLY_SHOWN = 0.6
"""Chances that an impact is one: its jump exceeds its uncertainty by this factor or not, or too
few pictures show the body before or after it."""
CHANCE_SINGLE = 0.8
"""And where it is the only one at its stop, so that nothing else tells where the stop is; two
bodies that touch tell it by their outlines."""
CHANCE_STRAYING = 0.4
"""Chance that a flight which strays from free flight hides one more."""
UNSEEN_SHARE = 0.3
CONTACT_PICTURES = 1.0
SHORTER_AT_MOST = 1.6
"""A flight is not longer than the longest after it by more: bodies that lose 60 % of their speed at
an impact are hardly said to bounce."""
CHANCE_LEAVING = 0.5
CHANCE_UNSEEN = 0.3
"""Chances that an impact lies before the first one, in pictures of which this share do not show the
body: it comes into sight as it moves away from the stop, or toward it."""
FALLEN_BACK = 1.3
TAIL_PICTURES = 4.0
CHANCES_TAIL = (0.5, 0.25, 0.15)
"""A body that bounces lower and lower goes on to do so below what the pictures show: where its
last flight is shorter than this, these are the chances of one more, and each after it."""
STRAYING_AT_MOST = 0.4
"""Where a larger share of the flights strays, the turns are not those of a body that bounces."""
NO_IMPACT = "no impact is seen: what moves turns round smoothly, if at all, and jumps nowhere"
TOO_FREQUENT = (
    "the last impacts follow each other faster than the pictures show: some may be missed"
)


@dataclass(frozen=True)
class SeenImpacts:
    """What the frames of one clip show."""

    collisions: tuple[Collision, ...]
    """In order of time, numbered from 1; real times are not filled in."""
    shortcomings: tuple[str, ...]
    """Why the clip supports no count, in words for the user; empty if it does."""
    doubts: tuple[str, ...]
    """What lowers the probability, in words for the user."""
    probability: dict[int, float]
    """Of each count."""


def weighed(
    motion: Motion,
    impacts: Sequence[Impact],
    timing: tuple[float, float],
    collisions: Sequence[Collision],
) -> SeenImpacts:
    """Weigh what was found.

    ``timing`` is half the time that a contact takes, in pictures, and the frames a picture;
    ``collisions`` are the impacts as they will be told.
    """
    contact, pace = timing
    frames = [impact.frame for impact in impacts]
    strays = straying(motion, frames, contact)
    told = zip(impacts, collisions, strict=True)
    chances = [_chance(impact, impacts, collision.kind) for impact, collision in told]
    doubts = []
    if strays:
        spans = ", ".join(f"{a * pace:.0f} to {b * pace:.0f}" for a, b in strays)
        doubts.append(f"the body does not fly freely in frames {spans}")
        chances += [CHANCE_STRAYING] * len(strays)
    if impacts and (unseen := _chance_before(motion, impacts)) > 0:
        doubts.append("what came before the first impact is not seen: one may be missing")
        chances.append(unseen)
    if any(b - a < RESOLVED_FRAMES for a, b in pairwise(frames)) or _in_a_tail(motion, impacts):
        doubts.append(TOO_FREQUENT)
        chances += CHANCES_TAIL
    shortcomings = tuple(_shortcomings(impacts, len(strays)))
    return SeenImpacts(tuple(collisions), shortcomings, tuple(doubts), chances_of_sum(chances))


def _shortcomings(impacts: Sequence[Impact], strays: int) -> list[str]:
    if not impacts:
        return [NO_IMPACT]
    if not any(_is_certain(impact) for impact in impacts):
        return ["the few turns that are seen are too faint or too short to tell impacts by"]
    if strays > STRAYING_AT_MOST * max(len(impacts) - 1, 1):
        return [
            "the body's path between its turns is not that of one that bounces: impacts and smooth "
            "turns cannot be told apart"
        ]
    return []


def _is_certain(impact: Impact) -> bool:
    return impact.clarity > CERTAIN_SIGMAS and impact.pictures >= CERTAIN_PICTURES


def _chance(impact: Impact, impacts: Sequence[Impact], kind: str) -> float:
    if impact.clarity == 0:
        return CHANCE_HARDLY_SHOWN
    clear = CHANCE_CLEAR if impact.clarity > CLEAR_SIGMAS else CHANCE_WEAK
    alone = sum(other.side == impact.side for other in impacts) == 1
    return min(clear, CHANCE_SINGLE) if alone and kind == "wall" else clear


def _chance_before(motion: Motion, impacts: Sequence[Impact]) -> float:
    """Chance of an impact before the first one found, in the time that does not show the body.

    The flight that ends at the first impact is followed back to where it would have begun at the
    stop. If that lies within the clip and the body is not seen then, it may have bounced there;
    more likely so if it still moves away from the stop when it comes into sight.
    """
    first = impacts[0]
    rows = np.flatnonzero(np.isfinite(motion.place_px) & (motion.frame < first.frame))
    while len(rows) > FREE_POINTS_AT_LEAST and not flies_freely(motion, rows):
        rows = rows[1:]
    if len(rows) == 0 or not np.isfinite(first.velocity_before):
        return CHANCE_UNSEEN
    begins, clip = float(motion.frame[rows[0]]), float(motion.frame[0])
    left = first.frame - _flight_time(motion, impacts)
    hidden = (motion.frame >= left - CONTACT_PICTURES) & (motion.frame < begins)
    if left < clip - CONTACT_PICTURES or not hidden.any():
        return 0.0
    if float(np.isnan(motion.place_px[hidden]).mean()) < UNSEEN_SHARE:
        return 0.0
    speed = first.side * (first.velocity_before - motion.acceleration * (first.frame - begins))
    return CHANCE_LEAVING if speed < 0 else CHANCE_UNSEEN


def _flight_time(motion: Motion, impacts: Sequence[Impact]) -> float:
    """How long the flight before the first impact took if it began at the stop, in pictures."""
    first = impacts[0]
    pull = first.side * motion.acceleration
    back = 2 * first.side * first.velocity_before / pull if pull > 0 else np.inf
    flights = np.diff([impact.frame for impact in impacts])
    # Without a pull, or with a weak one, the body comes from another stop, as it does later on.
    return float(min(back, SHORTER_AT_MOST * flights.max())) if len(flights) else float(back)


def _in_a_tail(motion: Motion, impacts: Sequence[Impact]) -> bool:
    """Whether impacts follow each other faster and faster until pictures no longer show them.

    So it is too where the body must have fallen back to the stop while the clip went on, by the
    velocity with which it left and the usual acceleration, and no impact was found.
    """
    if len(impacts) < 2:
        return False
    last = impacts[-1]
    if last.frame - impacts[-2].frame < TAIL_PICTURES:
        return True
    pull = last.side * motion.acceleration
    if pull <= 0 or not np.isfinite(last.velocity_after):
        return False
    back = -2 * last.side * last.velocity_after / pull
    return bool(last.frame + FALLEN_BACK * back < motion.frame[-1])

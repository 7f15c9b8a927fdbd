"""What speaks for the impacts found in a clip, what is in doubt, and why it supports no count.

Every impact and every doubt is one independent chance: an impact that few pictures show may be
none, a flight that strays from free flight may hide one more. The count's probabilities are those
of their sum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from count_video.motion.flight import Motion, straying
from count_video.motion.impacts import Impact
from count_video.motion.joint import BodyErrors
from count_video.motion.missing import (
    chance_before,
    dies_out,
    ends_at_stop,
    in_series,
    lost_after,
    passed_over,
)
from count_video.motion.priors import (
    CHANCE_CLEAR,
    CHANCE_CUT_OFF,
    CHANCE_DYING,
    CHANCE_HARDLY_SHOWN,
    CHANCE_PASSED_OVER,
    CHANCE_SINGLE,
    CHANCE_STRAYING,
    CHANCE_WEAK,
    CHANCES_LOST,
    CHANCES_TAIL,
)
from count_video.motion.resolution import RESOLVED_FRAMES
from count_video.reasons import Cause, Reason
from count_video.records import Collision

CLEAR_SIGMAS = 10.0
CERTAIN_PICTURES = 4
"""One impact at least must be as clear as this, and shown by so many pictures on either side."""
STRAYING_AT_MOST = 0.4
"""Where a larger share of the flights strays, the turns are not those of a body that bounces."""


@dataclass(frozen=True)
class SeenImpacts:
    """What the frames of one clip show."""

    collisions: tuple[Collision, ...]
    """In order of time, numbered from 1; real times are not filled in."""
    shortcomings: tuple[Reason, ...]
    """Why the clip supports no count; empty if it does."""
    doubts: tuple[Reason, ...]
    """What lowers the probability."""
    probability: dict[int, float]
    """Of each count."""
    errors: BodyErrors = ()
    """Of the places of each body, the first one of two that at smaller positions."""


def weighed(
    motion: Motion,
    impacts: Sequence[Impact],
    timing: tuple[float, float],
    collisions: Sequence[Collision],
) -> SeenImpacts:
    """Weigh what was found.

    ``timing`` is half the time that a contact takes, in pictures, and the frames a picture;
    ``collisions`` are the impacts as they will be given.
    """
    contact, pace = timing
    frames = [impact.frame for impact in impacts]
    strays = straying(motion, frames, contact)
    paired = zip(impacts, collisions, strict=True)
    chances = [_chance(impact, impacts, collision.kind) for impact, collision in paired]
    out = dies_out(motion, impacts)
    if out:  # an impact where the series has one is no chance turn
        expected = in_series(impacts)
        chances = [
            max(chance, CHANCE_CLEAR) if known else chance
            for chance, known in zip(chances, expected, strict=True)
        ]
    doubts: list[Reason] = []
    if strays:
        spans = tuple(frame * pace for span in strays for frame in span)
        doubts.append(Reason(Cause.NOT_FREE, spans))
        chances += [CHANCE_STRAYING] * len(strays)
    if impacts and (unseen := chance_before(motion, impacts)) > 0:
        doubts.append(Reason(Cause.BEFORE_UNSEEN))
        chances.append(unseen)
    over = [turn for turn in passed_over(motion, impacts) if not (out and turn > frames[-1])]
    if over:
        doubts.append(Reason(Cause.TURNS_OPEN, tuple(frame * pace for frame in over)))
        chances += [CHANCE_PASSED_OVER] * len(over)
    if out:  # what follows is not counted, and comes to rest at the stop
        doubts.append(Reason(Cause.DIES_OUT))
        chances.append(CHANCE_DYING)
    elif cut_off := ends_at_stop(motion, impacts):
        doubts.append(Reason(Cause.CUT_AT_STOP))
        chances += [CHANCE_CUT_OFF] * cut_off
    close = any(b - a < RESOLVED_FRAMES for a, b in pairwise(frames))
    if not out and (close or lost_after(motion, impacts)):
        doubts.append(Reason(Cause.TOO_FREQUENT))
        chances += CHANCES_TAIL if close else CHANCES_LOST
    shortcomings = tuple(_shortcomings(impacts, len(strays)))
    return SeenImpacts(tuple(collisions), shortcomings, tuple(doubts), chances_of_sum(chances))


def with_wall_ahead(found: SeenImpacts) -> SeenImpacts:
    """Refuse a count of two bodies one of which moves towards something when the clip ends.

    If that is a wall, this is the first collision of a trial and no smaller experiment.
    """
    return replace(found, shortcomings=(*found.shortcomings, Reason(Cause.WALL_AHEAD)))


def _shortcomings(impacts: Sequence[Impact], strays: int) -> list[Reason]:
    if not impacts:
        return [Reason(Cause.NO_IMPACT)]
    if not any(_is_certain(impact) for impact in impacts):
        return [Reason(Cause.TOO_FAINT)]
    if strays > STRAYING_AT_MOST * max(len(impacts) - 1, 1):
        return [Reason(Cause.NO_FLIGHTS)]
    return []


def _is_certain(impact: Impact) -> bool:
    return impact.clarity > CLEAR_SIGMAS and impact.pictures >= CERTAIN_PICTURES


def _chance(impact: Impact, impacts: Sequence[Impact], kind: str) -> float:
    if impact.clarity == 0:
        return CHANCE_HARDLY_SHOWN
    clear = CHANCE_CLEAR if impact.clarity > CLEAR_SIGMAS else CHANCE_WEAK
    alone = sum(other.side == impact.side for other in impacts) == 1
    return min(clear, CHANCE_SINGLE) if alone and kind == "wall" else clear


CHANCE_AT_LEAST = 0.005
"""Counts less probable than this are left out."""


def chances_of_sum(chances: Sequence[float]) -> dict[int, float]:
    """Probability of each number of independent events that come true, given the chance of each."""
    sums = [1.0]
    for chance in chances:
        missed = [share * (1 - chance) for share in (*sums, 0.0)]
        met = [share * chance for share in (0.0, *sums)]
        sums = [a + b for a, b in zip(missed, met, strict=True)]
    likely = {number: share for number, share in enumerate(sums) if share >= CHANCE_AT_LEAST}
    total = sum(likely.values())
    return {number: share / total for number, share in likely.items()}

"""Which explanation of a clip stands: of several pairs of bodies, and of bodies alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from count_video.explanations import Explanation
from count_video.reasons import Cause, Reason
from count_video.scenes import IMPACTS_OF_ONE_ALONE, turns_on_both_sides

AT_ONCE_FRAMES = 1.0
"""Impacts of a body and of its shadow come at the same time, to a frame."""


def likeliest_pair(explanations: Iterable[Explanation]) -> Explanation | None:
    """Choose one of two bodies each; they come with the likeliest first and are made one by one.

    The first whose heavy body's path fits its collisions is taken, or that counts at a wall. If
    none does, one that counts comes first, and one at a wall before others.
    """
    others = []
    for one in explanations:
        if one.path_fits or (one.track.wall_seen and one.counts):
            return one
        others.append(one)
    return max(others, key=lambda one: (one.counts, one.track.wall_seen), default=None)


def of_bodies_alone(explanations: Sequence[Explanation]) -> Explanation:
    """Choose one of several bodies, each taken alone: the only one that counts, or the first.

    The ball of a trial comes before those at a stop. If more count, but for shadows, which of them
    is meant is not known; and where more than one body moves, a few impacts, or those of one that
    turns at both ends of its way, may be of a trial: its ball turns at wall and heavy body.
    """
    counted = [one for one in explanations if one.counts]
    counted = [one for one in counted if one.scene == "wall"] or counted
    first = (*counted, explanations[0])[0]
    apart = [one for one in counted if not _strikes_with(one, first)]
    if apart:
        return replace(first, against=(Reason(Cause.SEVERAL_BOUNCE, (1 + len(apart),)),))
    others = len(explanations) - 1
    of_trial = first.count < IMPACTS_OF_ONE_ALONE or turns_on_both_sides(first)
    if counted and others and of_trial and first.scene != "wall":
        return replace(first, against=(Reason(Cause.OTHERS_MOVE, (first.count, others)),))
    return first


def _strikes_with(one: Explanation, other: Explanation) -> bool:
    """Whether all impacts of two bodies come at once: what strikes is one body, with its shadow."""
    frames = [[impact.frame for impact in body.collisions] for body in (one, other)]
    if len(frames[0]) != len(frames[1]):
        return False
    return all(abs(a - b) <= AT_ONCE_FRAMES for a, b in zip(*frames, strict=True))


def is_settled(pair: Explanation) -> bool:
    """Whether a count of two bodies need not be compared with that of one body alone.

    Without a wall many impacts may be those of one body alone on its mirror image.
    """
    few = pair.scene == "wall" or pair.count < IMPACTS_OF_ONE_ALONE
    return pair.counts and few and may_be_bodies(pair)


def may_be_bodies(pair: Explanation) -> bool:
    """Whether what was followed to a wall touches, shows momentum to be kept, or obeys the law.

    Parts of bodies that were followed do none of these. That they obey the law is shown by a fit
    only if the frames show a collision of it.
    """
    shown = (pair.fit is not None and pair.fit.shown > 0) or pair.path_shows
    return pair.scene != "wall" or shown or not pair.outlines_apart


def stands_before(pair: Explanation, alone: Explanation, moving: int) -> bool:
    """Whether the explanation by two bodies comes before that by one body alone.

    It does if one alone gives no count, but for impacts where two have none, or at a wall a count
    of a few impacts; or if a ball was seen to strike both wall and heavy body, and the heavy body's
    path shows it, where more bodies move on their own: the path of a body and its shadow may fit a
    few collisions. A count by the ball of a trial alone is of the same trial, and stands. Parts of
    bodies come first only if there is no count of one alone, or a few impacts where they collide
    more often.

    ``moving`` is the number of bodies that move on their own.
    """
    few = alone.count < IMPACTS_OF_ONE_ALONE and pair.track.wall_seen and pair.count > 0
    if not may_be_bodies(pair):
        if few and pair.count > alone.count:
            return True
        return not alone.counts and not (alone.count and not pair.counts)
    if not alone.counts:
        return pair.counts or pair.count > 0 or not alone.count
    both = len({collision.kind for collision in pair.collisions}) > 1
    at_stop = alone.scene == "stop"
    return few or (pair.path_shows and both and moving > 1 and at_stop)

"""What two bodies or one show: at a wall, without one, at a stop, or struck by one unseen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from count_video.explanations import Explanation, at_wall, by_impacts, completed, shown_at_wall
from count_video.motion.fitted import fit_burst
from count_video.motion.flight import LAW_SIGMAS
from count_video.motion.meeting import only_turns, without_wall
from count_video.motion.parameters import Knowledge
from count_video.motion.priors import PARTNER_UNSEEN, STANDS_STILL
from count_video.motion.stretches import longest_shot, without_still
from count_video.motion.struck import struck_ball, with_unseen_heavy
from count_video.motion.time_hypotheses import usual_times
from count_video.reasons import Cause, Reason
from count_video.records import Track
from count_video.signals import sigma_of

IMPACTS_OF_ONE_ALONE = 3
"""So many impacts at one stop are those of one body that bounces, not of one of two in a trial."""
BLOWS_AT_LEAST = 3
"""Each blow of a body that is not seen gives a place and a jump, the first one a jump alone; what
the law of a trial leaves open of that body are its velocity, its mass and the restitution. So with
three blows five numbers show whether three describe them."""


# ---- two bodies ----------------------------------------------------------------------------------


StandsBeyond = Callable[[Track], tuple[bool, bool]]
"""Whether one of two bodies comes from something as the clip begins, and goes to it as it ends."""


def of_pair(track: Track, known: Knowledge, stands_beyond: StandsBeyond) -> Explanation:
    """Explain a track of two bodies, at a wall or, where none is shown, without one.

    Where the track as it is shows no trial, the longest stretch between cuts may show one.
    """

    def explained(part: Track) -> Explanation:
        moving = without_still(part)
        one = _of_moving(moving, known, stands_beyond)
        if len(moving.frame) == len(part.frame):
            return one
        return replace(one, notes=(*one.notes, _frames(Cause.STANDS_STILL, moving)))

    best = explained(track)
    if not best.counts and len((shot := longest_shot(track)).frame) < len(track.frame):
        alone = explained(shot)
        if alone.counts:
            return replace(alone, notes=(*alone.notes, _frames(Cause.OTHER_SHOTS, shot)))
    return best


def _frames(cause: Cause, shown: Track) -> Reason:
    """Say which frames alone are counted."""
    return Reason(cause, (float(shown.frame[0]), float(shown.frame[-1])))


def _of_moving(track: Track, known: Knowledge, stands_beyond: StandsBeyond) -> Explanation:
    """Explain a track without cuts and still pictures."""
    walled = at_wall(track, known) if track.wall_seen else None
    if walled is not None and not only_turns(track, walled.collisions):
        return walled
    free = without_a_wall(track, known, stands_beyond)
    return free if walled is None or free.counts or walled.counts else walled


def without_a_wall(track: Track, known: Knowledge, stands_beyond: StandsBeyond) -> Explanation:
    """Explain a track by two bodies that meet.

    Where one comes from something else as the clip begins, or goes to it as it ends, they may be
    those of a trial whose wall was left before the clip, or is not reached in it. What one does
    that is lost within the picture nobody knows.
    """
    pair = replace(without_wall(track), wall_seen=track.wall_seen)
    explained = by_impacts(pair, known)
    if not explained.collisions or explained.against:
        return explained
    against: list[Reason] = []
    if len(explained.collisions) == 1:  # the ball of a trial meets the wall between two
        causes = zip((Cause.WALL_BEHIND, Cause.WALL_AHEAD), stands_beyond(track), strict=True)
        against = [Reason(one) for one, stands in causes if stands]
    against += [Reason(Cause.LOST, (frame,)) for frame in track.lost_beyond]
    return replace(explained, against=tuple(against))


# ---- one body ------------------------------------------------------------------------------------


def at_a_stop(track: Track, known: Knowledge, moves_beside: Callable[[float], bool]) -> Explanation:
    """Explain a track by one body alone.

    ``moves_beside`` says whether something that was not followed moves where the body turns at a
    frame: then, or if nothing shows it, it may be one of the bodies of a trial.
    """
    alone = by_impacts(track, known)
    few = alone.count < IMPACTS_OF_ONE_ALONE
    if not alone.counts or not (few or turns_on_both_sides(alone)):
        return alone
    moving = next((one.frame for one in alone.collisions if moves_beside(one.frame)), None)
    if moving is not None:
        return replace(alone, against=(Reason(Cause.MOVES_BESIDE, (moving,)),))
    if not few:
        return alone
    stands_still, meets_still = STANDS_STILL
    partner = PARTNER_UNSEEN * meets_still
    unseen = partner / (partner + (1 - PARTNER_UNSEEN) * stands_still)
    return replace(
        alone,
        probability={number: (1 - unseen) * p for number, p in alone.probability.items()},
        doubts=(*alone.doubts, Reason(Cause.PARTNER_UNSEEN, (unseen,))),
    )


def turns_on_both_sides(alone: Explanation) -> bool:
    """Whether impacts turn a body round at both ends of its way, as wall and cylinder do a ball."""
    return len({one.push for one in alone.collisions if one.push}) > 1


def struck_unseen(track: Track, known: Knowledge) -> Explanation | None:
    """Explain a body alone by the ball of a trial whose heavy body is not seen.

    None if nothing strikes it at rest, or its path is not that of such a ball.
    """
    base = usual_times(track)
    struck = struck_ball(base.evened(track))
    if struck is None:
        return None
    evened, found = struck
    shown = shown_at_wall(with_unseen_heavy(track, evened.wall_side), found)
    shown = replace(shown, notes=(Reason(Cause.HEAVY_UNSEEN),))
    explained = completed(shown, fit_burst(evened, found, known), base, known)
    return explained if explained.counts and _rests_on_frames(explained) else None


def _rests_on_frames(explained: Explanation) -> bool:
    """Whether what the frames show of a ball puts the law of a trial to a test that it passes.

    The fit has a place for all collisions seen, frames show half of its own at least, there are
    blows enough, and little is left over beside what free flights leave between the collisions: of
    a body that is not seen nothing else is known.
    """
    fit, found = explained.fit, explained.found
    if fit is None or found is None:
        return False
    blows = sum(one.kind == "bodies" for one in fit.collisions)
    tested = fit.count >= found.burst and 2 * fit.shown >= fit.count and blows >= BLOWS_AT_LEAST
    errors = found.errors[0]
    flights_px = errors.sigma_px if errors else sigma_of(explained.track.ball.position_px)
    return tested and fit.misfit_px < LAW_SIGMAS * flights_px


def of_one(track: Track, known: Knowledge, moves_beside: Callable[[float], bool]) -> Explanation:
    """Explain a track of one body, at a stop or, if it cannot be, struck by one that is not seen.

    See ``at_a_stop`` and ``at_wall``.
    """
    alone = at_a_stop(track, known, moves_beside)
    struck = None if alone.counts or known.seen_only else struck_unseen(track, known)
    return struck or alone

"""Two bodies: ball and cylinder at a wall, or two that meet without one, in a clip or a part."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from count_video.explanations import Explanation, at_wall, by_impacts
from count_video.motion.meeting import only_turns, without_wall
from count_video.motion.parameters import Knowledge
from count_video.motion.stretches import longest_shot, without_still
from count_video.reasons import Cause, Reason
from count_video.records import Track


def of_pair(
    track: Track, known: Knowledge, stands_beyond: Callable[[Track], tuple[bool, bool]]
) -> Explanation:
    """Explain a track of two bodies, at a wall or, where none is shown, without one.

    Where the track as it is shows no trial, the longest stretch between cuts may show one.
    ``stands_beyond`` says whether one of them comes from something as the clip begins, and whether
    one goes to something as it ends.
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


def _of_moving(
    track: Track, known: Knowledge, stands_beyond: Callable[[Track], tuple[bool, bool]]
) -> Explanation:
    """Explain a track without cuts and still pictures."""
    walled = at_wall(track, known) if track.wall_seen else None
    if walled is not None and not only_turns(track, walled.collisions):
        return walled
    free = without_a_wall(track, known, stands_beyond)
    return free if walled is None or free.counts or walled.counts else walled


def without_a_wall(
    track: Track, known: Knowledge, stands_beyond: Callable[[Track], tuple[bool, bool]]
) -> Explanation:
    """Explain a track by two bodies that meet.

    Where one comes from something else as the clip begins, or goes to it as it ends, they may be
    those of a trial whose wall was left before the clip, or is not reached in it. What one does
    that is lost within the picture nobody knows.
    """
    pair = replace(without_wall(track), wall_seen=track.wall_seen)
    explained = by_impacts(pair, known)
    if not explained.collisions or explained.against:
        return explained
    causes = zip((Cause.WALL_BEHIND, Cause.WALL_AHEAD), stands_beyond(track), strict=True)
    against = [Reason(one) for one, stands in causes if stands]
    against += [Reason(Cause.LOST, (frame,)) for frame in track.lost_beyond]
    return replace(explained, against=tuple(against))

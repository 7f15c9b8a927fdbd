"""Which explanation of a clip counts: two bodies at a wall, two without one, or one body alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from count_video.motion.fitted import Between, Misfit
from count_video.motion.reasons import Cause, Reason
from count_video.motion.seen import SeenCollisions
from count_video.records import FootageInfo, Track, TrialResult
from count_video.verdict.wording import sentence

PATH_SIGMAS = 4.0
"""The heavy body's path shows its collisions if they exceed their uncertainty by this factor."""
FOLLOWED = 0.95
"""A track that shows both bodies in such a share of the frames, from first to last sighting, lost
neither."""
BOTH = 2
"""Kinds of collisions: a trial at a wall has those of the bodies and those with the wall."""
IMPACTS_OF_ONE_ALONE = 3
"""So many impacts at one stop are those of one body that bounces, not of one of two in a trial."""


@dataclass(frozen=True)
class Trial:
    """One clip worked through: the answer and what it rests on."""

    result: TrialResult
    info: FootageInfo
    track: Track | None
    """None where no bodies could be followed."""
    found: SeenCollisions | None
    """What the frames show; None without a track."""
    between: Between | Misfit | None = None
    """What a fitted model says where the frames leave doubts; None where it was not asked."""


def likeliest(trials: Iterable[Trial]) -> Trial | None:
    """Return the first of some trials whose heavy body's path fits its collisions.

    They come with the likeliest first, and are worked through one by one. The first two bodies at a
    wall stand for the others if no path fits; None if there are no trials.
    """
    best: Trial | None = None
    for trial in trials:
        counted = trial.result.status == "counted"
        if counted and _path_fits(trial):
            return trial
        better = counted and best is not None and best.result.status != "counted"
        at_wall = trial.track is not None and trial.track.wall_seen
        if better or best is None or _path_fits(trial) or (at_wall and not _stands(best)):
            best = trial
            if (at_wall and counted) or _path_fits(best):
                break
    return best


def only_counted(trials: Sequence[Trial]) -> Trial:
    """Return the one trial of several bodies, each taken alone, that is counted.

    The first one stands for them if none is. If more are, which of them is meant is not known; and
    a few impacts, where more than one body moves, may be those of a trial.
    """
    counted = [trial for trial in trials if trial.result.count is not None]
    first = counted[0] if counted else trials[0]
    count = first.result.count
    if len(counted) > 1:
        why = sentence(Reason(Cause.SEVERAL_BOUNCE, (len(counted),)))
    elif count is not None and count < IMPACTS_OF_ONE_ALONE and len(trials) > 1:
        why = sentence(Reason(Cause.OTHERS_MOVE, (count, len(trials) - 1)))
    else:
        return first
    refused = replace(first.result, status="not_counted", reason=why, count=None, probability={})
    return replace(first, result=replace(refused, between_frames=None))


def may_be_bodies(trial: Trial) -> bool:
    """Whether what was followed to a wall touches, shows momentum to be kept, or obeys the law.

    Parts of bodies that were followed do none of these.
    """
    if trial.found is None or trial.track is None:
        return True
    touching = trial.result.millimetres_per_px is not None
    return touching or isinstance(trial.between, Between) or path_shows(trial)


def path_shows(trial: Trial) -> bool:
    """Whether the heavy body's path fits the collisions, and would not do so without them.

    Scenery that is taken for a body drifts along without any.
    """
    swing = trial.found.swing if trial.found is not None else None
    shows = swing is not None and PATH_SIGMAS * swing.mass_ratio_relative_sigma < 1
    return shows and _path_fits(trial)


def is_settled(trial: Trial) -> bool:
    """Whether a count of two bodies need not be compared with that of one body alone.

    Without a wall many impacts may be those of one body alone on its mirror image.
    """
    count = trial.result.count
    return count is not None and (trial.found is not None or count < IMPACTS_OF_ONE_ALONE)


def is_better(alone: Trial, pair: Trial, moving: int) -> bool:
    """Whether the answer for one body alone, or two without a wall, comes before that for a pair.

    The pair's wall stands if a ball was seen to strike both wall and heavy body, by a track that
    did not lose the bodies where the other does not, and the heavy body's path shows it; before one
    body alone if there are more bodies that move on their own: the path of a body and its shadow
    may fit a few collisions.

    ``moving`` is the number of bodies that move on their own.
    """
    if alone.result.count is None or alone.track is None:
        return False
    shown = path_shows(pair)
    kinds = {collision.kind for collision in pair.result.collisions}
    if alone.track.heavy is None:
        if shown and len(kinds) == BOTH and moving > 1:
            return False
        no_wall = pair.track is None or not pair.track.wall_seen
        return alone.result.count >= IMPACTS_OF_ONE_ALONE or no_wall
    if pair.track is None or not (pair.track.wall_seen and shown):
        return True
    return len(kinds) < BOTH or _followed(pair.track) < FOLLOWED <= _followed(alone.track)


def _path_fits(trial: Trial) -> bool:
    return trial.found is not None and trial.found.path_fits


def _stands(trial: Trial) -> bool:
    """Whether a trial keeps its place before the next two bodies at a wall."""
    at_wall = trial.track is not None and trial.track.wall_seen
    return at_wall or trial.result.status == "counted"


def _followed(track: Track) -> float:
    """Share of the frames in which a body is seen, from its first to its last sighting."""
    shares = []
    for body in (track.ball, track.heavy):
        seen = np.isfinite(body.position_px) if body is not None else np.ones(1, dtype=bool)
        rows = np.flatnonzero(seen)
        shares.append(float(seen[rows[0] : rows[-1] + 1].mean()) if len(rows) else 0.0)
    return min(shares)

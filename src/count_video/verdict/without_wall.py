"""The answer for one body alone, or two without a wall; and which of two looks at a clip counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from count_video.motion.weighing import SeenImpacts
from count_video.records import FootageInfo, FootageReport, Track, TrialResult
from count_video.verdict.answers import nothing_to_count, timed, with_missing
from count_video.verdict.wording import sentences

IMPACTS_PROBABILITY_AT_LEAST = 0.25
"""A smaller number of impacts is a lower bound, no count: more of them are likely not seen."""
FOLLOWED = 0.95
"""A track that shows both bodies in such a share of the frames, from first to last sighting, lost
neither."""
BOTH = 2
"""Kinds of collisions: a trial at a wall has those of the bodies and those with the wall."""
FEW_OF_A_TRIAL = 3
"""So few collisions may be borne out by a body and its shadow."""
IMPACTS_OF_ONE_ALONE = 3
"""So many impacts at one stop are those of one body that bounces, not of one of two in a trial."""


def impacts_counted(
    info: FootageInfo, report: FootageReport, track: Track, found: SeenImpacts
) -> TrialResult:
    """Judge what was found in a clip of one body alone, or of two without a wall."""
    collisions = tuple(timed(collision, info.capture_fps) for collision in found.collisions)
    probability = with_missing(found.probability, len(collisions), report)
    chance = probability.get(len(collisions), 0.0)
    likely = chance >= max(IMPACTS_PROBABILITY_AT_LEAST, *probability.values(), 0.0)
    counts = likely and not found.shortcomings
    reason = sentences(found.shortcomings or found.doubts)
    if not (likely or found.shortcomings):
        likelier = max(probability, key=probability.__getitem__)
        more = f"{len(collisions)} impacts are seen, but {likelier} are likelier"
        reason = f"{reason}; {more}" if reason else more
    return replace(
        nothing_to_count(info, report, ""),
        status="counted" if counts else "not_counted",
        reason=reason,
        count=len(collisions) if counts else None,
        seen=len(collisions),
        between_frames=0 if counts else None,
        probability=probability if counts else {},
        count_after_burst=0,
        collisions=collisions,
        wall_side=track.wall_side if track.heavy is None else None,
        ball_diameter_px=track.ball_diameter_px,
        warnings=(*report.warnings, *track.warnings),
    )


def is_settled(result: TrialResult, *, at_wall: bool) -> bool:
    """Whether a count of two bodies needs no other look at the clip.

    Without a wall many impacts may be those of one body alone on its mirror image.
    """
    return result.count is not None and (at_wall or result.count < IMPACTS_OF_ONE_ALONE)


def is_better(
    result: TrialResult,
    track: Track | None,
    first: TrialResult,
    pair: Track | None,
    *,
    borne_out: bool,
) -> bool:
    """Whether what the second look tells comes before what the ``first`` told of a pair.

    The first look's wall stands if a ball was seen to strike both wall and heavy body, by a track
    that did not lose the bodies where the second look's does not, and the heavy body's path bears
    it out; before one body alone if it bears out several such collisions.
    """
    if result.count is None or track is None:
        return False
    kinds = {collision.kind for collision in first.collisions}
    if track.heavy is None:
        if borne_out and len(kinds) == BOTH and len(first.collisions) > FEW_OF_A_TRIAL:
            return False
        return result.count >= IMPACTS_OF_ONE_ALONE or pair is None or not pair.wall_seen
    if pair is None or not (pair.wall_seen and borne_out):
        return True
    return len(kinds) < BOTH or _followed(pair) < FOLLOWED <= _followed(track)


def _followed(track: Track) -> float:
    """Share of the frames in which a body is seen, from its first to its last sighting."""
    shares = []
    for body in (track.ball, track.heavy):
        seen = np.isfinite(body.position_px) if body is not None else np.ones(1, dtype=bool)
        rows = np.flatnonzero(seen)
        shares.append(float(seen[rows[0] : rows[-1] + 1].mean()) if len(rows) else 0.0)
    return min(shares)

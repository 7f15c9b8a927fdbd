"""The answer for one body alone, or for two without a wall."""

from __future__ import annotations

from dataclasses import replace

from count_video.motion.weighing import SeenImpacts
from count_video.records import FootageInfo, FootageReport, Track, TrialResult
from count_video.verdict.answers import nothing_to_count, timed, with_missing
from count_video.verdict.wording import sentences

IMPACTS_PROBABILITY_AT_LEAST = 0.25
"""A smaller number of impacts is a lower bound, no count: more of them are likely not seen."""


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

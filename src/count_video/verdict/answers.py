"""Answers without a wall, or without a count; times, and the doubt where pictures are missing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from count_video.footage.clock import real_time_s
from count_video.motion.weighing import SeenImpacts
from count_video.records import Collision, FootageInfo, FootageReport, Track, TrialResult
from count_video.verdict.wording import sentences

IMPACTS_PROBABILITY_AT_LEAST = 0.25
"""A smaller number of impacts is a lower bound, no count: more of them are likely not seen."""


def unread_result(clip: str, reason: str) -> TrialResult:
    """Make the answer for a clip of which nothing is known but why it could not be read."""
    return TrialResult(clip=clip, status="not_counted", reason=reason)


def nothing_to_count(info: FootageInfo, report: FootageReport, reason: str) -> TrialResult:
    """Answer for a clip that was read but shows nothing that can be counted."""
    return replace(
        unread_result(str(info.path), reason),
        capture_fps=info.capture_fps,
        capture_fps_source=info.capture_fps_source,
        frames_decoded=report.frames_decoded,
        frames_promised=report.frames_promised,
        warnings=report.warnings,
    )


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


def timed(collision: Collision, capture_fps: float | None) -> Collision:
    """Add the time since the clip's start in seconds, where the camera's rate is known."""
    if capture_fps is None:
        return collision
    return replace(collision, time_s=real_time_s(collision.frame, capture_fps))


def with_missing(
    probability: Mapping[int, float], count: int, report: FootageReport
) -> dict[int, float]:
    """Let collisions happen in the pictures that are missing as often as in those that are there.

    They come at random then (Poisson): the chance that none is missing is exp(-expected), and what
    this takes from the chances is that of one more.
    """
    expected = count * report.frames_missing / max(1, report.frames_decoded)
    none = math.exp(-expected)
    changed = {number: chance * none for number, chance in probability.items()}
    if expected:
        changed[count + 1] = changed.get(count + 1, 0.0) + (1 - none) * sum(probability.values())
    return changed


def doubted_for_missing(result: TrialResult, report: FootageReport) -> TrialResult:
    """Doubt a count where pictures are missing and nothing says that the burst was over."""
    if result.count is None or result.ending is not None or not report.frames_missing:
        return result
    missing = f"{report.frames_missing} frames are missing, in which collisions may have happened"
    return replace(
        result,
        reason="; ".join(filter(None, (result.reason, missing))),
        probability=with_missing(result.probability, result.count, report),
    )

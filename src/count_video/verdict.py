"""From what the frames show to the answer: counted or not, how sure, and what to do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from count_video.collisions.seen import SeenCollisions
from count_video.footage.clock import real_time_s
from count_video.physics.theory import pi_bounds
from count_video.records import (
    Collision,
    FootageInfo,
    FootageReport,
    Track,
    TrialResult,
)

PROBABILITY_RESOLVED = 0.98
"""Share of resolved clips that come out right, not above what tests have shown."""
MASS_RATIO_SIGMA_AT_MOST = 0.1
"""A measured mass ratio is told only if it is known to this share."""


def counted(
    info: FootageInfo,
    report: FootageReport,
    track: Track,
    found: SeenCollisions,
    masses: tuple[Fraction, Fraction] | None,
    ball_diameter_mm: float,
) -> TrialResult:
    """Judge what was found in a clip with both bodies."""
    collisions = tuple(_timed(collision, info.capture_fps) for collision in found.collisions)
    reason = why_not(found)
    count = None if reason else found.burst
    ratio = _ratio(found, masses)
    pi = pi_bounds(count, *ratio) if count and ratio else None
    return replace(
        nothing_to_count(info, report, reason or ""),
        status="not_counted" if reason else "counted",
        reason=reason,
        count=count,
        seen=found.burst,
        between_frames=None if reason else 0,
        probability={} if count is None else probabilities(count),
        count_after_burst=len(collisions) - found.burst,
        collisions=collisions,
        wall_side=track.wall_side,
        ball_diameter_px=track.ball_diameter_px,
        millimetres_per_px=ball_diameter_mm / track.ball_diameter_px,
        pi_low=None if pi is None else pi.low,
        pi_high=None if pi is None else pi.high,
        mass_ratio=None if ratio is None else float(ratio[0] / ratio[1]),
        warnings=(*report.warnings, *track.warnings),
    )


def nothing_to_count(info: FootageInfo, report: FootageReport, reason: str) -> TrialResult:
    """Answer for a clip that was read but shows nothing that can be counted."""
    return TrialResult(
        clip=str(info.path),
        status="not_counted",
        reason=reason,
        count=None,
        seen=None,
        between_frames=None,
        probability={},
        count_after_burst=None,
        collisions=(),
        capture_fps=info.capture_fps,
        capture_fps_source=info.capture_fps_source,
        frames_decoded=report.frames_decoded,
        frames_promised=report.frames_promised,
        wall_side=None,
        ball_diameter_px=None,
        millimetres_per_px=None,
        pi_low=None,
        pi_high=None,
        mass_ratio=None,
        warnings=report.warnings,
    )


def why_not(found: SeenCollisions) -> str | None:
    """Why the burst cannot be counted, as one sentence; None if it can."""
    if found.burst == 0:
        return "no collision is seen: no gap between two bodies closes and opens with a jump"
    reasons: Sequence[str] = (*found.shortcomings, *found.doubts)
    return "; ".join(reasons) if reasons else None


def probabilities(count: int) -> dict[int, float]:
    """Probability of each count where all collisions are resolved.

    What is left to doubt is shared between one more and one fewer.
    """
    rest = (1 - PROBABILITY_RESOLVED) / 2
    return {count - 1: rest, count: PROBABILITY_RESOLVED, count + 1: rest}


def _ratio(
    found: SeenCollisions, masses: tuple[Fraction, Fraction] | None
) -> tuple[Fraction | float, Fraction | float] | None:
    if masses is not None:
        return masses
    swing = found.swing
    if swing is None or swing.mass_ratio_relative_sigma > MASS_RATIO_SIGMA_AT_MOST:
        return None
    return swing.mass_ratio, 1


def _timed(collision: Collision, capture_fps: float | None) -> Collision:
    if capture_fps is None:
        return collision
    return replace(collision, time_s=real_time_s(collision.frame, capture_fps))

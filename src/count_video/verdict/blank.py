"""Answers without a count: of a clip that could not be read, or that shows nothing to count."""

from __future__ import annotations

from dataclasses import replace

from count_video.records import FootageInfo, FootageReport, TrialResult


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

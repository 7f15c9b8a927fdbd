"""What every answer is made of: its blank form, times, masses, and pictures that are missing.

And the answer for one body alone, or for two without a wall, which needs no more than that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from count_video.footage.capture_rate import real_time_s
from count_video.motion.weighing import SeenImpacts
from count_video.physics.theory import pi_bounds
from count_video.records import (
    Collision,
    Estimate,
    FootageInfo,
    FootageReport,
    Track,
    TrialResult,
)
from count_video.verdict.wording import sentences


def unread_result(clip: str, reason: str) -> TrialResult:
    """Make the answer for a clip of which nothing is known but why it could not be read."""
    return TrialResult(clip=clip, status="not_counted", reason=reason)


def nothing_to_count(info: FootageInfo, report: FootageReport, reason: str) -> TrialResult:
    """Answer for a clip that was read but shows nothing that can be counted."""
    if report.frames_decoded == 1:
        reason = "one picture alone could be read, in which nothing moves; give the whole clip"
    return replace(
        unread_result(str(info.path), reason),
        capture_fps=info.capture_fps,
        capture_fps_source=info.capture_fps_source,
        frames_decoded=report.frames_decoded,
        frames_promised=report.frames_promised,
        warnings=report.warnings,
    )


def timed(collision: Collision, capture_fps: float | None) -> Collision:
    """Add the time since the clip's start in seconds, where the camera's rate is known."""
    if capture_fps is None:
        return collision
    return replace(collision, time_s=real_time_s(collision.frame, capture_fps))


RELATIVE_SIGMA_AT_MOST = 0.1
"""A measured mass ratio is given only if it is known to this share."""
WEIGHED_SHARE = 0.01
"""Standard uncertainty of a mass ratio that somebody gives: kitchen scales, tape on the ball."""
CONTRADICTING_SIGMAS = 4.0
"""Given masses contradict the motion beyond this many standard uncertainties of both."""


def with_masses(result: TrialResult, heavy: Fraction, light: Fraction) -> TrialResult:
    """Complete an answer by masses that the user gave, exact and in any one unit."""
    return _bounded(replace(result, mass_ratio=float(heavy / light)), heavy, light)


def contradiction(given: float, measured: Estimate) -> tuple[str, ...]:
    """Say that a given mass ratio contradicts the motion, as a sentence; empty if it does not."""
    sigma = math.hypot(WEIGHED_SHARE * given, measured.sigma)
    known = measured.sigma <= RELATIVE_SIGMA_AT_MOST * measured.value
    if not known or abs(given - measured.value) <= CONTRADICTING_SIGMAS * sigma:
        return ()
    return (
        f"the masses given have the ratio {given:.4g}, the motion shows {measured.value:.4g} +- "
        f"{measured.sigma:.2g}: check --masses, the cylinder's first",
    )


def with_mass_ratio(result: TrialResult, measured: Estimate) -> TrialResult:
    """Complete an answer by a measured mass ratio, instead of one that was measured before.

    What the user gave stands. A ratio that the motion hardly determines is left out.
    """
    if result.mass_ratio is not None and result.mass_ratio_sigma is None:
        return _bounded(result, result.mass_ratio, 1)
    if measured.sigma > RELATIVE_SIGMA_AT_MOST * measured.value:
        return result
    completed = replace(result, mass_ratio=measured.value, mass_ratio_sigma=measured.sigma)
    return _bounded(completed, measured.value, 1)


def _bounded(result: TrialResult, heavy: Fraction | float, light: Fraction | float) -> TrialResult:
    """Bound pi by N theta and (N + 1) theta; no count bounds nothing."""
    if not result.count:
        return result
    pi = pi_bounds(result.count, heavy, light)
    return replace(result, pi_low=pi.low, pi_high=pi.high)


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


PROBABILITY_AT_LEAST = 0.5
"""A count of which anything is in doubt must be as probable as all others together."""


def impacts_counted(
    info: FootageInfo, report: FootageReport, track: Track, found: SeenImpacts
) -> TrialResult:
    """Judge what was found in a clip of one body alone, or of two without a wall."""
    collisions = tuple(timed(collision, info.capture_fps) for collision in found.collisions)
    probability = with_missing(found.probability, len(collisions), report)
    chance = probability.get(len(collisions), 0.0)
    likely = chance >= PROBABILITY_AT_LEAST
    counts = likely and not found.shortcomings
    reason = sentences(found.shortcomings or found.doubts)
    if not (likely or found.shortcomings):
        more = f"that the impacts seen ({len(collisions)}) are all of them is {chance:.0%} probable"
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
        upright=track.line.upright,
        ball_diameter_px=track.ball_diameter_px,
        warnings=(*report.warnings, *track.warnings),
    )

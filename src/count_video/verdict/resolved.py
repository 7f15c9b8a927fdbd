"""The answer where the frames show all collisions, or why it cannot be given."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from count_video.motion.burst import Rival
from count_video.motion.priors import PROBABILITY_RESOLVED
from count_video.motion.reasons import ENDS_EARLY, Cause, Reason
from count_video.motion.seen import SeenCollisions
from count_video.motion.swing import Swing
from count_video.records import Estimate, FootageInfo, FootageReport, Track, TrialResult
from count_video.verdict.answers import nothing_to_count, timed
from count_video.verdict.masses import contradiction, with_mass_ratio, with_masses
from count_video.verdict.wording import sentence, sentences

OUTLINES_SHARE = 0.05
"""A ball whose width is wrong by a tenth has its edge wrong by this share of it. Outlines that are
learnt rightly meet to a hundredth."""
LIKELY_ABOVE = 0.02
"""Less likely counts are not named."""


def counted(
    info: FootageInfo,
    report: FootageReport,
    track: Track,
    found: SeenCollisions,
    masses: tuple[Fraction, Fraction] | None,
    ball_diameter_mm: float,
) -> TrialResult:
    """Judge what was found in a clip with both bodies."""
    collisions = tuple(timed(collision, info.capture_fps) for collision in found.collisions)
    reason = why_not(found)
    count = None if reason else found.burst
    vague = _vague_outlines(found.outlines_apart_px, track.ball_diameter_px)
    result = replace(
        nothing_to_count(info, report, reason or ""),
        status="not_counted" if reason else "counted",
        reason=reason or _open(found),
        count=count,
        seen=found.shown,
        between_frames=None if reason else found.burst - found.shown,
        probability={} if count is None else probabilities(count, found.rival),
        count_after_burst=len(collisions) - found.burst,
        collisions=collisions,
        wall_side=track.wall_side,
        ball_diameter_px=track.ball_diameter_px,
        millimetres_per_px=None if vague else ball_diameter_mm / track.ball_diameter_px,
        warnings=(*report.warnings, *track.warnings, *vague),
    )
    return _weighed(result, found.swing, masses)


def _vague_outlines(apart_px: float, ball_diameter_px: float) -> tuple[str, ...]:
    """Say why the ball's width is no measure, if the outlines do not meet at the collisions."""
    if not abs(apart_px) > OUTLINES_SHARE * ball_diameter_px:
        return ()
    where = "are apart" if apart_px > 0 else "overlap"
    return (
        f"the outlines of ball and cylinder {where} by {abs(apart_px):.0f} px where they touch: "
        "the ball's width is not sure enough for a scale in millimetres",
    )


def why_not(found: SeenCollisions) -> str | None:
    """Why the burst cannot be counted, as one sentence; None if it can."""
    if found.burst == 0:
        return sentence(Reason(Cause.NO_COLLISION))
    return sentences((*found.shortcomings, *found.doubts))


def _open(found: SeenCollisions) -> str | None:
    """Say what leaves a count open between two that are both likely."""
    likely = found.rival is not None and found.rival.probability > LIKELY_ABOVE
    return sentence(found.rival.reason) if found.rival and likely else None


def leaves_room(found: SeenCollisions) -> bool:
    """Whether collisions may lie where no frame shows them, and the beginning is there."""
    doubtful = bool(found.doubts or found.shortcomings)
    whole = all(shortcoming.cause in ENDS_EARLY for shortcoming in found.shortcomings)
    return found.burst > 1 and doubtful and whole


def probabilities(count: int, rival: Rival | None = None) -> dict[int, float]:
    """Probability of each count where all collisions are resolved.

    What is left to doubt is shared between one more and one fewer, of both counts if a rival to
    the one told is open.
    """
    shares = {count: 1.0} if rival is None else {count: 1 - rival.probability}
    if rival is not None:
        shares[rival.count] = rival.probability
    rest = (1 - PROBABILITY_RESOLVED) / 2
    chances: dict[int, float] = {}
    for number, share in shares.items():
        for near, part in ((-1, rest), (0, PROBABILITY_RESOLVED), (1, rest)):
            chances[number + near] = chances.get(number + near, 0.0) + share * part
    return dict(sorted(chances.items()))


def _weighed(
    result: TrialResult, swing: Swing | None, masses: tuple[Fraction, Fraction] | None
) -> TrialResult:
    """Complete an answer by the masses, or else by what the heavy body's path tells of them."""
    ratio = math.nan if swing is None else float(swing.mass_ratio)
    measured = None if swing is None else Estimate(ratio, ratio * swing.mass_ratio_relative_sigma)
    if masses is not None:
        given = with_masses(result, *masses)
        clash = () if measured is None else contradiction(float(masses[0] / masses[1]), measured)
        return replace(given, warnings=(*given.warnings, *clash))
    return result if measured is None else with_mass_ratio(result, measured)

"""The answer for a trial at a wall.

It rests on the collisions that the frames show where these are all, or else on the fitted model of
the whole burst; if neither gives the count, it says why.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from count_video.motion.fitted import Between, Misfit
from count_video.motion.posterior import doubted, with_more
from count_video.motion.priors import STRAYING_WRONG
from count_video.motion.reasons import ENDS_EARLY, Cause, Reason
from count_video.motion.rivals import PAIR, Knowledge
from count_video.motion.seen import SeenCollisions
from count_video.motion.swing import Swing
from count_video.records import Estimate, FootageInfo, FootageReport, Track, TrialResult
from count_video.verdict.answers import (
    PROBABILITY_AT_LEAST,
    contradiction,
    nothing_to_count,
    timed,
    with_mass_ratio,
    with_masses,
)
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
        reason=reason,
        count=count,
        seen=found.shown,
        between_frames=None if reason else found.burst - found.shown,
        probability={} if count is None else doubted({count: 1.0}),
        count_after_burst=len(collisions) - found.burst,
        collisions=collisions,
        wall_side=track.wall_side,
        upright=track.line.upright,
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


def leaves_doubt(found: SeenCollisions) -> bool:
    """Whether collisions may lie where no frame shows them, and the beginning is there."""
    doubtful = bool(found.doubts or found.shortcomings)
    whole = all(shortcoming.cause in ENDS_EARLY for shortcoming in found.shortcomings)
    return found.burst > 1 and doubtful and whole


def _weighed(
    result: TrialResult, swing: Swing | None, masses: tuple[Fraction, Fraction] | None
) -> TrialResult:
    """Complete an answer by the masses, or else by what the heavy body's path says of them."""
    ratio = math.nan if swing is None else float(swing.mass_ratio)
    measured = None if swing is None else Estimate(ratio, ratio * swing.mass_ratio_relative_sigma)
    if masses is not None:
        given = with_masses(result, *masses)
        clash = () if measured is None else contradiction(float(masses[0] / masses[1]), measured)
        return replace(given, warnings=(*given.warnings, *clash))
    return result if measured is None else with_mass_ratio(result, measured)


LISTED_AT_MOST = 4
"""Of more likely counts than so many only the range is named, ..."""
RANGED_AT_MOST = 10
"""... and of more than so many only about where they are: the ends were not searched."""
NOT_DESCRIBED = frozenset((Cause.MODEL_STRAYS, Cause.MODEL_DIFFERS))
MASS_RELATIVE_SIGMA = 0.002
"""Standard uncertainty of a mass ratio that the user gives: kitchen scales and a ring of thread."""


def knowledge(info: FootageInfo, masses: tuple[Fraction, Fraction] | None) -> Knowledge:
    """Give a fit what is known besides the track."""
    if masses is None:
        return Knowledge(info.capture_fps)
    ratio = float(masses[0] / masses[1])
    return Knowledge(info.capture_fps, ratio, MASS_RELATIVE_SIGMA * ratio)


def inferred(result: TrialResult, found: SeenCollisions, between: Between | Misfit) -> TrialResult:
    """Complete the answer by what lies between the frames, or say why nothing can be said."""
    if isinstance(between, Misfit):
        return replace(result, reason=f"{result.reason}; {sentence(between.reason)}")
    count = between.count
    if count < found.burst and between.left_out is None:
        return replace(
            result,
            reason=f"{result.reason}; the model of the motion that describes the track best has "
            f"only {count} where the frames show {found.burst} collisions",
        )
    if not sure_enough(between):
        return replace(
            result,
            reason=f"{result.reason}; {left_open(between, result.mass_ratio)}",
            probability=between.probability,
        )
    return measured(_completed(result, found, between), between)


def _completed(result: TrialResult, found: SeenCollisions, between: Between) -> TrialResult:
    """Give the fit's count and its collisions; what was seen after the burst follows them."""
    count = between.count
    burst = tuple(timed(collision, result.capture_fps) for collision in between.collisions)
    after = result.collisions[min(count, found.burst) :]
    later = tuple(replace(c, number=count + place) for place, c in enumerate(after, 1))
    seen = sum(collision.seen for collision in burst)
    return replace(
        result,
        status="counted",
        reason=None,
        count=count,
        seen=seen,
        between_frames=count - seen,
        probability=between.probability,
        count_after_burst=len(later),
        collisions=(*burst, *later),
    )


def left_open(between: Between, mass_ratio: float | None) -> str:
    """Say between which counts the fit cannot decide."""
    likely = {n: p for n, p in between.probability.items() if p > LIKELY_ABOVE}
    if len(likely) > RANGED_AT_MOST:
        about = round(sum(likely) / len(likely), -1)
        which = f"a model of the motion leaves open how many there are, about {about:.0f}"
    elif len(likely) > LISTED_AT_MOST:
        which = f"a model of the motion allows every count from {min(likely)} to {max(likely)}"
    else:
        *others, last = (f"{n} ({p:.0%})" for n, p in likely.items())
        listed = f"{', '.join(others)} or {last}" if others else last
        which = f"by a model of the motion the count is {listed}"
    return which if mass_ratio else f"{which}; the masses, given with --masses, narrow it down"


def sure_enough(between: Between) -> bool:
    """Whether a count is probable enough to be given; if not, its interval is the reason."""
    return between.probability[between.count] >= PROBABILITY_AT_LEAST


def measured(result: TrialResult, between: Between | Misfit) -> TrialResult:
    """Add what the fit says of the physics; where it does not describe the track, doubt the count.

    Two collisions are missed together if any are, one with either thing.
    """
    if isinstance(between, Misfit):
        if result.count is None or between.reason.cause not in NOT_DESCRIBED:
            return result
        chances = {n: p * (1 - STRAYING_WRONG) for n, p in result.probability.items()}
        missed = result.count + PAIR
        chances[missed] = chances.get(missed, 0.0) + STRAYING_WRONG
        reasons = filter(None, (result.reason, sentence(between.reason)))
        return replace(result, reason="; ".join(reasons), probability=chances)
    burst = tuple(timed(collision, result.capture_fps) for collision in between.collisions)
    result = replace(result, probability=between.probability if result.count else {})
    return replace(
        with_mass_ratio(_continued(result, between.following), between.mass_ratio),
        collisions=(*burst, *result.collisions[len(burst) :]),
        energy_kept=between.energy_kept,
        restitution_bodies=between.restitution_bodies,
        restitution_wall=between.restitution_wall,
        ending=between.ending,
        setup=between.setup,
    )


def _continued(result: TrialResult, following: Mapping[int, float]) -> TrialResult:
    """Leave some probability to collisions after the clip's end; no count where they are likely."""
    more = 1.0 - following.get(0, 0.0)
    if result.count is None or more <= LIKELY_ABOVE:
        return result
    said = sentence(Reason(Cause.ENDS_BEFORE_NEXT, (more,)))
    open_still = replace(
        result,
        reason="; ".join(filter(None, (result.reason, said))),
        probability=with_more(result.probability, following),
    )
    if open_still.probability.get(result.count, 0.0) >= PROBABILITY_AT_LEAST:
        return open_still
    return replace(
        open_still, status="not_counted", count=None, between_frames=None, pi_low=None, pi_high=None
    )

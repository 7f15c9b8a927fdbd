"""The answer where a fitted model tells what lies between the frames."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from count_video.motion.fitted import Between, Misfit
from count_video.motion.posterior import shifted
from count_video.motion.priors import STRAYING_WRONG
from count_video.motion.reasons import Cause, Reason
from count_video.motion.rivals import PAIR, Knowledge
from count_video.motion.seen import SeenCollisions
from count_video.records import FootageInfo, TrialResult
from count_video.verdict.answers import timed
from count_video.verdict.masses import with_mass_ratio
from count_video.verdict.resolved import LIKELY_ABOVE
from count_video.verdict.wording import sentence

PROBABILITY_AT_LEAST = 0.5
"""A count that is inferred must be more probable than all others together."""
LISTED_AT_MOST = 4
"""Of more likely counts than so many only the range is named, ..."""
RANGED_AT_MOST = 10
"""... and of more than so many only about where they are: the ends were not looked for."""
NOT_DESCRIBED = frozenset((Cause.MODEL_STRAYS, Cause.MODEL_DIFFERS))
MASS_RELATIVE_SIGMA = 0.002
"""Standard uncertainty of a mass ratio that the user gives: kitchen scales and a ring of thread."""


def knowledge(info: FootageInfo, masses: tuple[Fraction, Fraction] | None) -> Knowledge:
    """Tell a fit what is known besides the track."""
    if masses is None:
        return Knowledge(info.capture_fps)
    ratio = float(masses[0] / masses[1])
    return Knowledge(info.capture_fps, ratio, MASS_RELATIVE_SIGMA * ratio)


def inferred(result: TrialResult, found: SeenCollisions, between: Between | Misfit) -> TrialResult:
    """Complete the answer by what lies between the frames, or say why nothing can be said."""
    if isinstance(between, Misfit):
        return replace(result, reason=f"{result.reason}; {sentence(between.reason)}")
    count = between.count
    least = min(found.burst, found.rival.count) if found.rival else found.burst
    if count < least:
        return replace(
            result,
            reason=f"{result.reason}; the model of the motion that describes the track best has "
            f"only {count} where the frames show {least} collisions",
        )
    if not sure_enough(between):
        return replace(
            result,
            reason=f"{result.reason}; {left_open(between, result.mass_ratio)}",
            probability=between.probability,
        )
    return measured(_completed(result, found, between), between)


def _completed(result: TrialResult, found: SeenCollisions, between: Between) -> TrialResult:
    """Tell the fit's count and its collisions; what was seen after the burst follows them."""
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
    """Add what the fit tells of the physics; where it does not describe the track, doubt the count.

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
    return replace(
        with_mass_ratio(_continued(result, between.one_more), between.mass_ratio),
        collisions=(*burst, *result.collisions[len(burst) :]),
        energy_kept=between.energy_kept,
        restitution_bodies=between.restitution_bodies,
        restitution_wall=between.restitution_wall,
        ending=between.ending,
        setup=between.setup,
    )


def _continued(result: TrialResult, one_more: float) -> TrialResult:
    """Leave room for a collision after the clip's end; no count where it is likely."""
    if result.count is None or one_more <= LIKELY_ABOVE:
        return result
    said = sentence(Reason(Cause.ENDS_BEFORE_NEXT, (one_more,)))
    open_still = replace(
        result,
        reason="; ".join(filter(None, (result.reason, said))),
        probability=shifted(result.probability, result.count, 1, one_more),
    )
    if open_still.probability[result.count] >= PROBABILITY_AT_LEAST:
        return open_still
    return replace(
        open_still, status="not_counted", count=None, between_frames=None, pi_low=None, pi_high=None
    )

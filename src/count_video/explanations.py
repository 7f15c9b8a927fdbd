"""The table of explanations of a clip, of which the answer is read off one.

    bodies             scene             times                 count: probability
    ball and cylinder  at a wall         even                  31: 0.97, 33: 0.03
    two bodies         without a wall    with copies            3: 0.99
    one body           at a stop         rate changes at 120    8: 0.90, 9: 0.08

Each has the probability of every count and, as values, what stands against any. A count is given if
nothing does and it is as probable as all others together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from count_video.motion.changing_rates import Timed, seen_by_time_bases
from count_video.motion.fitted import Between, fit_burst
from count_video.motion.meeting import seen_impacts
from count_video.motion.parameters import Knowledge
from count_video.motion.posterior import doubted, with_more
from count_video.motion.priors import UNEXPLAINED_WRONG
from count_video.motion.rivals import PAIR
from count_video.motion.seen import SeenCollisions, with_errors
from count_video.motion.time_base import TimeBase
from count_video.motion.time_hypotheses import usual_times
from count_video.reasons import Cause, Reason
from count_video.records import SURE, Collision, FootageReport, Track

PROBABILITY_AT_LEAST = 0.5
"""A count must be as probable as all others together."""
LIKELY_ABOVE = 0.02
"""Less likely counts are not named."""
OUTLINES_SHARE = 0.05
"""A ball whose width is wrong by a tenth has its edge wrong by this share of it. Outlines that are
learnt rightly meet to a hundredth."""
SWINGS_BACK = 0.25
"""A body swings back to what it left in no less than this share of a period."""
Scene = Literal["wall", "bodies", "stop"]
"""Ball and cylinder at a wall, two bodies without one, or one body at a stop."""


@dataclass(frozen=True)
class Explanation:
    """What one explanation of a clip says of the count."""

    track: Track
    """With uncertainties that hold the errors which last."""
    scene: Scene
    collisions: tuple[Collision, ...]
    """In order of time, by the clip's frames."""
    count: int
    """How many of them are counted, if any count is given."""
    probability: dict[int, float]
    """Of each count."""
    against: tuple[Reason, ...] = ()
    """Why the clip supports no count."""
    doubts: tuple[Reason, ...] = ()
    """What lowers the probability."""
    notes: tuple[Reason, ...] = ()
    """What is unusual about the clip."""
    found: SeenCollisions | None = None
    """What the frames show of a trial at a wall."""
    fit: Between | None = None
    """The fit of the whole burst, if the count rests on it."""

    @property
    def counts(self) -> bool:
        """Whether a count is given."""
        likely = self.probability.get(self.count, 0.0) >= PROBABILITY_AT_LEAST
        return likely and not self.against

    @property
    def path_fits(self) -> bool:
        """Whether the heavy body's path fits its collisions at a wall."""
        return self.found is not None and self.found.path_fits

    @property
    def path_shows(self) -> bool:
        """Whether the path fits them, and would not do so without them.

        Scenery that is taken for a body drifts along without any.
        """
        swing = self.found.swing if self.found is not None else None
        return swing is not None and swing.is_clear and self.path_fits

    @property
    def outlines_apart(self) -> bool:
        """Whether the outlines do not meet where the bodies touch: the width is wrong."""
        return any(note.cause is Cause.OUTLINES_APART for note in self.notes)


# ---- a trial at a wall ---------------------------------------------------------------------------


def at_wall(track: Track, known: Knowledge) -> Explanation:
    """Explain a track by a ball and a heavy body at a wall.

    Of several times that the pictures may have those stand by which the fit leaves least over; what
    it leaves over of the likeliest is compared with others if single flights leave less.
    """
    explained = []
    for by in seen_by_time_bases(track):
        one, errors = _at_wall_by(by, track, known), by.found.errors[0]
        explained.append(one)
        if one.fit and errors and one.fit.misfit_px <= errors.sigma_px:
            break
    return min(explained, key=lambda one: one.fit.misfit_px if one.fit else np.inf)


def _at_wall_by(by: Timed, track: Track, known: Knowledge) -> Explanation:
    """Explain a track by a ball and a heavy body at a wall, by the times of its pictures."""
    base, found = by
    shown = shown_at_wall(track, found)
    fit = None
    if found.burst and (not shown.against or (leaves_doubt(found) and not known.seen_only)):
        fit = fit_burst(base.evened(track), found, known)
    return completed(shown, fit, base, known)


def completed(
    shown: Explanation, fit: Between | Reason | None, base: TimeBase, known: Knowledge
) -> Explanation:
    """Complete what the frames show by a fit, if there is one, and place it among the frames."""
    notes, explained = base.notes, shown
    if fit is not None:
        if isinstance(fit, Between):
            notes = (*notes, *fit.notes)
        explained = by_fit(shown, fit, masses_known=known.mass_ratio is not None)
    collisions = tuple(map(base.shown, explained.collisions))
    return replace(explained, collisions=collisions, notes=(*explained.notes, *notes))


def shown_at_wall(track: Track, found: SeenCollisions) -> Explanation:
    """Explain a track by the collisions that its frames show."""
    against = (*found.shortcomings, *found.doubts)
    return Explanation(
        track=with_errors(track, found.errors),
        scene="wall",
        collisions=found.collisions,
        count=found.burst,
        probability=doubted({found.burst: 1.0}),
        against=against if found.burst else (Reason(Cause.NO_COLLISION),),
        notes=_outlines(track, found.outlines_apart_px),
        found=found,
    )


def _outlines(track: Track, apart_px: float) -> tuple[Reason, ...]:
    """Say so if the outlines do not meet where the bodies touch."""
    vague = abs(apart_px) > OUTLINES_SHARE * track.ball_diameter_px
    return (Reason(Cause.OUTLINES_APART, (apart_px,)),) if vague else ()


def leaves_doubt(found: SeenCollisions) -> bool:
    """Whether collisions may lie where no frame shows them, and the beginning is there."""
    return found.burst > 1 and not found.is_whole and found.fit_may_settle


def by_fit(shown: Explanation, fit: Between | Reason, *, masses_known: bool) -> Explanation:
    """Let the fit of the whole burst complete what the frames show, or stand against it."""
    if isinstance(fit, Reason):
        return _not_described(shown, fit)
    count, seen = fit.count, shown.count
    if shown.against and _passes_over(fit, shown):
        return replace(shown, against=(*shown.against, Reason(Cause.MODEL_DIFFERS)))
    others = _others_likely(fit, masses_known=masses_known)
    if fit.probability[count] < PROBABILITY_AT_LEAST:
        doubts = (*shown.against, *others)
        return replace(shown, against=(), doubts=doubts, probability=fit.probability)
    if shown.outlines_apart:
        # Where collisions are missed, contacts by themselves say less of it than the motion does.
        shown = replace(shown, notes=_outlines(shown.track, fit.outlines_apart_px))
    later = (one for one in shown.collisions[min(count, seen) :] if _is_another(one, fit))
    probability, doubts = _left_open(shown, fit, others)
    collisions = (*fit.collisions, *later)
    return replace(
        shown,
        collisions=collisions,
        count=count,
        probability=probability,
        against=(),
        doubts=doubts,
        fit=fit,
    )


def _is_another(one: Collision, fit: Between) -> bool:
    """Whether a collision that is seen comes after the burst that was fitted.

    To collide with the same thing again a body swings to and fro, for half a period or nearly.
    """
    last, swing = fit.collisions[-1], fit.setup.ball_period_frames.value * SWINGS_BACK
    return one.frame > last.frame + (swing if one.kind == last.kind else 0.0)


def _left_open(
    shown: Explanation, fit: Between, others: tuple[Reason, ...]
) -> tuple[dict[int, float], tuple[Reason, ...]]:
    """Allow for what may follow the clip's end, and for outlines that do not meet.

    Returns the probability of each count and all doubts, those about ``others`` among them.
    """
    probability, doubts = fit.probability, others
    more = 1.0 - fit.following.get(0, 0.0)
    if more > LIKELY_ABOVE:
        probability = with_more(probability, fit.following)
        doubts = (Reason(Cause.ENDS_BEFORE_NEXT, (more,)), *others)
    if shown.outlines_apart and fit.shown < fit.count:
        beside = {PAIR: UNEXPLAINED_WRONG / 2, -min(PAIR, fit.count): UNEXPLAINED_WRONG / 2}
        probability = with_more(probability, {0: 1 - UNEXPLAINED_WRONG, **beside})
        doubts = (*doubts, Reason(Cause.OUTLINES_LEAVE_OPEN))
    return probability, doubts


def _passes_over(fit: Between, shown: Explanation) -> bool:
    """Whether a fit has fewer collisions than are seen, and most that the frames show not."""
    fewer = fit.count < shown.count
    return fewer and shown.found is not None and 2 * fit.shown < shown.found.shown


def _others_likely(fit: Between, *, masses_known: bool) -> tuple[Reason, ...]:
    """Name the counts that come into question where the fit's own is not sure."""
    if fit.probability[fit.count] >= SURE:
        return ()
    likely = [pair for pair in fit.probability.items() if pair[1] > LIKELY_ABOVE]
    still_open = Reason(Cause.MODEL_LEAVES_OPEN, tuple(f for pair in likely for f in pair))
    return (still_open,) if masses_known else (still_open, Reason(Cause.MASSES_WOULD_HELP))


def _not_described(shown: Explanation, reason: Reason) -> Explanation:
    """Doubt a count, or refuse one that was in doubt, if the model does not describe the track.

    Two collisions are missed together if any are, one with either thing.
    """
    if shown.against:
        return replace(shown, against=(*shown.against, reason))
    if reason.cause not in (Cause.MODEL_STRAYS, Cause.MODEL_FITS_NOTHING):
        return shown
    missed = {0: 1 - UNEXPLAINED_WRONG, PAIR: UNEXPLAINED_WRONG}
    return replace(shown, doubts=(reason,), probability=with_more(shown.probability, missed))


# ---- impacts at a stop or without a wall ---------------------------------------------------------


def by_impacts(track: Track, known: Knowledge) -> Explanation:
    """Explain a track of one body alone, or of two without a wall, by the impacts that it shows."""
    base = usual_times(track)
    found = seen_impacts(base.evened(track))
    impacts = [one for one in found.collisions if one.seen or not known.seen_only]
    count, doubts = len(impacts), found.doubts
    chance = found.probability.get(count, 0.0)
    if chance < PROBABILITY_AT_LEAST:
        doubts = (*doubts, Reason(Cause.OTHERS_LIKELY, (count, chance)))
    pushes = [one.push for one in found.collisions if one.push]
    if track.heavy is None and pushes:  # the stop is where most impacts push it away from
        track = replace(track, wall_side="left" if sum(pushes) >= 0 else "right")
    return Explanation(
        track=with_errors(track, found.errors),
        scene="stop" if track.heavy is None else "bodies",
        collisions=tuple(map(base.shown, impacts)),
        count=count,
        probability=found.probability,
        against=found.shortcomings,
        doubts=doubts,
        notes=base.notes,
    )


# ---- what all have in common ---------------------------------------------------------------------


def with_missing(
    probability: Mapping[int, float], count: int, report: FootageReport
) -> dict[int, float]:
    """Let collisions happen in the pictures that are missing as often as in those that are there.

    They come at random then (Poisson): the chance that none is missing is exp(-expected), and what
    this takes from the chances is that of one more.
    """
    expected = count * report.frames_missing / max(1, report.frames_decoded)
    none = float(np.exp(-expected))
    return with_more(probability, {0: none, 1: 1 - none} if expected else {0: 1.0})


def doubted_for_missing(explained: Explanation, report: FootageReport) -> Explanation:
    """Doubt a count where pictures are missing, unless a fit says that the burst was over.

    Where none is given they are named first.
    """
    counts = explained.counts
    if not report.frames_missing or (counts and explained.fit is not None):
        return explained
    missing = (Reason(Cause.FRAMES_MISSING, (report.frames_missing,)),)
    if counts:
        probability = with_missing(explained.probability, explained.count, report)
        return replace(explained, doubts=missing + explained.doubts, probability=probability)
    against = explained.against and missing + explained.against
    return replace(explained, against=against, doubts=missing + explained.doubts)

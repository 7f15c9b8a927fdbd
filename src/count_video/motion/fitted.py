"""Fit the whole burst, and count what lies between the frames.

The theory's count does not enter.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from count_video.motion.observations import Observations, observe
from count_video.motion.parameters import FIRST_DEVIATION, LIMITS, Column, Knowledge, prior_of
from count_video.motion.posterior import (
    collisions_of,
    doubted,
    end_chances,
    ending_of,
    energy_kept,
    left_out_of,
    setup_estimates,
    shares_of,
    turns,
    with_more,
)
from count_video.motion.rivals import (
    FIRST_COLLISIONS,
    MOST_RIVALS,
    PAIR,
    UNLIKELY,
    Rivals,
    weigh,
    with_residual_noise,
)
from count_video.motion.seen import SeenCollisions, with_errors
from count_video.motion.skips import with_frames_left_out
from count_video.motion.solving import Fit, with_each_scatter
from count_video.motion.starting import MOST_COLLISIONS, expected_count, rough_values
from count_video.reasons import Cause, Reason
from count_video.records import Collision, Ending, Estimate, FittedSetup, Floats, Track

FRAMES_AT_LEAST = 20
HINDERED_SIGMAS = 2.0
"""Masses that are given are doubted from so many standard deviations on."""
MISFIT_SIGMAS = 4.0
"""The model does not describe a track from which it strays, as a root mean square, by so many times
as much as places stray from single flights: of 1100 clips that were counted rightly none strays by
more than 3 times as much, ..."""
MISFIT_SHARE, MISFIT_AT_MOST = 0.0025, 0.5
"""... and by the first share of the ball's diameter, as lenses bend straight lines, however sharp a
picture is: by 0.0023 at most in rendered ones. One that strays by its radius describes none."""
NEAR_LOSS = 0.5
"""Loss in each frame below which noise may explain what a fit leaves over: as large as is allowed,
it loses 1 of two bodies, but it is smaller as a rule."""
LOST_A_FRAME = 4.0
"""A fit that loses so much in each frame, as if all of them strayed by four standard deviations,
is near none that describes the track: the search from there takes minutes."""
LIKELY = 0.5
"""The last fitted collision is left to what follows the burst if this is more likely than not."""
NOTHING_KNOWN = Knowledge()


@dataclass(frozen=True)
class Between:
    """What the fitted model says of a burst."""

    count: int
    probability: dict[int, float]
    """Of each count; sums to 1."""
    collisions: tuple[Collision, ...]
    """The burst."""
    mass_ratio: Estimate
    """By the places, and by masses that are given, but for those that hinder the fit."""
    restitution_bodies: Estimate
    restitution_wall: Estimate
    energy_kept: tuple[float, ...]
    """Energy after each collision over that before the first."""
    ending: Ending
    setup: FittedSetup
    misfit_px: float
    """Root mean square of what the model leaves unexplained of the ball's places."""
    outlines_apart_px: float
    """By how much the outlines are apart where ball and heavy body touch."""
    following: dict[int, float]
    """Probability that so many collisions of the burst follow after the clip's end; sums to 1."""
    notes: tuple[Reason, ...] = ()
    """Of frames that the track does not allow for; these collisions are placed without them."""

    @property
    def shown(self) -> int:
        """How many of the collisions the frames show."""
        return sum(collision.seen for collision in self.collisions)


def fit_burst(
    track: Track,
    found: SeenCollisions,
    known: Knowledge = NOTHING_KNOWN,
) -> Between | Reason:
    """Fit the model to a track and count the collisions of its burst.

    Masses that the motion contradicts are left out of account where collisions are inferred. If
    they hinder the fit, one without them shows whether it does, and its own ratio.

    Parameters
    ----------
    track
        A track of both bodies.
    found
        What its frames show; at least one collision.
    known
        What is known besides.
    """
    observed = observe(track, found)
    before = int(np.isfinite(observed.ball_px[observed.frame < -1]).sum())
    if len(observed.frame) < FRAMES_AT_LEAST or before < 3:
        return Reason(Cause.MODEL_LACKS_FRAMES)
    searched = _searched(observed, found, known)
    fit = _weighed(searched, track, found, known)
    if known.mass_ratio is None or not (isinstance(fit, Reason) or _is_hindered(searched)):
        return fit
    without = replace(known, mass_ratio=None)
    free = _weighed(_searched(observed, found, without), track, found, without)
    if isinstance(fit, Reason):
        return free
    if isinstance(free, Reason):
        return fit
    # Of all masses some explain the places better than wrong ones; else the search went astray.
    wrong = known.contradicts(free.mass_ratio) and free.misfit_px < fit.misfit_px
    inferred = fit.shown < fit.count
    return free if wrong and inferred else replace(fit, mass_ratio=free.mass_ratio)


def _searched(observed: Observations, found: SeenCollisions, known: Knowledge) -> Rivals:
    """Search for the counts that come into question, and fit them coarsely."""
    rough = rough_values(observed, found, known)
    coarse = Rivals(observed, prior_of(rough, known, shows_heavy=observed.shows_heavy))
    values, calm = _begun(coarse, rough, found)
    if not coarse.fits or not _is_near(coarse.best):
        coarse.scan(values)
    coarse.climb(calm)
    return coarse


def _is_hindered(coarse: Rivals) -> bool:
    """Whether masses that are given hinder the fits: without them, they are better than by noise.

    Tried are the best and those of a pair more and less.
    """
    best, prior = coarse.best, coarse.prior.with_value(Column.LIGHTNESS, 0.0, np.inf)
    free = Rivals(coarse.observed, prior)
    for count in (best.count, best.count - PAIR, best.count + PAIR):
        if 0 < count <= MOST_COLLISIONS:
            free.add(count, coarse.fits.get(count, best).values)
    return best.loss - free.best.loss > 0.5 * HINDERED_SIGMAS**2


def _weighed(
    coarse: Rivals, track: Track, found: SeenCollisions, known: Knowledge
) -> Between | Reason:
    """Fit every count that comes into question finely, with frames left out if that is likelier."""
    beyond = _beyond_reach(coarse.best, known)
    if beyond is not None:
        return beyond
    coarse = with_frames_left_out(coarse)
    fit = with_residual_noise(coarse.observed, coarse.best)
    first = with_each_scatter(fit.question, fit.values)
    if not first:
        return Reason(Cause.MODEL_FITS_NOTHING)
    likeliest = max(first, key=lambda one: one.evidence)
    limit_px = _misfit_limit_px(track, found)
    strayed = _strayed(_misfit_px(likeliest), limit_px) or _too_light(likeliest)
    if strayed is not None:
        return strayed  # before the other counts are fitted, which takes far longer
    answer = _answer(found, weigh(coarse, fit.question, first, fit.loss + UNLIKELY))
    if isinstance(answer, Reason):
        return answer
    return _too_many(answer.count) or _strayed(answer.misfit_px, limit_px) or answer


def _beyond_reach(best: Fit, known: Knowledge) -> Reason | None:
    """Say so if no motion resembles the track, or there are more collisions than are sought."""
    by_masses = expected_count(-float(np.log(known.mass_ratio or 1.0)))
    near = best.loss < LOST_A_FRAME * len(best.observed.frame)
    fits_nothing = None if near else Reason(Cause.MODEL_FITS_NOTHING)
    return _too_many(max(float(best.count), by_masses)) or fits_nothing


def _too_many(count: float) -> Reason | None:
    """Say so if a count is so near to the largest one that is sought that others lie beyond."""
    many = count > MOST_COLLISIONS - MOST_RIVALS
    return Reason(Cause.TOO_MANY, (MOST_COLLISIONS,)) if many else None


def _too_light(fit: Fit) -> Reason | None:
    """Say so if the heavy body is as light as the model allows: it is lighter, and not fitted."""
    lightest = float(LIMITS[Column.LIGHTNESS][1])
    return Reason(Cause.LIGHTER) if fit.values[Column.LIGHTNESS] > 0.99 * lightest else None


def _begun(rivals: Rivals, rough: Floats, found: SeenCollisions) -> tuple[Floats, Floats | None]:
    """Fit the calm beginning, and the number seen from there.

    Returns a start for other counts, and the beginning as it was fitted, if that is near.
    """
    if not found.is_whole and rivals.observed.calm < FIRST_COLLISIONS:
        return rough, None
    grown = rivals.grow(rough)
    # If none is hidden among those seen, all their times lead to a fit that is near.
    seen = grown if found.burst == grown.count else rivals.led(found.burst, grown.values)
    rivals.add(found.burst, (seen if _is_near(seen) else grown).values)
    if not _is_near(grown):
        return rough, None
    start = grown.values[:FIRST_DEVIATION].copy()
    if rivals.observed.shows_heavy:
        # What its whole path shows, a few collisions at its beginning do not.
        start[[Column.LIGHTNESS, Column.SWING]] = rough[[Column.LIGHTNESS, Column.SWING]]
    return start, grown.values


def _is_near(fit: Fit) -> bool:
    """Whether noise may explain what is left over of the places, and of the times that lead it.

    Those may lose 1 each, twice as much as by their standard deviation.
    """
    led = fit.off[:-1]
    near = fit.loss < NEAR_LOSS * len(fit.observed.frame)
    return near and 0.5 * float(led @ led) <= len(led)


def _misfit_limit_px(track: Track, found: SeenCollisions) -> float:
    """By how much a model that describes a track may stray from it, as a root mean square."""
    sigma_px = float(np.nanmedian(with_errors(track, found.errors).ball.sigma_px))
    bent_px, most_px = (share * track.ball_diameter_px for share in (MISFIT_SHARE, MISFIT_AT_MOST))
    return min(max(MISFIT_SIGMAS * sigma_px, bent_px), most_px)


def _strayed(misfit_px: float, limit_px: float) -> Reason | None:
    """Say so if the model does not describe the track."""
    return Reason(Cause.MODEL_STRAYS, (misfit_px, limit_px)) if misfit_px > limit_px else None


def _misfit_px(fit: Fit) -> float:
    """Root mean square of the ball's residuals, the worst fiftieth aside."""
    ball, _ = np.split(fit.left_px, 2)
    squares = np.sort(ball[np.isfinite(ball)] ** 2)
    return float(np.sqrt(squares[: max(1, int(0.98 * len(squares)))].mean()))


def _is_one(fit: Fit) -> bool:
    """Whether all collisions of a fit come about and, but perhaps the last, belong to one burst.

    It ends when the heavy body, driven back, turns round again.
    """
    if not np.isfinite(fit.paths.time[0, -1]):
        return False
    return not bool((turns(fit.paths)[0, 1:-2] < fit.paths.time[0, 2:-1]).any())


def _answer(found: SeenCollisions, fits: list[Fit]) -> Between | Reason:
    fits = [fit for fit in fits if np.isfinite(fit.evidence) and _is_one(fit)]
    if not fits:
        return Reason(Cause.MODEL_FITS_NOTHING)
    shares = shares_of(fits)
    chances: dict[int, float] = {}
    for fit, share in zip(fits, shares.tolist(), strict=True):
        chances[fit.count] = chances.get(fit.count, 0.0) + share
    count = max(chances, key=chances.__getitem__)
    same = [fits[k] for k in np.argsort(-shares) if fits[k].count == count]
    best = same[0]
    following = end_chances(best)
    fewer = following.pop(-1, 0.0)
    following = following or {0: 1.0}
    following = {more: chance / sum(following.values()) for more, chance in following.items()}
    chances = with_more(chances, {-1: fewer, 0: 1.0 - fewer})
    if fewer > LIKELY and count > 1:
        count -= 1
    collisions = collisions_of(same, found, count)
    inferred = not all(one.seen for one in collisions)
    mass_ratio, bodies, wall, *setup = setup_estimates(fits)
    return Between(
        count=count,
        probability=doubted(chances, best.question.left_over if inferred else 0.0),
        collisions=collisions,
        mass_ratio=mass_ratio,
        restitution_bodies=bodies,
        restitution_wall=wall,
        energy_kept=tuple(energy_kept(best)[:count].tolist()),
        ending=ending_of(best, count),
        setup=FittedSetup(*setup),
        misfit_px=_misfit_px(best),
        outlines_apart_px=float(best.values[Column.CONTACT]),
        following=following,
        notes=left_out_of(best).notes,
    )

"""Fit the whole burst, and count what lies between the frames.

A model of the whole burst is fitted to the track for each number of collisions that comes into
question. What the frames show of the motion on both sides, what single frames caught in the thick
of it, and the bend of the heavy body's path decide between them; the theory's count does not enter.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from count_video.motion.estimates import (
    collisions_of,
    ending_of,
    energy_kept,
    estimate,
    fitted_setup,
    mass_ratio,
)
from count_video.motion.left_out import LeftOut
from count_video.motion.observations import Observations, observe
from count_video.motion.parameters import FIRST_DEVIATION, Column, Prior
from count_video.motion.posterior import (
    Weighed,
    doubted,
    end_chances,
    fine_fits,
    probabilities,
    scattered,
    shares_of,
    weigh,
    with_more,
)
from count_video.motion.rivals import (
    FIRST_COLLISIONS,
    Knowledge,
    calm_beginning,
    coarse_fits,
    forward_fit,
    prior_of,
)
from count_video.motion.seen import SeenCollisions
from count_video.motion.solving import Solution, modelled
from count_video.motion.starting import MOST_COLLISIONS, rough_values
from count_video.motion.time_base import lacks_frames, with_frames_left_out
from count_video.reasons import Cause, Reason
from count_video.records import Collision, Ending, Estimate, FittedSetup, Floats, Track

FRAMES_AT_LEAST = 20
MISFIT_SIGMAS = 8.0
"""The model does not describe a track from which it strays by more than so many sigmas, ..."""
MISFIT_SHARE, MISFIT_AT_MOST = 0.005, 0.5
"""... or by the first share of the ball's diameter, as a root mean square; but never by its radius,
however unsteady the track."""
RIVALS = 5
"""Counts that are fitted finely, ..."""
COARSELY_LOST = 40.0
"""... if their coarse fits are not worse than the best one's by so much."""
LIKELY = 0.5
"""The last fitted collision is left to what follows the burst if this is more likely than not; and
more collisions than were seen are given if they are."""
MOST_OVER_SEEN = 2
"""Where the frames show all collisions of a burst, more that are hidden than shown are no
explanation."""
NOTHING_KNOWN = Knowledge()


@dataclass(frozen=True)
class Between:
    """What the fitted model says of a burst."""

    count: int
    probability: dict[int, float]
    """Of each count; sums to 1."""
    collisions: tuple[Collision, ...]
    """The burst, numbered from 1; real times are not filled in."""
    mass_ratio: Estimate
    restitution_bodies: Estimate
    restitution_wall: Estimate
    energy_kept: tuple[float, ...]
    """Energy after each collision over that before the first."""
    ending: Ending
    setup: FittedSetup
    misfit_px: float
    """Root mean square of what the model leaves unexplained of the ball's places."""
    following: dict[int, float]
    """Probability that so many collisions of the burst follow after the clip's end; sums to 1."""
    left_out: LeftOut | None = None
    """Frames that the track does not allow for yet; these collisions are placed without them."""


@dataclass(frozen=True)
class Misfit:
    """The model does not describe the track."""

    reason: Reason


def count_between(
    track: Track,
    found: SeenCollisions,
    known: Knowledge = NOTHING_KNOWN,
    gap: LeftOut | None = None,
    most: int = MOST_COLLISIONS,
) -> Between | Misfit:
    """Fit the model to a track and count the collisions of its burst.

    Parameters
    ----------
    track
        A track of both bodies.
    found
        What its frames show; at least one collision.
    known
        What is known besides.
    gap
        Frames left out that the track allows for; their number is in question.
    most
        More collisions than this are no explanation.
    """
    observed = observe(track, found)
    start = _start(observed, found, known)
    if isinstance(start, Misfit):
        return start
    rough, prior = start
    calm = calm_beginning(found.collisions[: found.burst])
    whole = None
    if calm >= FIRST_COLLISIONS:
        first = forward_fit(observed, rough, prior, found, calm)
        lightness = rough[Column.LIGHTNESS]
        rough = first.values[:FIRST_DEVIATION].copy()
        rough[Column.LIGHTNESS] = lightness
        whole = first if calm == found.burst and np.isfinite(first.loss) else None
    coarse = coarse_fits(observed, rough, prior, found.burst, whole)
    if coarse[0].count > most:
        return Misfit(Reason(Cause.MODEL_FITS_NOTHING))
    observed, coarse = with_frames_left_out(observed, rough, prior, coarse, found.burst, gap)
    if not np.isfinite(coarse[0].loss):
        return Misfit(Reason(Cause.MODEL_FITS_NOTHING))
    promising = [fit for fit in coarse[:RIVALS] if fit.loss < coarse[0].loss + COARSELY_LOST]
    fits, noise = fine_fits(observed, prior, promising)
    answer = _answer(found, observed, weigh(observed, noise, prior, fits, coarse))
    return _strayed(answer.misfit_px, observed, track) or answer


def measure_burst(
    track: Track, found: SeenCollisions, known: Knowledge = NOTHING_KNOWN
) -> Between | Misfit:
    """Fit the model to a burst whose collisions are all seen, for what it says of the physics.

    Parameters as for ``count_between``. The count is the number seen, unless by that number the
    model does not describe the track, or only with frames left out, and another describes it.
    """
    observed = observe(track, found)
    start = _start(observed, found, known)
    if isinstance(start, Misfit):
        return start
    rough, prior = start
    coarse = forward_fit(observed, rough, prior, found, found.burst)
    if not np.isfinite(coarse.loss):
        return Misfit(Reason(Cause.MODEL_FITS_NOTHING))
    fits, noise = fine_fits(observed, prior, [coarse])
    strayed = _strayed(_root_mean_square(fits[0]), observed, track)
    if strayed is None and not lacks_frames(observed, noise, prior, fits[0]):
        measured = _answer(found, observed, scattered(observed, noise, prior, fits[0]))
        seen = sum(collision.seen for collision in measured.collisions)
        if seen >= found.shown and measured.count == found.burst:
            return measured
    other = count_between(track, found, known, most=MOST_OVER_SEEN * found.burst)
    if _stands(other, found.burst):
        return other
    return strayed or Misfit(Reason(Cause.MODEL_DIFFERS))


def _stands(between: Between | Misfit, seen: int) -> bool:
    """Whether as many collisions as were seen, or more, are likelier than not."""
    if isinstance(between, Misfit) or between.count < seen:
        return False
    return between.probability[between.count] > LIKELY


def _start(
    observed: Observations, found: SeenCollisions, known: Knowledge
) -> tuple[Floats, Prior] | Misfit:
    """Rough parameters and the prior; a misfit where there is nothing to begin with."""
    before = int((observed.frame < -1).sum())
    if len(observed.frame) < FRAMES_AT_LEAST or before < 3:
        return Misfit(Reason(Cause.MODEL_LACKS_FRAMES))
    rough = rough_values(observed, known.expected_rate, found.swing)
    return rough, prior_of(rough, known)


def _strayed(misfit_px: float, observed: Observations, track: Track) -> Misfit | None:
    """Say so if the model does not describe the track."""
    least, most = (share * track.ball_diameter_px for share in (MISFIT_SHARE, MISFIT_AT_MOST))
    limit = min(max(MISFIT_SIGMAS * observed.ball_sigma_px, least), most)
    if misfit_px <= limit:
        return None
    return Misfit(Reason(Cause.MODEL_STRAYS, (misfit_px, limit)))


def _root_mean_square(solution: Solution) -> float:
    """Of the ball's residuals, the worst fiftieth aside."""
    squares = np.sort(solution.ball_residuals[np.isfinite(solution.ball_residuals)] ** 2)
    return float(np.sqrt(squares[: max(1, int(0.98 * len(squares)))].mean()))


def _answer(
    found: SeenCollisions,
    observed: Observations,
    weighed: Weighed,
) -> Between:
    chances = probabilities(weighed)
    shares = shares_of(weighed)
    count = max(chances, key=lambda number: chances[number])
    own = np.array([fit.count == count for _, fit in weighed.values()])
    fits = [fit for _, fit in weighed.values() if fit.count == count]
    solution = fits[int(np.argmax(shares[own]))]
    following = end_chances(observed, solution)
    fewer = following.pop(-1, 0.0)
    if found.burst < len(found.collisions) or fewer == 1.0:
        following = {0: 1.0}
    following = {more: chance / sum(following.values()) for more, chance in following.items()}
    chances = with_more(chances, {-1: fewer, 0: 1.0 - fewer})
    if fewer > LIKELY and count > 1:
        count -= 1
        fits = [replace(fit, count=count) for fit in fits]
    values = solution.values
    paths, _ = modelled(observed, values[None], count)
    return Between(
        count=count,
        probability=doubted(chances),
        collisions=collisions_of(observed, fits, shares[own], found),
        mass_ratio=mass_ratio(weighed, shares),
        restitution_bodies=estimate(weighed, shares, Column.BODIES),
        restitution_wall=estimate(weighed, shares, Column.BOUNCE),
        energy_kept=tuple(float(share) for share in energy_kept(paths, values)),
        ending=ending_of(paths, values),
        setup=fitted_setup(weighed, shares),
        misfit_px=_root_mean_square(solution),
        following=following,
        left_out=_left_out(observed, solution),
    )


def _left_out(observed: Observations, solution: Solution) -> LeftOut | None:
    """Frames left out that the fit found besides those that the track allows for."""
    frames = round(solution.values[Column.SKIP])
    if frames == 0:
        return None
    before = observed.frame[observed.after == 0]
    return LeftOut(observed.origin + float(before[-1]), frames, flown=False)

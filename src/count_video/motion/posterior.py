"""Weigh the counts against each other: fine fits, their noise, and the probability of each count.

What the fit leaves unexplained is larger than the noise of single frames and hangs together over
several: compression, shading and a model that is not the world see to that. Where collisions are
close, a track's own estimate of its noise is too large. So the noise is that of the residuals about
the best fit, and only then are its rivals judged.

Where the burst ends has a probability as well: whether the last collision comes before the heavy
body's turn, and whether one more follows after the clip's end.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from count_video.motion.observations import Observations
from count_video.motion.parameters import Column, Prior, deviation_places, within_limits
from count_video.motion.pendulums import follow
from count_video.motion.priors import BELIEVED, MODEL_WRONG, SCATTERS
from count_video.motion.rivals import HOPELESS, Rivals, coarse_fit, fine_fit, neighbouring
from count_video.motion.solving import Noise, Question, Solution, noise_of
from count_video.records import Floats

Weighed = dict[tuple[int, float], tuple[float, Solution]]
"""Logarithm of the evidence and the fit, for each count and scatter."""
IMPROBABLE, IMPROBABLE_AT_LEAST = 10.0, 2
"""Counts beyond so many in a row whose evidence is smaller by so much, as a logarithm, are none."""
MOST_RIVALS = 16
"""Counts on either side of the best that are weighed: where so many are likely, none is known."""
RESIDUALS_AT_LEAST = 20
"""Fewer do not show how large they are."""
CLIPPED_SIGMAS = 6.0
"""Larger residuals count as this: the tracker was misled."""


def residual_noise(
    observed: Observations, prior: Prior, coarse: Solution
) -> tuple[Solution, Noise]:
    """Fit a count finely, and widen the noise to what is left over; returns the fit with it.

    The restitution may scatter as much as it ever does, or its scatter would be taken for noise.
    """
    noise = noise_of(observed, coarse.values, coarse.count)
    fit = fine_fit(Question(observed, noise, prior, coarse.count), coarse.values, SCATTERS[-1])
    noise = noise_of(observed, fit.values, fit.count)
    ball, heavy = (
        _spread(fit.ball_residuals / noise.ball),
        _spread(fit.heavy_residuals / noise.heavy),
    )
    return fit, Noise(noise.ball * ball, noise.heavy * heavy)


def _spread(residuals: np.ndarray) -> float:
    """Factor on the noise for residuals that are larger or smaller than it."""
    kept = residuals[np.isfinite(residuals)]
    if len(kept) < RESIDUALS_AT_LEAST:
        return 1.0
    return float(np.sqrt(np.mean(np.clip(kept, -CLIPPED_SIGMAS, CLIPPED_SIGMAS) ** 2)))


def weigh(rivals: Rivals, start: Solution, noise: Noise) -> Weighed:
    """Fit each count that comes into question, for each scatter; it begins with the ``start``.

    From there it goes up and down, each count from its coarse fit where that is of use, or from the
    fit of its neighbour or, as the kind of the last collision is mostly seen, of the one a pair
    away, until on either side two in a row are out of the question.
    """
    observed, prior = rivals.observed, rivals.prior
    starts = {fit.count: fit for fit in rivals.by_loss()}
    weighed = scattered(Question(observed, noise, prior, start.count), start.values)
    for side in (-1, 1):
        lost = 0
        for count in range(start.count + side, start.count + side * (MOST_RIVALS + 1), side):
            if lost == IMPROBABLE_AT_LEAST or count < 1:
                break
            bearable = min(fit.loss for _, fit in weighed.values()) + HOPELESS
            if count in starts:
                begin = starts[count]
            else:
                near = [(n, s) for (n, s), (_, fit) in weighed.items() if fit.loss < bearable]
                key = min(near, key=lambda k: ((k[0] - count) % 2, abs(k[0] - count), k[1]))
                near_by = neighbouring(weighed[key][1], count)
                begin = coarse_fit(observed, prior, near_by, count, bearable=rivals.bearable)
            question = Question(observed, noise, prior, count)
            weighed |= scattered(question, begin.values, bearable)
            lost = 0 if _evidence_of(weighed, count) > -IMPROBABLE else lost + 1
    return {key: fit for key, fit in weighed.items() if np.isfinite(fit[0])}


def scattered(question: Question, start: Floats, bearable: float = np.inf) -> Weighed:
    """Weigh the scatters of the restitution for one count, from the values of a fit."""
    weighed: Weighed = {}
    for scatter in SCATTERS[::-1]:
        fit = fine_fit(question, start, scatter, bearable)
        weighed[question.count, scatter] = log_evidence(fit, scatter), fit
        start = fit.values
        if fit.loss > bearable:
            break
    return weighed


def log_evidence(solution: Solution, scatter: float) -> float:
    """Logarithm of the evidence for a count, up to what all counts have in common.

    It is the likelihood integrated over all parameters by Laplace's approximation about the fit, so
    that a count that needs unlikely scatter of the restitution pays for it.
    """
    if not np.isfinite(solution.loss):
        return -np.inf
    scale = np.sqrt(np.maximum(np.diag(solution.hessian), 1e-300))
    scaled = solution.hessian / scale[:, None] / scale
    _, log_determinant = np.linalg.slogdet(scaled + 1e-10 * np.eye(len(scaled)))
    volume = log_determinant + 2 * np.log(scale).sum()
    spread = np.log(scatter / np.sqrt(np.bincount(deviation_places(solution.count)))).sum()
    return float(-solution.loss - 0.5 * volume - spread)


def _evidence_of(weighed: Weighed, count: int) -> float:
    """Logarithm of a count's best evidence over that of the best count."""
    highest = max(evidence for evidence, _ in weighed.values())
    own = [evidence for (number, _), (evidence, _) in weighed.items() if number == count]
    return max(own, default=-np.inf) - highest


def shares_of(weighed: Weighed) -> Floats:
    """Probability of each explanation by its evidence, of which a part is believed.

    Shape (fits,); sums to 1.
    """
    evidence = np.array([evidence for evidence, _ in weighed.values()])
    shares = np.exp(BELIEVED * (evidence - evidence.max()))
    return np.asarray(shares / shares.sum())


def probabilities(weighed: Weighed) -> dict[int, float]:
    """Probability of each count: that of all its explanations."""
    chances: dict[int, float] = {}
    for (count, _), share in zip(weighed, shares_of(weighed), strict=True):
        chances[count] = chances.get(count, 0.0) + float(share)
    return chances


def with_more(chances: Mapping[int, float], more: Mapping[int, float]) -> dict[int, float]:
    """Add to each count as many as there may be more, or fewer, each with its probability."""
    total: dict[int, float] = {}
    for count, chance in chances.items():
        for number, share in more.items():
            total[count + number] = total.get(count + number, 0.0) + chance * share
    return dict(sorted(total.items()))


def doubted(chances: Mapping[int, float]) -> dict[int, float]:
    """Leave some probability to what the model does not know: one collision more or fewer."""
    near = {-1: MODEL_WRONG / 2, 0: 1 - MODEL_WRONG, 1: MODEL_WRONG / 2}
    return {number: chance for number, chance in with_more(chances, near).items() if chance >= 1e-6}


DRAWS = 200
FOLLOWED_AT_MOST = 12
"""Collisions after the clip's end that are foreseen."""


def end_chances(observed: Observations, solution: Solution) -> dict[int, float]:
    """Probability that the burst has so many collisions more than were fitted; -1 is one fewer.

    Draws from the fit's uncertainty are followed. More are those between the clip's end and the
    heavy body's turn; one that the frames would have to show is none, as the fit has decided on
    those. One fewer it is where the body had turned before the last.
    """
    sets = within_limits(draws_of(solution, BELIEVED))
    paths = follow(sets, solution.count + FOLLOWED_AT_MOST, float(observed.frame[0]) - 1.0)
    count = solution.count
    late = (paths.states[1, :, count - 1] > 0) & (paths.before[1, :, count] < 0)
    more, going = np.where(late, -1, 0), ~late
    rate, rest, _, _ = paths.laws
    end = observed.end + solution.values[Column.SKIP]
    for last in range(count, count + FOLLOWED_AT_MOST):
        heavy, velocity = paths.states[0, :, last], paths.states[1, :, last]
        # It turns toward the wall where it is farthest from it, not where it is nearest.
        phase = np.arctan2(velocity, rate * (heavy - rest)) % (2 * np.pi)
        following = paths.time[:, last + 1]
        going &= (following > end) & (following < paths.time[:, last] + phase / rate)
        more += going
    return {number: float(np.mean(more == number)) for number in sorted(set(more.tolist()))}


def draws_of(solution: Solution, believed: float = 1.0) -> Floats:
    """Draw parameter sets from a fit's uncertainty, shape (draws, columns).

    Of the precision that the fit claims a part is believed.
    """
    covariance = np.linalg.pinv(solution.hessian, hermitian=True) / believed
    values, vectors = np.linalg.eigh(covariance)
    widths = np.sqrt(np.maximum(values, 0.0))
    rng = np.random.default_rng(0)  # the same clip gets the same answer
    normal = rng.normal(size=(DRAWS, len(widths)))
    return np.asarray(solution.values + (normal * widths) @ vectors.T)

"""Weigh the counts against each other: fine fits, their noise, and the probability of each count.

What the fit leaves unexplained is larger than the noise of single frames and hangs together over
several: compression, shading and a model that is not the world see to that. Where collisions crowd,
a track's own estimate of its noise is too large. So the noise is that of the residuals about the
best fit, and only then are its rivals judged.

Where the burst ends has a probability as well: whether the last collision comes before the heavy
body's turn, and whether one more follows after the clip's end.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from count_video.motion.observations import Observations
from count_video.motion.parameters import FIRST_DEVIATION, Column, Prior, within_limits
from count_video.motion.pendulums import follow
from count_video.motion.priors import BELIEVED, MODEL_WRONG, SCATTERS
from count_video.motion.rivals import (
    HOPELESS,
    fine_fit,
    log_evidence,
    recounted,
    refloored,
    with_deviations,
)
from count_video.motion.solving import Noise, Solution, noise_of, scaled
from count_video.records import Floats

Weighed = dict[tuple[int, float], tuple[float, Solution]]
"""Logarithm of the evidence and the fit, for each count and scatter."""
IMPROBABLE = 10.0
"""Nor do those beyond a count whose evidence is smaller by so much, as a logarithm."""
MOST_RIVALS = 16
"""Counts on either side of the best that are looked at: where so many are likely, none is known."""
PASSES = 4
"""So often at most the counts are weighed from another best one on."""
CORRELATED_AT_MOST = 40
"""Lag in frames up to which residuals may hang together."""
RESIDUALS_AT_LEAST = 20
"""Fewer do not tell how they hang together."""
LEAST_FREE_SHARE = 0.2
"""Of fewer degrees of freedom the residuals tell the noise to no better than the track."""


def fine_fits(
    observed: Observations, prior: Prior, coarse: list[Solution]
) -> tuple[list[Solution], Noise]:
    """Fit the likeliest counts finely, best first, and widen the noise to what is left over.

    The restitution may scatter as much as it ever does, or its scatter would be taken for noise.
    """
    noise = noise_of(observed, coarse[0].values, coarse[0].count)
    scatter = SCATTERS[-1]
    fits: list[Solution] = []
    for solution in coarse:
        bearable = min((fit.loss for fit in fits), default=np.inf) + HOPELESS
        fits.append(fine_fit(observed, noise, prior, solution, scatter, bearable))
    fits.sort(key=lambda solution: solution.loss)
    best = fits[0]
    noise = noise_of(observed, best.values, best.count)
    free = _free_share(best, with_deviations(prior, best.count, scatter))
    return fits, scaled(
        noise,
        _spread(best.ball_residuals / noise.ball, free),
        _spread(best.heavy_residuals / noise.heavy, free),
    )


def _free_share(fit: Solution, prior: Prior) -> float:
    """Share of the residuals' degrees of freedom that a fit leaves.

    It takes as many as it has columns, less what the prior knows of them: a column's precision by
    the prior is a part of that by all, tr(H^-1 P) of all columns together.
    """
    known = prior.sigma > 0
    covariance = np.linalg.pinv(fit.hessian, hermitian=True)
    taken = known.sum() - np.diag(covariance)[known] @ prior.sigma[known] ** -2.0
    shown = sum(int(np.isfinite(one).sum()) for one in (fit.ball_residuals, fit.heavy_residuals))
    return max(1.0 - float(taken) / shown, LEAST_FREE_SHARE)


def _spread(residuals: np.ndarray, free: float) -> float:
    """Factor on the noise for residuals that are larger or smaller than it, or hang together."""
    kept = residuals[np.isfinite(residuals)]
    if len(kept) < RESIDUALS_AT_LEAST:
        return 1.0
    spread = float(np.sqrt(np.mean(np.clip(kept, -6, 6) ** 2)))
    centred = np.clip(kept, -6, 6) / max(spread, 1e-9)
    together = 1.0
    for lag in range(1, min(CORRELATED_AT_MOST, len(kept) // 4)):
        correlation = float(np.mean(centred[lag:] * centred[:-lag]))
        if correlation < 2 / np.sqrt(len(kept)):
            break
        together += 2 * correlation
    return spread * float(np.sqrt(together / free))


def weigh(
    observed: Observations,
    noise: Noise,
    prior: Prior,
    rivals: list[Solution],
    coarse: list[Solution],
) -> Weighed:
    """Fit each count that comes into question with each scatter; ``rivals`` begin with the best.

    From the best count it goes up and down, each count from its coarse fit where there is one, or
    from the fit of its neighbour or, as the kind of the last collision is mostly seen, of the one a
    pair away, until on either side two in a row are out of the question.
    """
    best = rivals[0]
    weighed: Weighed = {}
    _weigh_count(weighed, observed, noise, prior, best)
    for rival in rivals[1:]:
        if rival.loss < best.loss + HOPELESS:
            _weigh_count(weighed, observed, noise, prior, rival)
    best = _best(weighed)
    starts = {fit.count: fit for fit in coarse}
    for _ in range(PASSES):
        impossible: set[int] = set()
        for side in (-1, 1):
            lost = 0
            for count in range(best.count + side, best.count + side * (MOST_RIVALS + 1), side):
                if lost == 2 or count < 1:
                    break
                if abs(count - best.count) > 1 and count % 2 in impossible:
                    continue
                if (count, SCATTERS[0]) not in weighed or not starts:
                    start = starts.get(count) or _from_neighbour(weighed, observed, prior, count)
                    _weigh_count(weighed, observed, noise, prior, start)
                evidence = _evidence_of(weighed, count)
                lost = lost + 1 if evidence < -IMPROBABLE else 0
                if (count - best.count) % 2 and evidence < -HOPELESS:
                    impossible.add(count % 2)  # the last collision was seen to be of the other kind
        before, best = best, _best(weighed)
        if best.count == before.count:
            break
        starts = {}  # They led to a worse one: the others are fitted anew, from this one on.
    return {key: fit for key, fit in weighed.items() if np.isfinite(fit[0])}


def scattered(observed: Observations, noise: Noise, prior: Prior, fit: Solution) -> Weighed:
    """Weigh the scatters of the restitution for the count of one fit."""
    weighed: Weighed = {}
    _weigh_count(weighed, observed, noise, prior, fit)
    return weighed


def _best(weighed: Weighed) -> Solution:
    return max(weighed.values(), key=lambda fit: fit[0])[1]


def _from_neighbour(weighed: Weighed, observed: Observations, prior: Prior, count: int) -> Solution:
    """Fit a count coarsely, from the nearest one that was weighed.

    Of that one's fits the one with the least scatter is taken: its deviations are left behind.
    """
    bearable = min(fit.loss for _, fit in weighed.values()) + HOPELESS
    near = [(n, s) for (n, s), (_, fit) in weighed.items() if fit.loss < bearable]
    near = [key for key in near if key[0] != count] or near
    nearest = min(near, key=lambda key: ((key[0] - count) % 2, abs(key[0] - count), key[1]))
    return refloored(observed, prior, _start(weighed[nearest][1], count), count)


def _start(neighbour: Solution, count: int) -> Floats:
    """Begin with a neighbour's motion: one collision fewer or more is its end cut or gone on."""
    if (count - neighbour.count) % 2:
        return neighbour.values[:FIRST_DEVIATION]
    return recounted(neighbour, count)


def _weigh_count(
    weighed: Weighed, observed: Observations, noise: Noise, prior: Prior, start: Solution
) -> None:
    """Add the fits of a count from a start, where they are better than those that are there."""
    solution = start
    bearable = min((fit.loss for _, fit in weighed.values()), default=np.inf) + HOPELESS
    for scatter in SCATTERS[::-1]:
        solution = fine_fit(observed, noise, prior, solution, scatter, bearable)
        evidence = log_evidence(solution, scatter)
        if evidence > weighed.get((start.count, scatter), (-np.inf, solution))[0]:
            weighed[start.count, scatter] = evidence, solution
        if solution.loss > bearable:
            return


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
    """Leave room for what the model does not know: one collision more or fewer."""
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
    rate, rest = paths.pendulums.heavy_rate, paths.pendulums.heavy_rest
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

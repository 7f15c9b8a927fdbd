"""Where the burst ends: whether the last collision comes before the turn, and whether one more."""

from __future__ import annotations

import numpy as np

from count_video.between.model import follow
from count_video.between.observations import Observations
from count_video.between.parameters import within_limits
from count_video.between.solving import Solution
from count_video.motion.priors import BELIEVED
from count_video.records import Floats

DRAWS = 200


def end_chances(observed: Observations, solution: Solution) -> tuple[float, float]:
    """Probabilities that the burst has one collision fewer than was fitted, and one more.

    Draws from the fit's uncertainty are followed for one collision more. One more is one between
    the clip's end and the heavy body's turn; one that the frames would have to show is none, as
    the fit has decided on those. One fewer it is where the body had turned before the last.
    """
    rng = np.random.default_rng(0)  # the same clip gets the same answer
    sets = within_limits(_draws(solution, rng))
    paths = follow(sets, solution.count + 1, float(observed.frame[0]) - 1.0)
    last, following = paths.time[:, -2], paths.time[:, -1]
    heavy, velocity = paths.states[0, :, -2], paths.states[1, :, -2]
    rate, rest = paths.pendulums.heavy_rate, paths.pendulums.heavy_rest
    # The heavy body turns toward the wall where it is farthest from it, not where it is nearest.
    turn = last + np.arctan2(velocity, rate * (heavy - rest)) % (2 * np.pi) / rate
    late = (paths.states[1, :, -3] > 0) & (paths.before[1, :, -2] < 0)
    more = (following > observed.end) & (following < turn) & ~late
    return float(np.mean(late)), float(np.mean(more))


def _draws(solution: Solution, rng: np.random.Generator) -> Floats:
    covariance = np.linalg.pinv(solution.hessian, hermitian=True) / BELIEVED
    values, vectors = np.linalg.eigh(covariance)
    widths = np.sqrt(np.maximum(values, 0.0))
    normal = rng.normal(size=(DRAWS, len(widths)))
    return np.asarray(solution.values + (normal * widths) @ vectors.T)

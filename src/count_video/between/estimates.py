"""What is told of the parameters: means over all fits that come into question, not of one alone.

The scatter of the restitution from collision to collision is not known, and in long bursts neither
is the count. Each has its own best mass ratio, from which a single fit's uncertainty knows nothing.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from count_video.between.parameters import Column
from count_video.between.solving import Solution
from count_video.between.weighing import Weighed
from count_video.records import Estimate, Floats


def shares_of(weighed: Weighed, chances: Mapping[int, float]) -> Floats:
    """Share of each fit: within a count by evidence, and between the counts by their chances.

    Shape (fits,); sums to 1.
    """
    counts = np.array([count for count, _ in weighed])
    evidence = np.array([evidence for evidence, _ in weighed.values()])
    shares = np.zeros(len(counts))
    for count in set(counts.tolist()):
        own = counts == count
        within = np.exp(evidence[own] - evidence[own].max())
        shares[own] = chances.get(count, 0.0) * within / within.sum()
    return np.asarray(shares / shares.sum())


def estimate(weighed: Weighed, shares: Floats, column: Column) -> Estimate:
    """Give mean and standard deviation of a parameter over all fits and their uncertainties."""
    values = np.array([fit.values[column] for _, fit in weighed.values()])
    variances = np.array([variances_of(fit)[column] for _, fit in weighed.values()])
    mean = float(shares @ values)
    return Estimate(mean, float(np.sqrt(shares @ (variances + (values - mean) ** 2))))


def mass_ratio(weighed: Weighed, shares: Floats) -> Estimate:
    """Heavy over light, from the logarithm of the lightness."""
    lightness = estimate(weighed, shares, Column.LIGHTNESS)
    ratio = float(np.exp(-lightness.value))
    return Estimate(ratio, ratio * lightness.sigma)


def variances_of(solution: Solution) -> Floats:
    """Variances of a fit's parameters, shape (columns,)."""
    return np.asarray(np.maximum(np.diag(np.linalg.pinv(solution.hessian, hermitian=True)), 0.0))

"""What the trials say together: the paper's table, and how sure it is."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from statistics import fmean, median, pstdev, stdev

from count_video.physics.theory import collision_count
from count_video.reports.campaign_rows import CampaignSummary, Spread, TheorySource, TrialRow

ALIKE = 0.05
"""Measured mass ratios that differ by less (in the median, as a share) are of the same bodies."""


def summarise(rows: Sequence[TrialRow]) -> CampaignSummary:
    """Sum up a campaign over its counted trials."""
    counted = [row for row in rows if row.count is not None]
    counts = [row.count for row in counted if row.count is not None]
    expected, uncertainty = _by_the_probabilities(counted)
    theory, source = _theory(rows)
    return CampaignSummary(
        trials=len(rows),
        counted=len(counts),
        maximum=max(counts, default=None),
        minimum=min(counts, default=None),
        mean=fmean(counts) if counts else None,
        sd_population=pstdev(counts) if counts else None,
        sd_sample=stdev(counts) if len(counts) > 1 else None,
        mean_uncertainty=uncertainty,
        mean_expected=expected,
        histogram=dict(sorted(Counter(counts).items())),
        theory=theory,
        theory_source=source,
        restitution_bodies=_spread(row.restitution_bodies for row in counted),
        restitution_wall=_spread(row.restitution_wall for row in counted),
        energy_kept=_spread(row.energy_kept for row in counted),
        geometric_share=_share(counted),
    )


def _by_the_probabilities(counted: Sequence[TrialRow]) -> tuple[float | None, float | None]:
    """Return the expected mean and the root mean square error of the mean as printed.

    The trials err independently: the variance of their sum is the sum of the variances. Where the
    probabilities lean to one side, the sum is off by the sum of the differences on top.
    """
    if not counted or not all(row.chances for row in counted):
        return None, None
    off = variance = 0.0
    for row in counted:
        total = sum(row.chances.values())
        mean = sum(count * chance for count, chance in row.chances.items()) / total
        squares = sum((count - mean) ** 2 * chance for count, chance in row.chances.items())
        variance += squares / total
        off += mean - (row.count or 0)
    n = len(counted)
    stated = fmean(row.count or 0 for row in counted)
    return stated + off / n, math.sqrt(variance + off * off) / n


def _theory(rows: Sequence[TrialRow]) -> tuple[int | None, TheorySource | None]:
    """Count of the masses given if they agree, else of the median of the measured ratios."""
    given = {row.theory for row in rows}
    if given and None not in given:
        return (given.pop(), "masses") if len(given) == 1 else (None, None)
    ratios = [row.mass_ratio for row in rows if row.mass_ratio is not None]
    if not ratios:
        return None, None
    middle = median(ratios)
    alike = median(abs(ratio - middle) for ratio in ratios) <= ALIKE * middle
    return (collision_count(middle), "measured") if alike else (None, None)


def _spread(values: Iterable[float | None]) -> Spread | None:
    told = [value for value in values if value is not None]
    return Spread(len(told), fmean(told), pstdev(told)) if told else None


def _share(rows: Sequence[TrialRow]) -> float | None:
    endings = [row.ending for row in rows if row.ending is not None]
    return endings.count("geometric") / len(endings) if endings else None

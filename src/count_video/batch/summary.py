"""A whole campaign: what is known, what is still to do, and what the trials say together."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from statistics import fmean, pstdev
from typing import Any

from count_video.batch.executor import Answer, Done, answer_of
from count_video.batch.manifest import Job
from count_video.batch.results import ResultStore
from count_video.errors import UsageError
from count_video.outputs import remedy
from count_video.planning.variations import count_figures
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import Estimate, TrialResult
from count_video.reports.campaign import CampaignSummary, Spread, Summary, TrialRow, theories_of

ALIKE = 0.05
"""Mass ratios that differ by less, as a share, are of the same bodies: clay and balances vary."""
ALIKE_SIGMAS = 3.0
"""And so are ratios that differ by less than so many standard uncertainties."""


def run_campaign(
    jobs: Sequence[Job],
    count: Callable[[Sequence[Job]], Done],
    store: ResultStore | None,
    progress: Progress = NO_PROGRESS,
) -> Iterator[TrialRow]:
    """Count all jobs and yield them in their own order, each when it and those before are there.

    ``count`` is asked for those that are not known already. In the ``store`` results are kept and
    sought; None keeps nothing.
    """
    recalled = jobs if store is None else [store.recall(job) for job in jobs]
    done = {one.name: one for one in recalled if isinstance(one, TrialRow)}
    rest = [one for one in recalled if isinstance(one, Job)]
    if not rest:
        yield from done.values()
        return
    progress.start(len(rest), f"{len(done)} known already," if done else "")
    try:
        with closing(count(rest)) as arriving:
            for job in jobs:
                while job.name not in done:
                    asked, future = next(arriving)
                    done[asked.name] = _kept_row(asked, answer_of(asked, future), store)
                    progress.advance(1)
                yield done[job.name]
            next(arriving, None)  # to its end, where the workers, who have nothing more to do, end
    finally:
        progress.finish()


def _kept_row(job: Job, answer: Answer, store: ResultStore | None) -> TrialRow:
    """Keep an answer, and return its row, which says so if that failed."""
    row = TrialRow(job.name, answer.result.answer, job.settings.masses, answer.undrawn)
    if store is None:
        return row
    try:
        store.keep(job, answer)
    except OSError as error:
        helps = remedy(error, "give another folder with -o")
        reason = f"the result could not be written ({error.strerror}); {helps}"
        return replace(row, not_kept=reason)
    except UsageError as error:
        return replace(row, not_kept=f"the result could not be written ({error})")
    # What is not final leaves the record of an earlier result.
    return replace(row, files=store.evidence(job)) if answer.final else row


def summarise(rows: Sequence[TrialRow]) -> CampaignSummary:
    """Sum up a campaign over its counted trials, and over those of each mass ratio."""
    groups = [_summary(group) for group in _groups(rows)]
    whole = _summary(rows)
    if len(groups) < 2:
        return CampaignSummary(whole, (whole,))
    # No one theory holds for all of them.
    theory: dict[str, Any] = dict.fromkeys(("theory", "theory_source", "theory_low", "theory_high"))
    return CampaignSummary(replace(whole, **theory, mass_ratio=None), tuple(groups))


def _groups(rows: Sequence[TrialRow]) -> list[list[TrialRow]]:
    """Part the rows by mass ratio, from the least; those without a count only if it was given.

    The surest ratios come first, and each row joins the nearest group whose first ratio it may
    have: so a vague ratio cannot join two sure ones that differ.
    """

    def vagueness(row: TrialRow) -> float:
        ratio = row.mass_ratio
        return math.inf if ratio is None else ratio.sigma / ratio.value

    groups: list[list[TrialRow]] = []
    for row in sorted(_weighed(rows), key=vagueness):
        nearest = min(groups, key=lambda group: _apart(row, group[0]), default=None)
        if nearest is None or math.isinf(_apart(row, nearest[0])):
            groups.append([row])
        else:
            nearest.append(row)
    return sorted(groups, key=lambda group: getattr(group[0].mass_ratio, "value", math.inf))


def _weighed(rows: Sequence[TrialRow]) -> list[TrialRow]:
    """Return those whose mass ratio counts: it was given, or measured in a clip with a count."""
    return [row for row in rows if row.result.count is not None or row.masses is not None]


def _apart(row: TrialRow, first: TrialRow) -> float:
    """Difference of two mass ratios; infinite where they are not of the same bodies."""
    one, other = row.mass_ratio, first.mass_ratio
    if one is None or other is None:
        return 0.0 if one is other else math.inf
    apart = abs(one.value - other.value)
    within = max(ALIKE * other.value, ALIKE_SIGMAS * math.hypot(one.sigma, other.sigma))
    return apart if apart <= within else math.inf


def _summary(rows: Sequence[TrialRow]) -> Summary:
    counted = [row.result for row in rows if row.result.count is not None]
    counts = [row.result.count for row in rows if row.result.count is not None]
    expected, uncertainty = _by_the_probabilities(counted)
    endings = [one.ending.kind for one in counted if one.ending is not None]
    ratio = _ratio(rows)
    given = sorted({row.theory for row in rows if row.theory is not None})
    theories: Sequence[int] = given
    if ratio is not None and not given:
        theories = theories_of(ratio)
    return Summary(
        trials=len(rows),
        mean_uncertainty=uncertainty,
        mean_expected=expected,
        theory=theories[0] if theories and theories[0] == theories[-1] else None,
        theory_source=None if not theories else "masses" if given else "measured",
        theory_low=theories[0] if theories else None,
        theory_high=theories[-1] if theories else None,
        mass_ratio=ratio,
        restitution_bodies=_spread_of(one.restitution_bodies for one in counted),
        restitution_wall=_spread_of(one.restitution_wall for one in counted),
        energy_kept=_spread(one.energy_kept[-1] for one in counted if one.energy_kept),
        geometric_share=endings.count("geometric") / len(endings) if endings else None,
        **count_figures(counts),
    )


def _by_the_probabilities(counted: Sequence[TrialResult]) -> tuple[float | None, float | None]:
    """Return the expected mean and the root mean square error of the mean as printed.

    The trials err independently: the variance of their sum is the sum of the variances. Where the
    probabilities lean to one side, the sum is off by the sum of the differences on top.
    """
    if not counted or not all(sum(one.probability.values()) > 0 for one in counted):
        return None, None
    off = variance = 0.0
    for one in counted:
        total = sum(one.probability.values())
        mean = sum(count * chance for count, chance in one.probability.items()) / total
        squares = sum((count - mean) ** 2 * chance for count, chance in one.probability.items())
        variance += squares / total
        off += mean - (one.count or 0)
    n = len(counted)
    stated = fmean(one.count or 0 for one in counted)
    return stated + off / n, math.sqrt(variance + off * off) / n


def _ratio(rows: Sequence[TrialRow]) -> Estimate | None:
    """Mean of the mass ratios, weighted by their uncertainties; one that is given stands."""
    ratios = [row.mass_ratio for row in _weighed(rows) if row.mass_ratio is not None]
    if not ratios or any(ratio.sigma == 0 for ratio in ratios):
        return min(ratios, key=lambda ratio: ratio.sigma, default=None)
    weight = sum(ratio.sigma**-2 for ratio in ratios)
    mean = sum(ratio.value * ratio.sigma**-2 for ratio in ratios) / weight
    squares = sum(((ratio.value - mean) / ratio.sigma) ** 2 for ratio in ratios)
    # Where they scatter by more than their uncertainties say, those are too small (Birge 1932).
    birge = math.sqrt(max(1.0, squares / max(1, len(ratios) - 1)))
    return Estimate(mean, birge * weight**-0.5)


def _spread_of(estimates: Iterable[Estimate | None]) -> Spread | None:
    return _spread(one.value for one in estimates if one is not None)


def _spread(values: Iterable[float]) -> Spread | None:
    known = [value for value in values if math.isfinite(value)]
    return Spread(len(known), fmean(known), pstdev(known)) if known else None

"""A whole campaign: what is known, what is still to do, and what the trials say together."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from statistics import fmean, pstdev
from typing import Any

from count_video.batch.executor import Answer, answers
from count_video.batch.manifest import Job
from count_video.batch.results import ResultStore
from count_video.errors import UsageError
from count_video.inputs import Signature, signature
from count_video.parallel import Workers
from count_video.physics.theory import collision_count
from count_video.planning.spread import count_figures
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import Estimate
from count_video.reports.campaign import CampaignSummary, Spread, Summary, TrialRow
from count_video.reports.json_object import read_result

ALIKE = 0.05
"""Mass ratios that differ by less, as a share, are of the same bodies: clay and balances vary."""
ALIKE_SIGMAS = 3.0
"""And so are ratios that differ by less than so many standard uncertainties."""
THEORY_SIGMAS = 2.0
"""The theory's counts are those of mass ratios within so many standard uncertainties."""


def run_campaign(
    jobs: Sequence[Job],
    start_workers: Callable[[], Workers],
    store: ResultStore | None,
    progress: Progress = NO_PROGRESS,
) -> Iterator[TrialRow]:
    """Count all jobs and yield them in their own order, each when it and those before are there.

    Parameters
    ----------
    start_workers
        Not called where all is known already.
    store
        Where results are kept and sought; None keeps nothing.
    """
    done: dict[str, TrialRow] = {}
    rest = []
    for job in jobs:
        text = None if store is None else store.known(job)
        if store is None or text is None:
            rest.append(job)
        elif store.has_pages(job):
            done[job.name] = row_of(job, text, None, store.evidence(job))
        else:
            rest.append(replace(job, followed=store.followed(job)))
    if not rest:
        yield from (done[job.name] for job in jobs)
        return
    progress.start(len(rest), f"{len(done)} known already," if done else "")
    signatures = {job.name: signature(job.file) for job in rest}
    try:
        with closing(answers(rest, start_workers())) as arriving:
            for job in jobs:
                while job.name not in done:
                    asked, answer = next(arriving)
                    done[asked.name] = _kept_row(asked, answer, signatures[asked.name], store)
                    progress.advance(1)
                yield done[job.name]
            next(arriving, None)  # to its end, where the workers, who have nothing more to do, end
    finally:
        progress.finish()


def _kept_row(job: Job, answer: Answer, seen: Signature, store: ResultStore | None) -> TrialRow:
    """Keep an answer, and return its row, which says so if that failed."""
    if store is None:
        return row_of(job, answer.text)
    try:
        store.keep(job, answer, seen)
    except OSError as error:
        reason = f"the result could not be written ({error.strerror}); free space and start again"
        return row_of(job, answer.text, reason)
    except UsageError as error:
        return row_of(job, answer.text, f"the result could not be written ({error})")
    # What is not final leaves the record of an earlier result.
    return row_of(job, answer.text, None, store.evidence(job) if answer.final else frozenset())


def row_of(
    job: Job, text: str, not_kept: str | None = None, files: frozenset[str] = frozenset()
) -> TrialRow:
    """Read a result's JSON text; one path for results of this run and of earlier ones.

    Raises
    ------
    ValueError
        It is no result of this program.
    """
    return TrialRow(job.name, read_result(text), job.settings.masses, not_kept, files, text)


def summarise(rows: Sequence[TrialRow]) -> CampaignSummary:
    """Sum up a campaign over its counted trials, and over those of each mass ratio."""
    groups = [_summary(group) for group in _groups(rows)]
    whole = _summary(rows)
    if len(groups) > 1:
        nothing: dict[str, Any] = {
            "theory": None,
            "theory_source": None,
            "theory_low": None,
            "theory_high": None,
        }
        whole = replace(whole, **nothing, mass_ratio=None)
    return CampaignSummary(whole, tuple(groups) if len(groups) > 1 else (whole,))


def _groups(rows: Sequence[TrialRow]) -> list[list[TrialRow]]:
    """Part the rows by mass ratio, from the least; those without a count only if it was given.

    The surest ratios come first, and each row joins the nearest group whose first ratio it may
    have: so a vague ratio cannot join two sure ones that differ.
    """
    groups: list[list[TrialRow]] = []
    firsts: list[Estimate | None] = []
    known = [row for row in rows if row.count is not None or row.masses is not None]
    for row in sorted(known, key=_vagueness):
        ratio = row.mass_ratio
        near = [k for k, first in enumerate(firsts) if _alike(ratio, first)]
        if near:
            groups[min(near, key=lambda k: _apart(ratio, firsts[k]))].append(row)
        else:
            groups.append([row])
            firsts.append(ratio)
    order = sorted(range(len(groups)), key=lambda k: getattr(firsts[k], "value", math.inf))
    return [groups[k] for k in order]


def _vagueness(row: TrialRow) -> float:
    ratio = row.mass_ratio
    return math.inf if ratio is None else ratio.sigma / ratio.value


def _alike(one: Estimate | None, other: Estimate | None) -> bool:
    if one is None or other is None:
        return one is other
    within = max(ALIKE * other.value, ALIKE_SIGMAS * math.hypot(one.sigma, other.sigma))
    return abs(one.value - other.value) <= within


def _apart(one: Estimate | None, other: Estimate | None) -> float:
    return 0.0 if one is None or other is None else abs(one.value - other.value)


def _summary(rows: Sequence[TrialRow]) -> Summary:
    counted = [row for row in rows if row.count is not None]
    counts = [row.count for row in counted if row.count is not None]
    expected, uncertainty = _by_the_probabilities(counted)
    endings = [row.ending for row in counted if row.ending is not None]
    ratio = _ratio(rows)
    theories = _theories(rows, ratio)
    return Summary(
        trials=len(rows),
        counted=len(counts),
        mean_uncertainty=uncertainty,
        mean_expected=expected,
        theory=theories[0] if theories and theories[0] == theories[-1] else None,
        theory_source=None if not theories else "masses" if _given(rows) else "measured",
        theory_low=theories[0] if theories else None,
        theory_high=theories[-1] if theories else None,
        mass_ratio=ratio,
        restitution_bodies=_spread(row.figure("restitution", "bodies", "value") for row in counted),
        restitution_wall=_spread(row.figure("restitution", "wall", "value") for row in counted),
        energy_kept=_spread(row.figure("energy_kept") for row in counted),
        geometric_share=endings.count("geometric") / len(endings) if endings else None,
        **count_figures(counts),
    )


def _by_the_probabilities(counted: Sequence[TrialRow]) -> tuple[float | None, float | None]:
    """Return the expected mean and the root mean square error of the mean as printed.

    The trials err independently: the variance of their sum is the sum of the variances. Where the
    probabilities lean to one side, the sum is off by the sum of the differences on top.
    """
    if not counted or not all(sum(row.chances.values()) > 0 for row in counted):
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


def _given(rows: Sequence[TrialRow]) -> set[int]:
    return {row.theory for row in rows if row.theory is not None}


def _ratio(rows: Sequence[TrialRow]) -> Estimate | None:
    """Mean of the mass ratios, weighted by their uncertainties; one that is given stands."""
    known = [row.mass_ratio for row in rows if row.count is not None or row.masses is not None]
    ratios = [ratio for ratio in known if ratio is not None]
    if not ratios or any(ratio.sigma == 0 for ratio in ratios):
        return min(ratios, key=lambda ratio: ratio.sigma, default=None)
    weight = sum(ratio.sigma**-2 for ratio in ratios)
    mean = sum(ratio.value * ratio.sigma**-2 for ratio in ratios) / weight
    squares = sum(((ratio.value - mean) / ratio.sigma) ** 2 for ratio in ratios)
    # Where they scatter by more than their uncertainties say, those are too small (Birge 1932).
    birge = math.sqrt(max(1.0, squares / max(1, len(ratios) - 1)))
    return Estimate(mean, birge * weight**-0.5)


def _theories(rows: Sequence[TrialRow], ratio: Estimate | None) -> Sequence[int]:
    """List the counts of lossless bodies of these masses; none where nothing is known."""
    given = sorted(_given(rows))
    if given or ratio is None:
        return given
    # The heavy body is the heavier one.
    low, high = (max(1.0, ratio.value + side * THEORY_SIGMAS * ratio.sigma) for side in (-1, 1))
    return range(collision_count(low), collision_count(high) + 1)


def _spread(values: Iterable[float | None]) -> Spread | None:
    known = [value for value in values if value is not None]
    return Spread(len(known), fmean(known), pstdev(known)) if known else None

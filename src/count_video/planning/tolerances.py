"""Trials that are meant to be alike: how their counts scatter with hands, threads and losses."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean, pstdev, stdev

import numpy as np

from count_video.physics.many import ManySetups, simulate_many
from count_video.physics.swings import Whole
from count_video.planning.request import PlanRequest, most_collisions
from count_video.records import Floats

SPREAD_TRIALS = 2000
"""Simulated trials of the distribution of counts, ..."""
MOST_EVENTS = 250_000
"""... or fewer, where they would have more collisions together than this."""
FEWEST_TRIALS = 100
LEAST_GAP_M = 1e-4
"""Hands that scatter do not hang the ball inside the wall."""
TABLES, FEWEST_TABLES = 2000, 100
"""Tables of trials that are drawn from the distribution, to see how they differ, ..."""
MOST_DRAWN = 4_000_000
"""... unless they would have more trials together than this."""
CENTRAL = (0.025, 0.975)
"""Quantiles that hold 95 % between them."""
_STREAM_TABLE, _STREAM_SPREAD, _STREAM_GROUPS = range(3)


@dataclass(frozen=True)
class Spread:
    """Distribution of the counts of trials that are meant to be alike."""

    trials: int
    """Trials simulated; all figures but ``endless_share`` are over those with a count."""
    histogram: dict[int, int]
    endless_share: float
    """Share of the trials in which the ball rattles to rest between cylinder and wall, which loses
    so much that there is no count to speak of."""
    mean: float
    sd: float
    """Standard deviation of a count."""
    theory_share: float
    """Share of all trials that give the theory's count."""
    table_trials: int
    """Trials of a table, for which the next three hold."""
    table_mean: tuple[float, float]
    """The mean of a table lies between these in 95 of 100 tables."""
    table_sd: tuple[float, float]
    """And the standard deviation (population) between these."""


@dataclass(frozen=True)
class TrialTable:
    """A table of simulated trials, with the figures of the paper's table."""

    trials: int
    counts: tuple[int, ...]
    """In order; those of endless trials are left out."""
    maximum: int | None
    """This and the figures below are None where no trial has a count."""
    minimum: int | None
    mean: float | None
    sd_population: float | None
    sd_sample: float | None
    histogram: dict[int, int]
    theory: int


def drawn_setups(request: PlanRequest, trials: int, seed: Sequence[int]) -> ManySetups:
    """Draw set-ups as hands make them; the same seed gives the same errors of the hands."""
    rng = np.random.default_rng(list(seed))
    off = request.tolerances
    normal = rng.standard_normal((6, trials))
    even = rng.uniform(size=(2, trials))
    heavy, light = np.maximum(1.0 + off.mass * normal[:2], 0.01)
    threads = (request.heavy_thread_m, request.light_thread_m)
    heavy_thread, light_thread = (
        np.maximum(thread_m + off.thread_m * part, 0.1 * thread_m)
        for thread_m, part in zip(threads, normal[4:], strict=True)
    )
    bodies, wall = _restitutions(request, even)
    return ManySetups.of(
        mass_ratio=request.mass_ratio * heavy / light,
        wall_gap_m=np.maximum(request.gap_m + off.gap_m * normal[2], LEAST_GAP_M),
        release_m=np.maximum(request.release_m + off.release_m * normal[3], LEAST_GAP_M),
        heavy_thread_m=heavy_thread,
        light_thread_m=light_thread,
        damping_per_s=request.damping_per_s,
        restitution_bodies=bodies,
        restitution_wall=wall,
        restitution_sd=off.scatter,
        seed=rng.integers(2**62, size=trials),
    )


def restitution_range(request: PlanRequest) -> tuple[float, float]:
    """Range in which the restitution lies from trial to trial."""
    high = min(1.0, request.restitution + request.tolerances.restitution / 2)
    return max(0.0, high - request.tolerances.restitution), high


def _restitutions(request: PlanRequest, even: Floats) -> Floats:
    """Restitution of both contacts, evenly over the range of the tolerance, shape (2, trials)."""
    low, high = restitution_range(request)
    return np.asarray(low + (high - low) * even)


def spread_of(request: PlanRequest, theory: int) -> Spread:
    """Simulate the distribution of counts; mean and deviations are NaN where there are none."""
    trials = int(np.clip(MOST_EVENTS // max(theory, 1), FEWEST_TRIALS, SPREAD_TRIALS))
    drawn = drawn_setups(request, trials, (request.seed, _STREAM_SPREAD))
    found = simulate_many(drawn, most_collisions(theory))
    counts = found.count[~found.endless]
    means, deviations = _tables(counts, request)
    return Spread(
        trials=trials,
        histogram=_histogram(counts),
        endless_share=float(np.mean(found.endless)),
        mean=float(counts.mean()) if counts.size else math.nan,
        sd=float(counts.std()) if counts.size else math.nan,
        theory_share=float(np.mean(found.count == theory)),
        table_trials=request.trials,
        table_mean=_between(means),
        table_sd=_between(deviations),
    )


def _tables(counts: Whole, request: PlanRequest) -> tuple[Floats, Floats]:
    """Means and standard deviations of tables drawn from the counts, shape (tables,) each."""
    number = max(FEWEST_TABLES, min(TABLES, MOST_DRAWN // request.trials))
    if not counts.size:
        return np.full(number, math.nan), np.full(number, math.nan)
    rng = np.random.default_rng([request.seed, _STREAM_GROUPS])
    tables = counts[rng.integers(len(counts), size=(number, request.trials))]
    return tables.mean(axis=1), tables.std(axis=1)


def table_of(request: PlanRequest, theory: int) -> TrialTable:
    """Simulate one table of trials."""
    drawn = drawn_setups(request, request.trials, (request.seed, _STREAM_TABLE))
    found = simulate_many(drawn, most_collisions(theory))
    counts = found.count[~found.endless].tolist()
    return TrialTable(
        trials=request.trials,
        counts=tuple(counts),
        maximum=max(counts, default=None),
        minimum=min(counts, default=None),
        mean=fmean(counts) if counts else None,
        sd_population=pstdev(counts) if counts else None,
        sd_sample=stdev(counts) if len(counts) > 1 else None,
        histogram=_histogram(np.array(counts, dtype=np.int64)),
        theory=theory,
    )


def shares_of(requests: Sequence[PlanRequest], count: int, trials: int) -> list[float]:
    """Share of trials that give a count, for each request; the errors of the hands are the same."""
    if not requests:
        return []
    drawn = [drawn_setups(one, trials, (one.seed, _STREAM_SPREAD)) for one in requests]
    columns = {
        name: np.concatenate([getattr(setups, name) for setups in drawn])
        for name in ManySetups.__dataclass_fields__
    }
    found = simulate_many(ManySetups.of(**columns), most_collisions(count))
    counts = found.count.reshape(len(requests), trials)
    return [float(share) for share in (counts == count).mean(axis=1)]


def _between(values: Floats) -> tuple[float, float]:
    low, high = np.quantile(values, CENTRAL)
    return float(low), float(high)


def _histogram(counts: Whole) -> dict[int, int]:
    return dict(sorted(Counter(counts.tolist()).items()))

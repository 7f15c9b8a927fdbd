"""How counts scatter from trial to trial, by hands that are never alike.

Trials that are meant to be alike are simulated with the tolerances of hands: their counts make the
distribution and the table of a plan. So much is simulated as takes a second at the most: of trials
with many collisions there are fewer.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, pstdev, stdev
from typing import Any

import numpy as np

from count_video.physics.laws import Whole
from count_video.physics.setup import Setup
from count_video.physics.simulator import NO_COUNT, simulate_many, varied
from count_video.planning.request import PlanRequest, most_collisions
from count_video.records import Floats

LEAST_M = 1e-4
"""Hands that scatter do not hang the ball inside the wall."""
_STREAM_TABLE, _STREAM_SPREAD, _STREAM_GROUPS = range(3)


@dataclass(frozen=True)
class Spread:
    """Distribution of the counts of trials that are meant to be alike."""

    trials: int
    """Trials simulated; all figures but ``endless_share`` are over those with a count."""
    histogram: dict[int, int]
    endless_share: float
    """Share of the trials in which the ball comes to rest between cylinder and wall in ever smaller
    bounces, of which there is no number."""
    mean: float
    sd: float
    """Standard deviation of a count."""
    theory_share: float
    """Share of all trials that give the theory's count."""
    table_trials: int
    """Trials of a table, for which the next two hold."""
    table_mean: tuple[float, float]
    """The mean of a table lies between these in 95 of 100 tables."""
    table_sd: tuple[float, float]
    """The standard deviation (population) of a table likewise."""


@dataclass(frozen=True)
class CountFigures:
    """The figures of the paper's table for some trials; None where no trial has a count."""

    trials: int
    """All of them."""
    counted: int
    """Those with a count, of which all that follows is."""
    maximum: int | None
    minimum: int | None
    mean: float | None
    sd_population: float | None
    """Root of the mean squared deviation: divided by n. The paper's standard deviation."""
    sd_sample: float | None
    """Divided by n - 1; None for fewer than two counts."""
    histogram: Mapping[int, int]
    """How many trials had each count, from the least to the greatest."""


@dataclass(frozen=True)
class TrialTable(CountFigures):
    """A table of simulated trials."""

    counts: tuple[int, ...]
    """Counts in order; endless trials are left out."""
    theory: int


def restitution_range(request: PlanRequest) -> tuple[float, float]:
    """Range in which the restitution lies from trial to trial."""
    high = min(1.0, request.restitution + request.tolerances.restitution / 2)
    return max(0.0, high - request.tolerances.restitution), high


def spread_of(request: PlanRequest, theory: int) -> Spread:
    """Simulate the distribution of counts; mean and deviations are NaN where there are none."""
    trials = int(np.clip(250_000 // theory, 100, 2000))
    (every,) = _counts([request], trials, _STREAM_SPREAD, theory)
    counts = every[every != NO_COUNT]
    # Tables drawn from the distribution show how tables differ.
    tables = np.full((1, 1), math.nan)
    if counts.size:
        rng = np.random.default_rng([request.seed, _STREAM_GROUPS])
        number = int(np.clip(4_000_000 // request.trials, 100, 2000))
        tables = counts[rng.integers(len(counts), size=(number, request.trials))]
    return Spread(
        trials=trials,
        histogram=dict(sorted(Counter(counts.tolist()).items())),
        endless_share=float(np.mean(every == NO_COUNT)),
        mean=float(counts.mean()) if counts.size else math.nan,
        sd=float(counts.std()) if counts.size else math.nan,
        theory_share=float(np.mean(every == theory)),
        table_trials=request.trials,
        table_mean=_central(tables.mean(axis=1)),
        table_sd=_central(tables.std(axis=1)),
    )


def _central(values: Floats) -> tuple[float, float]:
    """Quantiles that hold 95 % between them."""
    low, high = np.quantile(values, (0.025, 0.975))
    return float(low), float(high)


def table_of(request: PlanRequest, theory: int) -> TrialTable:
    """Simulate one table of trials."""
    (every,) = _counts([request], request.trials, _STREAM_TABLE, theory)
    counts = every[every != NO_COUNT].tolist()
    return TrialTable(
        trials=request.trials,
        counted=len(counts),
        counts=tuple(counts),
        theory=theory,
        **count_figures(counts),
    )


def count_figures(counts: Sequence[int]) -> dict[str, Any]:
    """Work out the figures of the paper's table, by the names of their fields."""
    return {
        "maximum": max(counts, default=None),
        "minimum": min(counts, default=None),
        "mean": fmean(counts) if counts else None,
        "sd_population": pstdev(counts) if counts else None,
        "sd_sample": stdev(counts) if len(counts) > 1 else None,
        "histogram": dict(sorted(Counter(counts).items())),
    }


def shares_of(planned: Sequence[PlanRequest], count: int, trials: int) -> list[float]:
    """Share of trials that give a count, for each request; the errors of the hands are the same."""
    exact = _counts(planned, trials, _STREAM_SPREAD, count) == count
    return [float(share) for share in exact.mean(axis=1)]


def _counts(planned: Sequence[PlanRequest], trials: int, stream: int, theory: int) -> Whole:
    """Simulate so many trials of each request: counts, shape (requests, trials)."""
    drawn = [_drawn(one, trials, (one.seed, stream)) for one in planned]
    setups = [setup for some, _ in drawn for setup in some]
    seeds = [seed for _, some in drawn for seed in some]
    return simulate_many(setups, most_collisions(theory), seeds).count.reshape(-1, trials)


def _drawn(request: PlanRequest, trials: int, seed: Sequence[int]) -> tuple[list[Setup], list[int]]:
    """Draw set-ups as hands make them, and the seeds of their scatter.

    The same seed gives the same errors of the hands.
    """
    rng = np.random.default_rng(seed)
    off = request.tolerances
    normal = rng.standard_normal((6, trials))
    even = rng.uniform(size=(2, trials))
    heavy, light = np.maximum(1.0 + off.mass * normal[:2], 0.01)
    threads_m = np.array([[request.heavy_thread_m], [request.light_thread_m]])
    threads = np.maximum(threads_m + off.thread_m * normal[4:], 0.1 * threads_m)
    low, high = restitution_range(request)
    bodies, wall = low + (high - low) * even
    setups = varied(
        request.setup(),
        heavy_mass_kg=request.mass_ratio * heavy / light,
        wall_gap_m=np.maximum(request.gap_m + off.gap_m * normal[2], LEAST_M),
        release_m=np.maximum(request.release_m + off.release_m * normal[3], LEAST_M),
        heavy_thread_m=threads[0],
        light_thread_m=threads[1],
        restitution_bodies=bodies,
        restitution_wall=wall,
        restitution_bodies_sd=off.scatter,
        restitution_wall_sd=off.scatter,
    )
    return setups, rng.integers(2**62, size=trials).tolist()

"""How counts scatter: from trial to trial by hands, and over other gaps, releases and masses.

Trials that are meant to be alike are simulated with the tolerances of hands: their counts make the
distribution and the table of a plan. A change of the set-up is proposed where nearly all such
trials give the theory's count. The map has the count at every gap and release, without scatter.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from statistics import fmean, pstdev, stdev
from typing import Any, Literal

import numpy as np

from count_video.physics.laws import Whole
from count_video.physics.setup import Setup
from count_video.physics.simulator import NO_COUNT, ManyBursts, simulate, simulate_many, varied
from count_video.physics.theory import mass_ratio_interval
from count_video.planning.request import MOST_RATIO, PlanRequest, most_collisions
from count_video.records import Floats

SPREAD_TRIALS = 2000
"""Simulated trials of the distribution of counts, ..."""
SPREAD_EVENTS = 250_000
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
RESOLVED_FRAMES = 2.5
"""Collisions this far apart or farther are shown each by the frames."""
RATE_STEP_FPS = 10

HOPELESS = 0.5
"""Where bodies come to rest on each other in more trials, no gap or release will help."""
ENOUGH = 0.95
"""Share of the trials that is to give the theory's count, ..."""
PROPOSAL_TRIALS, FEWEST_PROPOSAL_TRIALS = 100, 20
"""... of so many simulated ones at each candidate, ..."""
FEWEST_VALUES = 5
"""... of which there are at least so many ..."""
PROPOSAL_EVENTS = 150_000
"""... unless the trials of one search would have more collisions together than this."""
GAPS_M = (0.005, 0.100)
RELEASES_M = (0.020, 0.200)
"""Ends of the map, and of what is proposed."""
GAP_STEP_M, RELEASE_STEP_M = 0.001, 0.005
"""Steps of what is proposed."""
CLAY_SHARE, CLAY_STEP = 0.10, 0.01
"""Clay is tried up to this share of the cylinder's mass, in these steps."""
CELLS = (96, 91)
"""Cells of the map along gap and release: a millimetre by two millimetres."""
MAP_EVENTS = 1_000_000
"""Collisions that all cells may have together; where they would have more, cells get larger."""

Change = Literal["gap", "release", "heavy mass"]


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
    """Trials of a table, for which the next three hold."""
    table_mean: tuple[float, float]
    """The mean of a table lies between these in 95 of 100 tables."""
    table_sd: tuple[float, float]
    """The standard deviation (population) of a table likewise."""


@dataclass(frozen=True)
class TrialTable:
    """A table of simulated trials, with the figures of the paper's table."""

    trials: int
    counts: tuple[int, ...]
    """Counts in order; endless trials are left out."""
    maximum: int | None
    """This and the figures below are None where no trial has a count."""
    minimum: int | None
    mean: float | None
    sd_population: float | None
    sd_sample: float | None
    histogram: dict[int, int]
    theory: int


@dataclass(frozen=True)
class Proposal:
    """One change that gives the theory's count with a safe margin."""

    change: Change
    value: float
    """The new gap or release in metres; of the mass, what is added to it in the unit given."""
    share: float
    """Share of simulated trials that then give the theory's count."""
    rate_needed_fps: float
    """Rate at which a camera then sees every collision."""


@dataclass(frozen=True)
class Chart:
    """Cells of the map; the arrays of cells have shape (releases, gaps)."""

    gap_m: Floats
    """Centres of the cells, shape (gaps,)."""
    release_m: Floats
    """Centres of the cells, shape (releases,)."""
    count: Whole
    """Collisions; ``NO_COUNT`` where the gap is larger than the release, which is not simulated, or
    where bodies come to rest on each other in ever smaller bounces."""
    shortest_s: Floats
    """Shortest time from one collision to the next; NaN where there is no count."""


def rate_needed_fps(shortest_s: float) -> float:
    """Rate at which collisions this far apart are seen one by one, in steps of ten; at least 10."""
    if shortest_s == math.inf:
        return float(RATE_STEP_FPS)
    return float(RATE_STEP_FPS * math.ceil(RESOLVED_FRAMES / shortest_s / RATE_STEP_FPS))


def drawn_setups(
    request: PlanRequest, trials: int, seed: Sequence[int]
) -> tuple[list[Setup], list[int]]:
    """Draw set-ups as hands make them, and the seeds of their scatter.

    The same seed gives the same errors of the hands.
    """
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
    low, high = restitution_range(request)
    bodies, wall = low + (high - low) * even
    setups = varied(
        request.setup(),
        heavy_mass_kg=request.mass_ratio * heavy / light,
        wall_gap_m=np.maximum(request.gap_m + off.gap_m * normal[2], LEAST_GAP_M),
        release_m=np.maximum(request.release_m + off.release_m * normal[3], LEAST_GAP_M),
        heavy_thread_m=heavy_thread,
        light_thread_m=light_thread,
        restitution_bodies=bodies,
        restitution_wall=wall,
        restitution_bodies_sd=off.scatter,
        restitution_wall_sd=off.scatter,
    )
    return setups, rng.integers(2**62, size=trials).tolist()


def restitution_range(request: PlanRequest) -> tuple[float, float]:
    """Range in which the restitution lies from trial to trial."""
    high = min(1.0, request.restitution + request.tolerances.restitution / 2)
    return max(0.0, high - request.tolerances.restitution), high


def spread_of(request: PlanRequest, theory: int) -> Spread:
    """Simulate the distribution of counts; mean and deviations are NaN where there are none."""
    trials = int(np.clip(SPREAD_EVENTS // max(theory, 1), FEWEST_TRIALS, SPREAD_TRIALS))
    found = _simulated(request, trials, _STREAM_SPREAD, theory)
    counts = found.count[~found.endless]
    means, deviations = _tables(counts, request)
    return Spread(
        trials=trials,
        histogram=dict(sorted(Counter(counts.tolist()).items())),
        endless_share=float(np.mean(found.endless)),
        mean=float(counts.mean()) if counts.size else math.nan,
        sd=float(counts.std()) if counts.size else math.nan,
        theory_share=float(np.mean(found.count == theory)),
        table_trials=request.trials,
        table_mean=_between(means),
        table_sd=_between(deviations),
    )


def _simulated(request: PlanRequest, trials: int, stream: int, theory: int) -> ManyBursts:
    setups, seeds = drawn_setups(request, trials, (request.seed, stream))
    return simulate_many(setups, most_collisions(theory), seeds)


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
    found = _simulated(request, request.trials, _STREAM_TABLE, theory)
    counts = found.count[~found.endless].tolist()
    return TrialTable(request.trials, tuple(counts), theory=theory, **count_figures(counts))


def count_figures(counts: Sequence[int]) -> dict[str, Any]:
    """Work out the figures of the paper's table, by the names of the fields of ``TrialTable``."""
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
    if not planned:
        return []
    drawn = [drawn_setups(one, trials, (one.seed, _STREAM_SPREAD)) for one in planned]
    setups, seeds = (list(chain.from_iterable(part)) for part in zip(*drawn, strict=True))
    found = simulate_many(setups, most_collisions(count), seeds)
    counts = found.count.reshape(len(planned), trials)
    return [float(share) for share in (counts == count).mean(axis=1)]


def _between(values: Floats) -> tuple[float, float]:
    low, high = np.quantile(values, CENTRAL)
    return float(low), float(high)


def chart_of(request: PlanRequest, theory: int) -> Chart:
    """Simulate every cell of the map."""
    share = min(1.0, float(np.sqrt(MAP_EVENTS / (math.prod(CELLS) * theory))))
    gaps, releases = (
        np.linspace(*ends, max(12, round(share * cells)))
        for ends, cells in zip((GAPS_M, RELEASES_M), CELLS, strict=True)
    )
    release, gap = np.meshgrid(releases, gaps, indexing="ij")
    possible = gap <= release
    setups = varied(request.setup(), wall_gap_m=gap[possible], release_m=release[possible])
    found = simulate_many(setups, most_collisions(theory))
    count = np.full(gap.shape, NO_COUNT, np.int64)
    shortest = np.full(gap.shape, np.nan)
    count[possible], shortest[possible] = found.count, found.shortest_s
    return Chart(gaps, releases, count, shortest)


def proposals(request: PlanRequest, theory: int, spread: Spread) -> tuple[Proposal, ...]:
    """Return the nearest gap, release and mass that help.

    Empty if the set-up gives the count nearly always, or loses so much that nothing will help.
    """
    if spread.theory_share >= ENOUGH or spread.endless_share > HOPELESS:
        return ()
    shortest_m = min(request.heavy_thread_m, request.light_thread_m)
    gaps = [gap for gap in _steps(GAPS_M, GAP_STEP_M) if gap <= request.release_m]
    releases = _steps(RELEASES_M, RELEASE_STEP_M)
    releases = [release for release in releases if request.gap_m <= release < shortest_m]
    candidates: dict[Change, list[float]] = {
        "gap": _giving(request, theory, "gap", gaps),
        "release": _giving(request, theory, "release", releases),
        "heavy mass": _masses(request, theory),
    }
    found = (_nearest(request, theory, *one) for one in candidates.items())
    return tuple(proposal for proposal in found if proposal is not None)


def changed(request: PlanRequest, change: Change, value: float) -> PlanRequest:
    """Return the request with another gap or release, or with so much added to the heavy mass."""
    if change == "heavy mass":
        return replace(request, heavy=float(request.heavy) + value)
    return replace(request, **{f"{change}_m": value})  # type: ignore[arg-type]


def _nearest(
    request: PlanRequest, theory: int, change: Change, values: Sequence[float]
) -> Proposal | None:
    """Return the first of some values, which come by their distance, that helps."""
    values = values[: max(FEWEST_VALUES, PROPOSAL_EVENTS // (theory * FEWEST_PROPOSAL_TRIALS))]
    trials = PROPOSAL_EVENTS // (theory * max(1, len(values)))
    trials = max(FEWEST_PROPOSAL_TRIALS, min(PROPOSAL_TRIALS, trials))
    shares = shares_of([changed(request, change, value) for value in values], theory, trials)
    for value, share in zip(values, shares, strict=True):
        if share >= ENOUGH:
            shortest_s = simulate(changed(request, change, value).setup()).shortest_s
            return Proposal(change, value, share, rate_needed_fps(shortest_s))
    return None


def _steps(ends: tuple[float, float], step: float) -> list[float]:
    return [step * number for number in range(round(ends[0] / step), round(ends[1] / step) + 1)]


def _giving(
    request: PlanRequest, theory: int, change: Literal["gap", "release"], values: Sequence[float]
) -> list[float]:
    """Lengths at which a trial without scatter gives the theory's count, the nearest first."""
    if not values:
        return []
    now_m = getattr(request, f"{change}_m")
    setups = varied(request.setup(), **{"wall_gap_m" if change == "gap" else "release_m": values})
    counts = simulate_many(setups, most_collisions(theory)).count
    good = [value for value, count in zip(values, counts, strict=True) if count == theory]
    return sorted(good, key=lambda value: abs(value - now_m))


def _masses(request: PlanRequest, theory: int) -> list[float]:
    """Clay for the cylinder, the least first; taken away where it is negative.

    The theory's count must stay: what a count says about pi hangs on the masses.
    """
    heavy, light = float(request.heavy), float(request.light)
    added = [
        sign * step * CLAY_STEP * heavy
        for step in range(1, round(CLAY_SHARE / CLAY_STEP) + 1)
        for sign in (1, -1)
    ]
    low, high = mass_ratio_interval(theory)
    ratios = [(heavy + value) / light for value in added]
    return [
        value
        for value, ratio in zip(added, ratios, strict=True)
        if low < ratio <= high and 1 <= ratio <= MOST_RATIO
    ]

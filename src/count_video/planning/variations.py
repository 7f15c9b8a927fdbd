"""Counts of trials that differ from the planned one: by hands, or by another set-up.

Trials that are meant to be alike are simulated with the tolerances of hands: their counts make the
distribution and the table of a plan. So much is simulated as takes a second at the most: of trials
with many collisions there are fewer. The map has the count at every gap and release, without
scatter. A change of the set-up is proposed where nearly all trials give the theory's count, with
the tolerances of hands.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from statistics import fmean, pstdev, stdev
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.physics.laws import Whole
from count_video.physics.setup import Setup
from count_video.physics.simulator import NO_COUNT, simulate, simulate_many, varied
from count_video.physics.theory import collision_count
from count_video.planning.request import PlanRequest, most_collisions
from count_video.records import Floats, Mask

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
    theory_share: float
    """Share of all trials that give the theory's count."""
    table_trials: int
    """Trials of a table, for which the next two hold."""
    table_mean: tuple[float, float]
    """The mean of a table lies between these in 95 of 100 tables."""
    table_sd: tuple[float, float]
    """The standard deviation (population) of a table likewise."""

    @property
    def mostly_endless(self) -> bool:
        """True where most trials have no count: those of the others say nothing of a table."""
        return self.endless_share > 0.5


@dataclass(frozen=True)
class CountFigures:
    """The figures of the paper's table for some trials; None where no trial has a count."""

    trials: int
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
    known = counts if counts.size else np.array([math.nan])
    # Tables drawn from the distribution show how tables differ.
    rng = np.random.default_rng([request.seed, _STREAM_GROUPS])
    number = int(np.clip(4_000_000 // request.trials, 100, 2000))
    tables = known[rng.integers(len(known), size=(number, request.trials))]
    return Spread(
        trials=trials,
        histogram=dict(sorted(Counter(counts.tolist()).items())),
        endless_share=float(np.mean(every == NO_COUNT)),
        mean=float(known.mean()),
        sd=float(known.std()),
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
        trials=request.trials, counts=tuple(counts), theory=theory, **count_figures(counts)
    )


def count_figures(counts: Sequence[int]) -> dict[str, Any]:
    """Work out the figures of the paper's table, by the names of their fields."""
    return {
        "counted": len(counts),
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


# ---- other set-ups -----------------------------------------------------------------------------

RESOLVED_FRAMES = 2.5
"""Collisions this far apart or farther are shown each by the frames."""
ENOUGH = 0.95
"""Share of the trials that is to give the theory's count."""
GAPS_M, RELEASES_M = (0.005, 0.100), (0.020, 0.200)
"""Ends of the map, and of what is proposed."""
CLAY_STEP, CLAY_STEPS = 0.01, 10
"""Clay is added to the cylinder or taken off it in steps of this share, so many at the most."""
Change = Literal["gap", "release", "heavy mass"]


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


CHART_COLUMNS = np.dtype(
    [(name, "f8") for name in ("gap_m", "release_m", "count", "shortest_s", "rate_needed_fps")]
)
"""What the map has for each of its cells, whose centre is at the first two."""


def rate_needed_fps(shortest_s: float | Floats) -> Any:
    """Rate at which collisions this far apart are seen one by one, in steps of ten; at least 10."""
    return np.maximum(10.0, 10.0 * np.ceil(RESOLVED_FRAMES / np.asarray(shortest_s) / 10))


def chart_of(request: PlanRequest, theory: int) -> NDArray[np.void]:
    """Simulate every cell of the map: a millimetre of gap by two of release, or larger.

    Returned is a structured array, shape (releases, gaps). NaN stands where the gap is larger than
    the release, which is not simulated, or where bodies come to rest on each other in ever smaller
    bounces.
    """
    most = (96, 91)
    share = min(1.0, math.sqrt(1_000_000 / (math.prod(most) * theory)))
    gaps, releases = (
        np.linspace(*ends, max(12, round(share * cells)))
        for ends, cells in zip((GAPS_M, RELEASES_M), most, strict=True)
    )
    chart = np.empty((len(releases), len(gaps)), CHART_COLUMNS)
    chart["gap_m"], chart["release_m"] = np.meshgrid(gaps, releases)
    lengths = {"wall_gap_m": chart["gap_m"], "release_m": chart["release_m"]}
    possible = chart["gap_m"] <= chart["release_m"]
    count, chart["shortest_s"] = _cells(request, theory, possible, **lengths)
    chart["count"] = np.where(count == NO_COUNT, math.nan, count)
    chart["rate_needed_fps"] = rate_needed_fps(chart["shortest_s"])
    return chart


def adjustments_of(request: PlanRequest, theory: int) -> dict[str, Floats | Whole]:
    """Simulate what can be changed at the table: place of the ball, release, clay on the cylinder.

    They are the changes that ``proposals`` takes from. The swings are linear: counts and times hang
    on the gap over the release, not on either alone. Returned are, by their names,

    - ``gap_share``: gap over release, increasing, that of the plan among them; shape (n,);
    - ``heavy_share``: mass of the cylinder over the planned one, 1 among them; shape (m,);
    - ``theory``: exact counts of free bodies without losses, shape (m,);
    - ``count`` and ``shortest_s``, shape (m, n), as of :func:`_cells`; nothing is possible where
      the cylinder is the lighter body.
    """
    shares = np.array([1.0 + CLAY_STEP * k for k in range(-CLAY_STEPS, CLAY_STEPS + 1)])
    steps = int(np.clip(1_000_000 // (theory * len(shares)), 12, 240))
    # Narrow regions lie where the gap is small.
    scanned = np.geomspace(GAPS_M[0] / RELEASES_M[1], 1.0, steps)
    gaps = np.union1d(scanned, request.gap_m / request.release_m)
    share, gap = np.meshgrid(shares, gaps, indexing="ij")
    ratio, gap_m = request.mass_ratio * share, request.release_m * gap
    cells = _cells(request, theory, ratio >= 1.0, heavy_mass_kg=ratio, wall_gap_m=gap_m)
    free = np.array([collision_count(one) for one in (request.mass_ratio * shares).tolist()])
    axes = {"gap_share": gaps, "heavy_share": shares, "theory": free}
    return axes | dict(zip(("count", "shortest_s"), cells, strict=True))


def _cells(
    request: PlanRequest, theory: int, possible: Mask, **columns: Floats
) -> tuple[Whole, Floats]:
    """Simulate set-ups with other values of some fields, where they are possible.

    All arrays have one shape, that of the counts and shortest times that are returned: ``NO_COUNT``
    and NaN where nothing is possible, or bodies come to rest on each other in ever smaller bounces,
    and times of inf where there is one collision alone.
    """
    count = np.full(possible.shape, NO_COUNT, np.int64)
    shortest_s = np.full(possible.shape, np.nan)
    named = {name: values[possible] for name, values in columns.items()}
    found = simulate_many(varied(request.setup(), **named), most_collisions(theory))
    count[possible], shortest_s[possible] = found.count, found.shortest_s
    return count, shortest_s


def proposals(request: PlanRequest, theory: int, spread: Spread) -> tuple[Proposal, ...]:
    """Return the nearest gap, release and mass that help.

    Empty if the set-up gives the count nearly always, or if in most trials bodies come to rest on
    each other: then no gap or release will help.
    """
    if spread.theory_share >= ENOUGH or spread.mostly_endless:
        return ()
    steps = [sign * step for step in range(1, CLAY_STEPS + 1) for sign in (1, -1)]
    choices: dict[Change, list[float]] = {
        "gap": [millimetres / 1000 for millimetres in range(5, 101)],
        "release": [millimetres / 1000 for millimetres in range(20, 201, 5)],
        "heavy mass": [CLAY_STEP * step * float(request.heavy) for step in steps],
    }
    found = (_nearest(request, theory, change, values) for change, values in choices.items())
    return tuple(proposal for proposal in found if proposal is not None)


def changed(request: PlanRequest, change: Change, value: float) -> PlanRequest:
    """Return the request with another gap or release, or with so much added to the heavy mass."""
    if change == "heavy mass":
        return replace(request, heavy=float(request.heavy) + value)
    return replace(request, **{f"{change}_m": value})  # type: ignore[arg-type]


def _nearest(
    request: PlanRequest, theory: int, change: Change, values: Sequence[float]
) -> Proposal | None:
    """Return the nearest of some values with which nearly all trials give the theory's count.

    With another mass the theory itself must stay: what a count says about pi hangs on the masses.
    """
    now = {"gap": request.gap_m, "release": request.release_m}.get(change, 0.0)
    possible = []
    for value in sorted(values, key=lambda value: abs(value - now)):
        with suppress(UsageError):  # such as a gap larger than the release
            planned = changed(request, change, value)
            if collision_count(planned.heavy, planned.light) == theory:
                possible.append((value, planned))
    counts = simulate_many([one.setup() for _, one in possible], most_collisions(theory)).count
    near = [one for one, count in zip(possible, counts, strict=True) if count == theory]
    near = near[: max(5, 150_000 // (20 * theory))]
    trials = int(np.clip(150_000 // (theory * max(1, len(near))), 20, 100))
    shares = shares_of([planned for _, planned in near], theory, trials)
    for (value, planned), share in zip(near, shares, strict=True):
        if share >= ENOUGH:
            rate_fps = float(rate_needed_fps(simulate(planned.setup()).shortest_s))
            return Proposal(change, value, share, rate_fps)
    return None

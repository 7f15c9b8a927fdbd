"""What to change so that a set-up gives the theory's count with a safe margin, and is seen.

A safe margin means that trials with the tolerances of hands give that count nearly always: it is
tried out by simulating them, at each gap, release and mass that comes into question.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from count_video.physics.many import simulate_many
from count_video.physics.theory import mass_ratio_interval
from count_video.planning.burst import planned_burst, planned_motion
from count_video.planning.camera import rate_needed_fps
from count_video.planning.request import MOST_RATIO, PlanRequest, most_collisions, setups_at
from count_video.planning.tolerances import Spread, shares_of
from count_video.records import Floats

HOPELESS = 0.5
"""Where bodies come to rest on each other in more trials than this, it is for their losses."""
ENOUGH = 0.95
"""Share of the trials that is to give the theory's count, ..."""
TRIALS = 100
"""... of so many simulated ones at each candidate."""
MOST_EVENTS = 150_000
"""Collisions that the trials of one search may have together, ..."""
FEWEST_TRIALS, FEWEST_VALUES = 20, 5
"""... but for so many trials at each of so many candidates."""
GAPS_M = (0.005, 0.100)
RELEASES_M = (0.020, 0.200)
GAP_STEP_M = 0.001
RELEASE_STEP_M = 0.005
CLAY_SHARE = 0.10
CLAY_STEP = 0.01
"""Clay is tried up to this share of the cylinder's mass, in these steps."""

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


def proposals(request: PlanRequest, theory: int, spread: Spread) -> tuple[Proposal, ...]:
    """Return the nearest gap, release and mass that help.

    Empty if the set-up gives the count nearly always, or loses so much that nothing will help.
    """
    if spread.theory_share >= ENOUGH or spread.endless_share > HOPELESS:
        return ()
    found = (
        _nearest(request, "gap", _gaps(request, theory), theory),
        _nearest(request, "release", _releases(request, theory), theory),
        _nearest(request, "heavy mass", _masses(request, theory), theory),
    )
    return tuple(proposal for proposal in found if proposal is not None)


def _nearest(
    request: PlanRequest, change: Change, values: Sequence[float], theory: int
) -> Proposal | None:
    """Return the first of some values, which come by their distance, that helps."""
    values = values[: max(FEWEST_VALUES, MOST_EVENTS // (theory * FEWEST_TRIALS))]
    trials = max(FEWEST_TRIALS, min(TRIALS, MOST_EVENTS // (theory * max(1, len(values)))))
    shares = shares_of([_CHANGED[change](request, value) for value in values], theory, trials)
    for value, share in zip(values, shares, strict=True):
        if share >= ENOUGH:
            better = _CHANGED[change](request, value)
            shortest_s = planned_burst(better, planned_motion(better)).shortest_s
            return Proposal(change, value, share, rate_needed_fps(shortest_s))
    return None


def changed(request: PlanRequest, proposal: Proposal) -> PlanRequest:
    """Return the request with a proposal taken up."""
    return _CHANGED[proposal.change](request, proposal.value)


def _with_clay(request: PlanRequest, value: float) -> PlanRequest:
    return replace(request, heavy=float(request.heavy) + value)


_CHANGED: dict[Change, Callable[[PlanRequest, float], PlanRequest]] = {
    "gap": lambda request, value: replace(request, gap_m=value),
    "release": lambda request, value: replace(request, release_m=value),
    "heavy mass": _with_clay,
}


def _gaps(request: PlanRequest, theory: int) -> list[float]:
    """Gaps at which a trial without scatter gives the count, the nearest first."""
    whole = range(round(GAPS_M[0] / GAP_STEP_M), round(GAPS_M[1] / GAP_STEP_M) + 1)
    gaps = np.array([step * GAP_STEP_M for step in whole])
    gaps = gaps[gaps <= request.release_m]
    good = gaps[_gives(request, theory, gaps, np.full_like(gaps, request.release_m))]
    return _nearest_first(good, request.gap_m)


def _releases(request: PlanRequest, theory: int) -> list[float]:
    """Releases at which a trial without scatter gives the count, the nearest first."""
    whole = range(round(RELEASES_M[0] / RELEASE_STEP_M), round(RELEASES_M[1] / RELEASE_STEP_M) + 1)
    releases = np.array([step * RELEASE_STEP_M for step in whole])
    shortest_m = min(request.heavy_thread_m, request.light_thread_m)
    releases = releases[(releases >= request.gap_m) & (releases < shortest_m)]
    good = releases[_gives(request, theory, np.full_like(releases, request.gap_m), releases)]
    return _nearest_first(good, request.release_m)


def _gives(request: PlanRequest, theory: int, gaps: Floats, releases: Floats) -> NDArray[np.bool_]:
    """Whether each gap with its release, shape (n,), gives the theory's count."""
    if not gaps.size:
        return np.zeros(0, dtype=bool)
    counts = simulate_many(setups_at(request, gaps, releases), most_collisions(theory)).count
    return np.asarray(counts == theory)


def _nearest_first(values_m: Floats, now_m: float) -> list[float]:
    return sorted(values_m.tolist(), key=lambda value: abs(value - now_m))


def _masses(request: PlanRequest, theory: int) -> list[float]:
    """Clay for the cylinder, the least first; taken away where it is negative.

    The theory's count must stay: what a count says about pi hangs on the masses.
    """
    steps = range(1, math.floor(CLAY_SHARE / CLAY_STEP + 0.5) + 1)
    heavy = float(request.heavy)
    added = [sign * step * CLAY_STEP * heavy for step in steps for sign in (1, -1)]
    least, most = mass_ratio_interval(theory)
    light = float(request.light)
    kept = [value for value in added if least < (heavy + value) / light <= most]
    return [value for value in kept if 1 <= (heavy + value) / light <= MOST_RATIO]

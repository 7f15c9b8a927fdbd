"""The map: counts and rates over gap and release, with everything else as planned.

The pendulums are linear, so both hang on the ratio of gap and release alone: regions of one count
are wedges that meet at the origin. Each cell is simulated all the same, at its centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.physics.many import NO_COUNT, simulate_many
from count_video.physics.swings import Whole
from count_video.planning.request import PlanRequest, most_collisions, setups_at
from count_video.records import Floats

GAPS_M = (0.005, 0.100, 96)
RELEASES_M = (0.020, 0.200, 91)
"""First and last cell, and how many: a millimetre by two millimetres."""
MOST_EVENTS = 1_000_000
"""Collisions that all cells may have together; where they would have more, cells get larger."""


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


def chart_of(request: PlanRequest, theory: int) -> Chart:
    """Simulate every cell of the map."""
    share = min(1.0, float(np.sqrt(MOST_EVENTS / (GAPS_M[2] * RELEASES_M[2] * theory))))
    gaps, releases = (
        np.linspace(first, last, max(12, round(share * cells)))
        for first, last, cells in (GAPS_M, RELEASES_M)
    )
    release, gap = np.meshgrid(releases, gaps, indexing="ij")
    possible = gap <= release
    found = simulate_many(
        setups_at(request, gap[possible], release[possible]), most_collisions(theory)
    )
    count = np.full(gap.shape, NO_COUNT, np.int64)
    shortest = np.full(gap.shape, np.nan)
    count[possible], shortest[possible] = found.count, found.shortest_s
    return Chart(gaps, releases, count, shortest)

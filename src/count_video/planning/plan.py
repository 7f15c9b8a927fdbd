"""The plan as a whole, from a request: the answer, how sure it is, what to change, and the map."""

from __future__ import annotations

from dataclasses import dataclass

from count_video.physics.simulator import Motion
from count_video.planning.forecast import (
    CameraView,
    Framing,
    PlannedBurst,
    camera_view,
    framing_of,
    planned_burst,
    planned_motion,
)
from count_video.planning.request import PlanRequest
from count_video.planning.spread import (
    Chart,
    Proposal,
    Spread,
    TrialTable,
    chart_of,
    proposals,
    spread_of,
    table_of,
)
from count_video.progress import NO_PROGRESS, Progress


@dataclass(frozen=True)
class Plan:
    """What a planned set-up will count, how sure that is, and what a camera sees of it."""

    request: PlanRequest
    burst: PlannedBurst
    framing: Framing
    camera: CameraView | None
    """None where no rate was given."""
    spread: Spread
    proposals: tuple[Proposal, ...]
    """What to change for the theory's count with a safe margin; empty if nothing, or if nothing
    helps (``spread`` says which)."""
    table: TrialTable | None
    """None where no table was asked for."""
    chart: Chart | None
    """None where no map was asked for."""
    motion: Motion
    """The simulated trial itself."""


def make_plan(
    request: PlanRequest,
    *,
    with_table: bool = True,
    with_chart: bool = True,
    progress: Progress = NO_PROGRESS,
) -> Plan:
    """Work out a plan; a second or two, most of it for tolerances and map."""
    progress.start(3 + with_table + with_chart, "planning")
    motion = planned_motion(request)
    burst = planned_burst(request, motion)
    framing = framing_of(request, burst)
    progress.advance(1)
    spread = spread_of(request, burst.theory)
    progress.advance(1)
    changes = proposals(request, burst.theory, spread)
    progress.advance(1)
    table = table_of(request, burst.theory) if with_table else None
    progress.advance(int(with_table))
    chart = chart_of(request, burst.theory) if with_chart else None
    progress.finish()
    return Plan(
        request=request,
        burst=burst,
        framing=framing,
        camera=camera_view(request, burst, framing),
        spread=spread,
        proposals=changes,
        table=table,
        chart=chart,
        motion=motion,
    )

"""A plan for a program: one JSON object, which is also what a counted clip is held against."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, fields
from typing import Any

from count_video.planning.burst import PlannedBurst
from count_video.planning.camera import CameraView
from count_video.planning.stored import PLAN_VERSION, request_object
from count_video.planning.tolerances import Spread, TrialTable
from count_video.planning.whole import Plan
from count_video.records import PlanComparison


def plan_line(plan: Plan) -> str:
    """Write the plan as one line of JSON, without the line's end."""
    return json.dumps(plan_object(plan), allow_nan=False)


def plan_object(plan: Plan) -> dict[str, object]:
    """Turn a plan into what ``json.dumps`` takes; the map is in its own table."""
    return {
        "plan_version": PLAN_VERSION,
        "request": request_object(plan.request),
        **_burst(plan.burst),
        **_finite(asdict(plan.framing)),
        "camera": None if plan.camera is None else _camera(plan.camera),
        "spread": _spread(plan.spread),
        "proposals": [asdict(proposal) for proposal in plan.proposals],
        "table": None if plan.table is None else _table(plan.table),
    }


def comparison_object(comparison: PlanComparison | None) -> dict[str, object] | None:
    """Turn the comparison of a clip with its plan into what ``json.dumps`` takes."""
    if comparison is None:
        return None
    return {
        "planned_count": comparison.planned_count,
        "theory": comparison.theory,
        "found_count": comparison.found_count,
        "quantities": [
            {
                "name": one.name,
                "planned": _number(one.planned),
                "found": _number(one.found.value),
                "sigma": _number(one.found.sigma),
                "count": one.count,
            }
            for one in comparison.quantities
        ],
        "explained_by": list(comparison.explained_by),
    }


def _burst(burst: PlannedBurst) -> dict[str, object]:
    values: dict[str, Any] = {field.name: getattr(burst, field.name) for field in fields(burst)}
    intervals = values.pop("intervals_s")
    return {**_finite(values), "intervals_s": list(intervals)}


def _camera(camera: CameraView) -> dict[str, object]:
    measured = camera.measured
    return {
        **_finite({**asdict(camera), "measured": None}),
        "chance": None if measured is None else measured.chance,
        "measured": None if measured is None else asdict(measured),
    }


def _spread(spread: Spread) -> dict[str, object]:
    return {
        **_finite(asdict(spread)),
        "histogram": {str(count): number for count, number in spread.histogram.items()},
        "table_mean": [_number(end) for end in spread.table_mean],
        "table_sd": [_number(end) for end in spread.table_sd],
    }


def _table(table: TrialTable) -> dict[str, object]:
    return {
        **asdict(table),
        "counts": list(table.counts),
        "histogram": {str(count): number for count, number in table.histogram.items()},
    }


def _finite(values: dict[str, Any]) -> dict[str, object]:
    """Replace what JSON does not have by null."""
    return {
        name: _number(value) if isinstance(value, float) else value
        for name, value in values.items()
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None

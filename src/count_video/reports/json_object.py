"""Results, plans and campaigns for a program: JSON objects with stable keys.

What is not known is ``null``; NaN and infinity, which JSON does not have, become ``null`` too.
A key is never left out, whatever became of the clip. Keys may be added; when one is renamed,
removed or changes its meaning, ``SCHEMA_VERSION`` grows.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from count_video.planning.request import PLAN_VERSION, request_object
from count_video.records import TrialResult, Velocities
from count_video.reports.words import storable

if TYPE_CHECKING:
    from count_video.planning.plan import Plan

SCHEMA_VERSION = 1
SIGNIFICANT_DIGITS = 12
"""More than any measurement has, fewer than rounding errors show in."""
_NAMES = {
    "setup": "fitted_setup",
    "velocity_before": "velocity_before_px_frame",
    "velocity_after": "velocity_after_px_frame",
    **{name: name.removesuffix("_px_frame") for name in Velocities.__dataclass_fields__},
}
"""Keys that are not called as the field of the record is."""
_KEYS = (
    *("schema_version", "clip", "status", "reason", "count", "seen", "between_frames"),
    *("probability", "count_after_burst", "collisions", "capture_fps", "capture_fps_source"),
    *("frames_decoded", "frames_promised"),
    *("wall_side", "upright", "ball_diameter_px", "millimetres_per_px"),
    *("pi_low", "pi_high", "mass_ratio", "mass_ratio_sigma", "energy_kept", "restitution"),
    *("ending", "fitted_setup", "warnings", "reviewed_count", "corrections", "notes", "plan"),
)
"""Keys of a result, in the order in which one reads."""


def plain(value: Any) -> Any:
    """Turn records, arrays and mappings into what ``json.dumps`` takes."""
    if is_dataclass(value):
        return {_NAMES.get(f.name, f.name): plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(value[key]) for key in sorted(value)}
    if isinstance(value, tuple | list):
        return [plain(one) for one in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float | Fraction):
        number = float(value)
        return float(f"{number:.{SIGNIFICANT_DIGITS}g}") if math.isfinite(number) else None
    return storable(value) if isinstance(value, str) else value


def json_line(result: TrialResult) -> str:
    """Write the result as one line of JSON in plain ASCII, without the line's end."""
    return json.dumps(json_object(result), allow_nan=False)


def json_object(result: TrialResult) -> dict[str, object]:
    """Turn the result into what ``json.dumps`` takes; the keys are in reading order."""
    values = plain(result)
    restitution = {kind: values[f"restitution_{kind}"] for kind in ("bodies", "wall")}
    compared = values["comparison"]
    for one in compared["quantities"] if compared else ():
        found = one.pop("found")
        one |= {"found": found["value"], "sigma": found["sigma"]}
    values |= {
        "schema_version": SCHEMA_VERSION,
        "energy_kept": values["energy_kept"] or None,
        "restitution": restitution if any(restitution.values()) else None,
        "plan": compared,
    }
    return {key: values[key] for key in _KEYS}


def plan_object(plan: Plan) -> dict[str, object]:
    """Turn a plan into what ``json.dumps`` takes; the map is in its own table."""
    camera = plain(plan.camera)
    if plan.camera is not None:
        camera["chance"] = plain(getattr(plan.camera.measured, "chance", None))
    return {
        "plan_version": PLAN_VERSION,
        "request": request_object(plan.request),
        **plain(plan.burst),
        **plain(plan.framing),
        "camera": camera,
        "spread": plain(plan.spread),
        "proposals": plain(plan.proposals),
        "table": plain(plan.table),
    }

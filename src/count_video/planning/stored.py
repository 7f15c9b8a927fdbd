"""A plan's request as JSON, so that a counted clip can be held against it later."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from count_video.errors import UsageError
from count_video.inputs import (
    CAPTURE_RATE,
    DAMPING,
    LENGTH,
    MASS,
    MOST_PLAN_BYTES,
    SEED,
    SHARE,
    TOLERANCES,
    TRIALS,
    Range,
    read_json_object,
    shown,
    stored_number,
)
from count_video.planning.request import PlanRequest, Tolerances

PLAN_VERSION = 1
_REQUEST = {
    **dict.fromkeys(("heavy", "light"), MASS),
    **dict.fromkeys(("gap_m", "release_m", "heavy_thread_m", "light_thread_m"), LENGTH),
    "ball_diameter_m": LENGTH,
    "capture_fps": CAPTURE_RATE,
    "restitution": SHARE,
    "damping_per_s": DAMPING,
    "trials": TRIALS,
    "seed": SEED,
}
_TOLERANCES = dict(TOLERANCES.values())
_WHOLE = ("trials", "seed")


def request_object(request: PlanRequest) -> dict[str, Any]:
    """Turn a request into what ``json.dumps`` takes."""
    return {
        **asdict(request),
        "heavy": float(request.heavy),
        "light": float(request.light),
        "tolerances": asdict(request.tolerances),
    }


def read_request(path: Path) -> PlanRequest:
    """Read the request of a stored plan.

    Raises
    ------
    UsageError
        If the file cannot be read, is no plan, or has a value that makes no sense.
    """
    stored = _stored(path)
    values = stored.get("request")
    if not isinstance(values, dict):
        raise UsageError(f"{path}: has no planned set-up; make the file again with --plan")
    try:
        tolerances = Tolerances(**_numbers(values.get("tolerances", {}), _TOLERANCES))
        rest = {key: value for key, value in values.items() if key != "tolerances"}
        return PlanRequest(**_numbers(rest, _REQUEST), tolerances=tolerances)
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from error
    except TypeError as error:
        raise UsageError(f"{path}: lacks a mass; make the file again with --plan") from error


def _stored(path: Path) -> dict[str, Any]:
    stored = read_json_object(path, MOST_PLAN_BYTES)
    if stored.get("plan_version") != PLAN_VERSION:
        raise UsageError(
            f"{path}: is no plan, version {PLAN_VERSION}; give the plan.json that --plan wrote"
        )
    return stored


def _numbers(values: object, ranges: Mapping[str, Range]) -> dict[str, Any]:
    """Check that an object holds, under names of fields, numbers within their ranges."""
    if not isinstance(values, dict):
        raise UsageError(f"{shown(str(values))} is no object with the values of a plan")
    for name, value in values.items():
        allowed = ranges.get(name)
        if allowed is None:
            raise UsageError(f"{shown(name)} is nothing that a plan has")
        absent = value is None and name == "capture_fps"
        whole = name not in _WHOLE or isinstance(value, int)
        if not absent and (stored_number(value, allowed) is None or not whole):
            raise UsageError(f"{name} is {shown(str(value))}; it must be a number {allowed}")
    return dict(values)

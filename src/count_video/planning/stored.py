"""A plan's request as JSON, so that a counted clip can be held against it later."""

from __future__ import annotations

import json
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from count_video.errors import UsageError
from count_video.planning.request import PlanRequest, Tolerances

PLAN_VERSION = 1
MOST_BYTES = 10_000_000
"""A larger file is not a plan."""
_COUNTS = ("trials", "seed")


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
        tolerances = Tolerances(**_numbers(values.get("tolerances", {}), Tolerances))
        rest = {key: value for key, value in values.items() if key != "tolerances"}
        return PlanRequest(**_numbers(rest, PlanRequest), tolerances=tolerances)
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from error
    except TypeError as error:
        raise UsageError(f"{path}: lacks a mass; make the file again with --plan") from error


def _stored(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file:
            text = file.read(MOST_BYTES + 1)
        stored = json.loads(text) if len(text) <= MOST_BYTES else None
    except OSError as error:
        raise UsageError(f"{path}: cannot read the plan: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{path}: is no JSON; give the plan.json that --plan wrote") from error
    if not isinstance(stored, dict) or stored.get("plan_version") != PLAN_VERSION:
        raise UsageError(
            f"{path}: is no plan, version {PLAN_VERSION}; give the plan.json that --plan wrote"
        )
    return stored


def _numbers(values: object, kind: type[PlanRequest] | type[Tolerances]) -> dict[str, Any]:
    """Check that an object holds numbers under the names of a record's fields."""
    known = {field.name for field in fields(kind)}
    if not isinstance(values, dict):
        raise UsageError(f"{values!r} is no object with the values of a plan")
    for name, value in values.items():
        if name not in known:
            raise UsageError(f"{name!r} is nothing that a plan has")
        absent = value is None and name == "capture_fps"
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (absent or number) or (name in _COUNTS and not isinstance(value, int)):
            raise UsageError(f"{name} is {value!r}; it must be a number")
    return dict(values)

"""The result for a program: one JSON object on one line, with stable keys.

What is not known is ``null``; NaN and infinity, which JSON does not have, become ``null`` too.
A key is never left out, whatever became of the clip. Keys may be added; when one is renamed,
removed or changes its meaning, ``SCHEMA_VERSION`` grows.
"""

from __future__ import annotations

import json
import math
from dataclasses import fields

from count_video.records import (
    Collision,
    Correction,
    Ending,
    Estimate,
    FittedSetup,
    TrialResult,
    Velocities,
)
from count_video.reports.plan_json import comparison_object
from count_video.reports.printable import storable

SCHEMA_VERSION = 1


def json_line(result: TrialResult) -> str:
    """Write the result as one line of JSON in plain ASCII, without the line's end."""
    return json.dumps(json_object(result), allow_nan=False)


def json_object(result: TrialResult) -> dict[str, object]:
    """Turn the result into what ``json.dumps`` takes; the keys are in reading order."""
    return {
        "schema_version": SCHEMA_VERSION,
        "clip": storable(result.clip),
        "status": result.status,
        "reason": None if result.reason is None else storable(result.reason),
        "count": _whole(result.count),
        "seen": _whole(result.seen),
        "between_frames": _whole(result.between_frames),
        "probability": {
            str(count): _number(chance) for count, chance in sorted(result.probability.items())
        },
        "count_after_burst": _whole(result.count_after_burst),
        "collisions": [_collision(collision) for collision in result.collisions],
        "capture_fps": _number(result.capture_fps),
        "capture_fps_source": result.capture_fps_source,
        "frames_decoded": _whole(result.frames_decoded),
        "frames_promised": _whole(result.frames_promised),
        "wall_side": result.wall_side,
        "ball_diameter_px": _number(result.ball_diameter_px),
        "millimetres_per_px": _number(result.millimetres_per_px),
        "pi_low": _number(result.pi_low),
        "pi_high": _number(result.pi_high),
        "mass_ratio": _number(result.mass_ratio),
        "mass_ratio_sigma": _number(result.mass_ratio_sigma),
        "energy_kept": [_number(share) for share in result.energy_kept] or None,
        "restitution": _restitution(result),
        "ending": _ending(result.ending),
        "fitted_setup": _setup(result.setup),
        "warnings": [storable(warning) for warning in result.warnings],
        "reviewed_count": _whole(result.reviewed_count),
        "corrections": [_correction(correction) for correction in result.corrections],
        "plan": comparison_object(result.comparison),
    }


def _collision(collision: Collision) -> dict[str, object]:
    return {
        "number": int(collision.number),
        "kind": collision.kind,
        "frame": _number(collision.frame),
        "frame_sigma": _number(collision.frame_sigma),
        "time_s": _number(collision.time_s),
        "seen": bool(collision.seen),
        "position_px": _number(collision.position_px),
        "velocity_before_px_frame": _velocities(collision.velocity_before),
        "velocity_after_px_frame": _velocities(collision.velocity_after),
    }


def _restitution(result: TrialResult) -> dict[str, object] | None:
    parts = {"bodies": result.restitution_bodies, "wall": result.restitution_wall}
    if all(part is None for part in parts.values()):
        return None
    return {contact: _estimate(part) for contact, part in parts.items()}


def _estimate(estimate: Estimate | None) -> dict[str, object] | None:
    if estimate is None:
        return None
    return {"value": _number(estimate.value), "sigma": _number(estimate.sigma)}


def _ending(ending: Ending | None) -> dict[str, object] | None:
    if ending is None:
        return None
    return {
        "kind": ending.kind,
        "energy_kept": _number(ending.energy_kept),
        "heavy_speed": _number(ending.heavy_speed),
        "ball_speed": _number(ending.ball_speed),
    }


def _setup(setup: FittedSetup | None) -> dict[str, object] | None:
    if setup is None:
        return None
    return {field.name: _estimate(getattr(setup, field.name)) for field in fields(setup)}


def _correction(correction: Correction) -> dict[str, object]:
    return {
        "action": correction.action,
        "kind": correction.kind,
        "frame": _number(correction.frame),
        "number": _whole(correction.number),
        "changes_count": bool(correction.changes_count),
    }


def _velocities(velocities: Velocities) -> dict[str, object]:
    return {
        "ball": _number(velocities.ball_px_frame),
        "heavy": _number(velocities.heavy_px_frame),
    }


def _number(value: float | None) -> float | None:
    # float() also turns NumPy's numbers, which json does not know, into Python's.
    return None if value is None or not math.isfinite(value) else float(value)


def _whole(value: int | None) -> int | None:
    return None if value is None else int(value)

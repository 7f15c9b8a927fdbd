"""Results, plans and campaigns for a program: JSON objects with stable keys, arrays, CSV tables.

What is not known is ``null``; NaN and infinity, which JSON does not have, become ``null`` too.
A key is never left out, whatever became of the clip. Keys may be added; when one is renamed,
removed or changes its meaning, ``SCHEMA_VERSION`` grows. In arrays what is not known is NaN, in
CSV an empty cell.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from count_video.planning.plan import Plan
from count_video.planning.request import PLAN_VERSION, request_object
from count_video.records import Track, TrialResult, Velocities
from count_video.reports.campaign import CampaignSummary, TrialRow
from count_video.reports.words import printable, storable
from count_video.settings import CsvDialect

SCHEMA_VERSION = 1
SIGNIFICANT_DIGITS = 12
"""More than any measurement has, fewer than rounding errors show in."""
_NAMES = {
    "setup": "fitted_setup",
    "comparison": "plan",
    "velocity_before": "velocity_before_px_frame",
    "velocity_after": "velocity_after_px_frame",
    **{name: name.removesuffix("_px_frame") for name in Velocities.__dataclass_fields__},
}
"""Keys that are not called as the field of the record is."""


def plain(value: Any) -> Any:
    """Turn records, arrays and mappings into what ``json.dumps`` takes."""
    if is_dataclass(value):
        return {_NAMES.get(f.name, f.name): plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(value[key]) for key in sorted(value)}
    if isinstance(value, tuple | list):
        return [plain(one) for one in value]
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist())
    if isinstance(value, float | Fraction):
        number = float(value)
        return float(f"{number:.{SIGNIFICANT_DIGITS}g}") if math.isfinite(number) else None
    return storable(value) if isinstance(value, str) else value


def json_line(result: TrialResult) -> str:
    """Write the result as one line of JSON in plain ASCII, without the line's end."""
    return json.dumps(json_object(result), allow_nan=False)


def json_object(result: TrialResult) -> dict[str, object]:
    """Turn the result into what ``json.dumps`` takes; the keys are in the order of its fields."""
    values = plain(result)
    for one in values["plan"]["quantities"] if values["plan"] else ():
        found = one.pop("found")
        one |= {"found": found["value"], "sigma": found["sigma"]}
    both = {"bodies": values["restitution_bodies"], "wall": values.pop("restitution_wall")}
    values["restitution_bodies"] = both if any(both.values()) else None
    values["energy_kept"] = values["energy_kept"] or None
    renamed = {"restitution_bodies": "restitution"}
    return {"schema_version": SCHEMA_VERSION} | {renamed.get(k, k): values[k] for k in values}


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


def campaign_json(rows: Sequence[TrialRow], summary: CampaignSummary) -> str:
    """Write the summary and the trials that need a person as JSON text."""
    keys = ("name", "clip", "status", "count", "probability", "reason", "what_to_do")
    need = [
        {key: plain(TRIAL_COLUMNS[key](row)) for key in keys}
        | {"reason": plain(row.not_kept or row.result.reason)}
        for row in rows
        if row.needs_a_person
    ]
    values = {"schema_version": SCHEMA_VERSION, **plain(summary.whole), "need_a_person": need}
    return json.dumps(values | {"groups": plain(summary.groups)}, indent=1, allow_nan=False) + "\n"


# ---- arrays and CSV -----------------------------------------------------------------------------

_TYPES = {"number": "i8", "kind": "U6", "seen": "?", "in_burst": "?", "quality": "U5"}
"""Types of the columns that are not float64."""
_TRACK = (
    *("frame", "time_s", "ball_px", "ball_sigma_px", "heavy_px", "heavy_sigma_px"),
    *("ball_mm", "ball_sigma_mm", "heavy_mm", "heavy_sigma_mm", "quality"),
)
_VELOCITIES = {
    f"{body}_{side}{sigma}_px_frame": (f"velocity_{side}", f"{body}{sigma}_px_frame")
    for sigma in ("", "_sigma")
    for body in ("ball", "heavy")
    for side in ("before", "after")
}
"""Columns of velocities, and the fields of a collision that they show."""
_COLLISION = (
    *("number", "kind", "seen", "in_burst", "frame", "frame_sigma", "time_s", "ball_px"),
    *_VELOCITIES,
)
TRACK_COLUMNS = np.dtype([(name, _TYPES.get(name, "f8")) for name in _TRACK])
COLLISION_COLUMNS = np.dtype([(name, _TYPES.get(name, "f8")) for name in _COLLISION])
_FORMATS = {
    **dict.fromkeys(("frame", "frame_sigma"), ".3f"),
    **{name: ".6f" for name in _VELOCITIES if "sigma" in name},
    **dict.fromkeys(("ball_mm", "ball_sigma_mm", "heavy_mm", "heavy_sigma_mm"), ".5f"),
    **dict.fromkeys(("count", "rate_needed_fps"), ".0f"),
    "time_s": ".6f",
    "shortest_s": ".6g",
}
"""How numbers are written for a spreadsheet; with 4 decimals where a column is not named."""
TRIAL_COLUMNS: Mapping[str, Callable[[TrialRow], object]] = {
    "name": lambda row: row.name,
    "clip": lambda row: storable(row.result.clip),
    "status": lambda row: row.result.status,
    "count": lambda row: row.result.count,
    "probability": lambda row: row.result.chance,
    "needs_a_person": lambda row: row.needs_a_person,
    "reason": lambda row: storable("; ".join(filter(None, (row.result.reason, row.not_kept)))),
    "what_to_do": lambda row: row.advice,
    "seen": lambda row: row.result.seen,
    "between_frames": lambda row: row.result.between_frames,
    "capture_fps": lambda row: row.result.capture_fps,
    "theory": lambda row: row.only_theory,
    "mass_ratio": lambda row: row.result.mass_ratio,
    "pi_low": lambda row: row.result.pi_low,
    "pi_high": lambda row: row.result.pi_high,
    "restitution_bodies": lambda row: getattr(row.result.restitution_bodies, "value", None),
    "restitution_wall": lambda row: getattr(row.result.restitution_wall, "value", None),
    "energy_kept": lambda row: row.result.energy_kept[-1] if row.result.energy_kept else None,
    "ending": lambda row: getattr(row.result.ending, "kind", None),
}
"""Columns of the table of trials, and what stands in them; None is an empty cell."""


def track_array(track: Track | None, result: TrialResult) -> NDArray[np.void]:
    """Return a row a frame; shape (frames,), and (0,) where no bodies could be followed.

    Positions are those along the line of motion, of the ball's centre and of the heavy body's
    face; millimetres are counted from the picture's edge like the pixels. ``quality`` says what
    the frame shows: ``both``, ``ball``, ``heavy`` or ``none``. What is not known is NaN.
    """
    if track is None:
        return np.empty(0, TRACK_COLUMNS)
    table = np.full(len(track.frame), math.nan).astype(TRACK_COLUMNS)
    table["frame"] = track.frame
    table["time_s"] = track.frame / (result.capture_fps or math.nan)
    millimetre = result.millimetres_per_px or math.nan
    for name, body in (("ball", track.ball), ("heavy", track.heavy)):
        if body is not None:
            table[f"{name}_px"], table[f"{name}_sigma_px"] = body.position_px, body.sigma_px
            table[f"{name}_mm"] = body.position_px * millimetre
            table[f"{name}_sigma_mm"] = body.sigma_px * millimetre
    ball, heavy = (np.isfinite(table[f"{name}_px"]) for name in ("ball", "heavy"))
    table["quality"] = np.select([ball & heavy, ball, heavy], ["both", "ball", "heavy"], "none")
    return table


def collisions_array(result: TrialResult) -> NDArray[np.void]:
    """Return a row a collision, those after the burst as well; shape (collisions,).

    ``in_burst`` is true for those that the count includes. Velocities and their standard
    uncertainties are px a frame along the line of motion; ``time_s`` is NaN without a capture rate.
    """
    rows = [
        (
            *(c.number, c.kind, c.seen, c.number <= result.burst_size, c.frame, c.frame_sigma),
            *(math.nan if c.time_s is None else c.time_s, c.position_px),
            *(getattr(getattr(c, side), field) for side, field in _VELOCITIES.values()),
        )
        for c in result.collisions
    ]
    return np.array(rows, COLLISION_COLUMNS)


def table_csv(table: NDArray[np.void], dialect: CsvDialect = "comma", **formats: str) -> str:
    """Write a structured array, shape (rows,), as CSV with a heading; NaN is an empty cell.

    ``formats`` are those of numbers in columns that are not written as usual.
    """
    wanted = _FORMATS | formats
    columns = {name: wanted.get(name, ".4f") for name in table.dtype.names or ()}
    return _csv(columns, table.tolist(), dialect)


def trials_csv(trials: Sequence[TrialRow], dialect: CsvDialect = "comma") -> str:
    """Write the trials of a campaign as CSV, those that need a person first.

    What is not known is an empty cell.
    """
    ordered = sorted(trials, key=lambda trial: not trial.needs_a_person)
    rows = ([value(trial) for value in TRIAL_COLUMNS.values()] for trial in ordered)
    return _csv(dict.fromkeys(TRIAL_COLUMNS, ".6g"), rows, dialect)


def _csv(columns: Mapping[str, str], rows: Iterable[Iterable[object]], dialect: CsvDialect) -> str:
    """Write rows under the names of their columns, numbers in the format of their column."""
    target = io.StringIO()
    delimiter, point = (",", ".") if dialect == "comma" else (";", ",")
    writer = csv.writer(target, delimiter=delimiter, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        cells = zip(row, columns.values(), strict=True)
        writer.writerow(_cell(value, number, point) for value, number in cells)
    return target.getvalue()


def _cell(value: object, number: str, point: str) -> str:
    """Write a value as a cell; ``number`` is the format of a float."""
    if value is None or isinstance(value, float):
        known = value is not None and math.isfinite(value)
        return f"{value:z{number}}".replace(".", point) if known else ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    text = printable(str(value))
    # A spreadsheet would run a cell that begins so as a formula; a clip's name is only text.
    return f"'{text}" if text.startswith(("=", "+", "-", "@")) else text

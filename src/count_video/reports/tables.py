"""Track, collisions and trials as tables: for NumPy, for a spreadsheet, and for a terminal."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from count_video.records import Track, TrialResult
from count_video.reports.campaign import TrialRow, advice
from count_video.reports.words import printable, storable

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
    "count": lambda row: row.count,
    "probability": lambda row: row.result.chance,
    "needs_a_person": lambda row: row.needs_a_person,
    "reason": lambda row: storable("; ".join(filter(None, (row.result.reason, row.not_kept)))),
    "what_to_do": advice,
    "seen": lambda row: row.result.seen,
    "between_frames": lambda row: row.result.between_frames,
    "capture_fps": lambda row: row.result.capture_fps,
    "theory": lambda row: row.theory,
    "mass_ratio": lambda row: row.result.mass_ratio,
    "pi_low": lambda row: row.result.pi_low,
    "pi_high": lambda row: row.result.pi_high,
    "restitution_bodies": lambda row: getattr(row.result.restitution_bodies, "value", None),
    "restitution_wall": lambda row: getattr(row.result.restitution_wall, "value", None),
    "energy_kept": lambda row: row.result.energy_kept[-1] if row.result.energy_kept else None,
    "ending": lambda row: getattr(row.result.ending, "kind", None),
}
"""Columns of the table of trials, and what stands in them; None is an empty cell."""
NOT_KNOWN = "-"


# ---- for NumPy and for a spreadsheet -----------------------------------------------------------


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


def table_csv(table: NDArray[np.void], **formats: str) -> str:
    """Write a structured array, shape (rows,), as CSV with a heading; NaN is an empty cell.

    ``formats`` are those of numbers in columns that are not written as usual.
    """
    names = table.dtype.names or ()
    wanted = [(_FORMATS | formats).get(name, ".4f") for name in names]
    return _csv(names, ([*map(_cell, row, wanted)] for row in table.tolist()))


def trials_csv(trials: Sequence[TrialRow]) -> str:
    """Write the trials of a campaign as CSV, those that need a person first.

    What is not known is an empty cell.
    """
    ordered = sorted(trials, key=lambda trial: not trial.needs_a_person)
    rows = ([_cell(value(trial), ".6g") for value in TRIAL_COLUMNS.values()] for trial in ordered)
    return _csv(TRIAL_COLUMNS, rows)


def _csv(names: Iterable[str], rows: Iterable[Sequence[str]]) -> str:
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\n")
    writer.writerow(names)
    writer.writerows(rows)
    return target.getvalue()


def _cell(value: object, number: str) -> str:
    """Write a value as a cell; ``number`` is the format of a float."""
    if value is None or isinstance(value, float):
        return f"{value:{number}}" if value is not None and math.isfinite(value) else ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    text = printable(str(value))
    # A spreadsheet would run a cell that begins so as a formula; a clip's name is only text.
    return f"'{text}" if text.startswith(("=", "+", "-", "@")) else text


# ---- for a terminal ----------------------------------------------------------------------------

_NUMBERS = (
    *(("", "frame", 9, 2, ("frame",)), ("", "time/s", 9, 5, ("time_s",))),
    ("", "ball/px", 8, 1, ("ball_px",)),
    *(
        (f"{body} px/frame", "before    after", 17, 3, names)
        for body in ("ball", "heavy")
        for names in [(f"{body}_before_px_frame", f"{body}_after_px_frame")]
    ),
)
"""Two headings of each column of numbers, its width, decimals, and the columns of the array."""


def collision_lines(result: TrialResult) -> list[str]:
    """Lay the collisions out in rows; those after the counted ones follow under a line of words.

    Columns of which nothing is known (times without a capture rate, a heavy body that is not
    there) are left out.
    """
    if not result.collisions:
        return []
    table, above, headings = collisions_array(result), " " * 15, "   no.  kind   "
    rows = [f" {c.number:>5}  {c.kind + '*' * (not c.seen):<7}" for c in result.collisions]
    for over, heading, width, decimals, names in _NUMBERS:
        values = np.array([table[name] for name in names]).T
        if np.isfinite(values).any():
            above, headings = f"{above} {over:>{width}}", f"{headings} {heading:>{width}}"
            for k, known in enumerate(values):
                numbers = (f"{v:z.{decimals}f}" if math.isfinite(v) else NOT_KNOWN for v in known)
                # A cell wider than its column keeps its gap: the numbers never touch.
                rows[k] += f" {' '.join(f'{number:>8}' for number in numbers).strip():>{width}}"
    if result.count is not None and result.count < len(rows):
        rows.insert(result.count, "  after the cylinder turned back:")
    inferred = [] if table["seen"].all() else ["  * inferred between frames"]
    return [*filter(None, [above.rstrip()]), headings, *map(str.rstrip, rows), *inferred]

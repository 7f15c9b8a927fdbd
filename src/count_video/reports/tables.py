"""Track, collisions and trials as tables: for NumPy, for a spreadsheet, and for a terminal."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.physics.simulator import NO_COUNT
from count_video.planning.spread import Chart, rate_needed_fps
from count_video.records import Track, TrialResult
from count_video.reports.campaign import TrialRow, advice
from count_video.reports.words import WIDTH, fixed, printable, storable

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


def map_csv(chart: Chart) -> str:
    """Write the map of a plan as CSV: a row a cell, lengths in metres."""
    release, gap = np.meshgrid(chart.release_m, chart.gap_m, indexing="ij")
    count = np.where(chart.count == NO_COUNT, math.nan, chart.count)
    shortest = np.where(np.isnan(count), math.nan, chart.shortest_s)
    rate = np.array([math.nan if math.isnan(s) else rate_needed_fps(s) for s in shortest.flat])
    cells = [gap.ravel(), release.ravel(), count.ravel(), shortest.ravel(), rate]
    names = ("gap_m", "release_m", "count", "shortest_s", "rate_needed_fps")
    return table_csv(np.rec.fromarrays(cells, dtype=[(name, "f8") for name in names]))


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


@dataclass(frozen=True)
class Column:
    """A column of a table of text; its cells are text already."""

    heading: str
    width: int
    """Least number of characters, the space before the column included."""
    above: str = ""
    """Heading above the heading."""
    align: str = ">"
    """``>`` for numbers, ``<`` for words."""


def text_table(
    columns: Sequence[Column], rows: Sequence[Sequence[str]], width: int = WIDTH
) -> list[str]:
    """Lay rows out in columns below their headings.

    What is wider than ``width`` goes on below, beginning with the first column again.
    """
    above, headings = [column.above for column in columns], [column.heading for column in columns]
    lines, rest = [], list(range(1, len(columns)))
    while rest:
        part = [0, rest.pop(0)]
        while rest and sum(columns[k].width for k in [*part, rest[0]]) <= width:
            part.append(rest.pop(0))
        lines.append("")
        for row in ([above] if any(above[k] for k in part) else []) + [headings, *rows]:
            # A cell wider than its column keeps its gap: the row grows, the numbers never touch.
            laid = (f" {row[k]:{columns[k].align}{columns[k].width - 1}}" for k in part)
            lines.append("".join(laid).rstrip())
    return lines[1:]


_NUMBERS = (
    (Column("frame", 10), 2, ("frame",)),
    (Column("time/s", 10), 5, ("time_s",)),
    (Column("ball/px", 9), 1, ("ball_px",)),
    *(
        (Column("before    after", 18, f"{body} px/frame"), 3, names)
        for body in ("ball", "heavy")
        for names in [(f"{body}_before_px_frame", f"{body}_after_px_frame")]
    ),
)
"""Columns of the table of collisions, their decimals, and the columns of the array in them."""


def collision_lines(result: TrialResult, width: int = WIDTH) -> list[str]:
    """Lay the collisions out in rows; those after the counted ones follow under a line of words.

    Columns of which nothing is known (times without a capture rate, a heavy body that is not
    there) are left out.
    """
    if not result.collisions:
        return []
    table = collisions_array(result)
    columns = [Column("no.", 6), Column(" kind", 9, align="<")]
    rows = [[str(c.number), f" {c.kind}{'' if c.seen else '*'}"] for c in result.collisions]
    for column, decimals, names in _NUMBERS:
        values = np.array([table[name] for name in names]).T
        if np.isfinite(values).any():
            columns.append(column)
            for row, known in zip(rows, values, strict=True):
                numbers = (fixed(v, decimals) if math.isfinite(v) else NOT_KNOWN for v in known)
                row.append(" ".join(f"{number:>8}" for number in numbers).strip())
    if result.count is not None and result.count < len(rows):
        words = " after the heavy body turned back:"
        rows.insert(result.count, [words, *[""] * (len(columns) - 1)])
    inferred = [] if table["seen"].all() else ["  * inferred between frames"]
    return text_table(columns, rows, width) + inferred

"""Track, collisions and trials as tables: for NumPy, for a spreadsheet, and for a terminal."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from count_video.physics.many import NO_COUNT
from count_video.planning.spread import Chart, rate_needed_fps
from count_video.records import Track, TrialResult
from count_video.reports.campaign import TrialRow, advice
from count_video.reports.material import scale_of
from count_video.reports.words import WIDTH, fixed, printable

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
_DECIMALS = {
    **dict.fromkeys(("frame", "frame_sigma", "ball_px"), 3),
    **dict.fromkeys(("ball_mm", "ball_sigma_mm", "heavy_mm", "heavy_sigma_mm"), 5),
    "time_s": 6,
}
"""Decimals of numbers in a spreadsheet; 4 where a column is not named."""
TRIAL_COLUMNS: Mapping[str, Callable[[TrialRow], object]] = {
    "name": lambda row: row.name,
    "clip": lambda row: row.result["clip"],
    "status": lambda row: row.result["status"],
    "count": lambda row: row.count,
    "probability": lambda row: row.probability,
    "needs_a_person": lambda row: row.needs_a_person,
    "reason": lambda row: "; ".join(filter(None, (row.result["reason"], row.not_kept))),
    "what_to_do": advice,
    "seen": lambda row: row.result["seen"],
    "between_frames": lambda row: row.result["between_frames"],
    "capture_fps": lambda row: row.figure("capture_fps"),
    "theory": lambda row: row.theory,
    "mass_ratio": lambda row: row.figure("mass_ratio"),
    "pi_low": lambda row: row.figure("pi_low"),
    "pi_high": lambda row: row.figure("pi_high"),
    "restitution_bodies": lambda row: row.figure("restitution", "bodies", "value"),
    "restitution_wall": lambda row: row.figure("restitution", "wall", "value"),
    "energy_kept": lambda row: row.figure("energy_kept"),
    "ending": lambda row: row.ending,
}
"""Columns of the table of trials, and what stands in them; None is an empty cell."""
NOT_KNOWN = "-"
INFERRED = "  * inferred between frames"


# ---- for NumPy and for a spreadsheet -----------------------------------------------------------


def track_array(track: Track | None, result: TrialResult) -> NDArray[np.void]:
    """Return a row a frame; shape (frames,), and (0,) where no bodies could be followed.

    Positions are those along the line of motion, of the ball's centre and of the heavy body's
    face; millimetres are counted from the picture's edge like the pixels. ``quality`` says what
    the frame shows: ``both``, ``ball``, ``heavy`` or ``none``. What is not known is NaN.
    """
    table = np.empty(0 if track is None else len(track.frame), TRACK_COLUMNS)
    if track is None:
        return table
    scale = scale_of(result)
    millimetre = scale.length if scale.length_unit == "mm" else math.nan
    table["frame"] = track.frame
    table["time_s"] = track.frame / (result.capture_fps or math.nan)
    for name, body in (("ball", track.ball), ("heavy", track.heavy)):
        unseen = np.full(len(table), math.nan)
        table[f"{name}_px"] = unseen if body is None else body.position_px
        table[f"{name}_sigma_px"] = unseen if body is None else body.sigma_px
        for kind in ("", "_sigma"):
            table[f"{name}{kind}_mm"] = table[f"{name}{kind}_px"] * millimetre
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


def table_csv(table: NDArray[np.void], **decimals: int) -> str:
    """Write a structured array, shape (rows,), as CSV with a heading; NaN is an empty cell.

    ``decimals`` are those of columns that need others than is usual.
    """
    names = table.dtype.names or ()
    rows = (zip(names, row, strict=True) for row in table.tolist())
    usual = _DECIMALS | decimals
    return _csv(names, ([_cell(v, f".{usual.get(name, 4)}f") for name, v in row] for row in rows))


def trials_csv(trials: Sequence[TrialRow]) -> str:
    """Write the trials of a campaign as CSV, those that need a person first.

    What is not known is an empty cell.
    """
    ordered = sorted(trials, key=lambda trial: not trial.needs_a_person)
    rows = ([_cell(value(trial), ".6g") for value in TRIAL_COLUMNS.values()] for trial in ordered)
    return _csv(TRIAL_COLUMNS, rows)


def map_csv(chart: Chart | None) -> str:
    """Write the map of a plan as CSV: a row a cell, lengths in metres."""
    rows: list[Sequence[str]] = []
    if chart is not None:
        for row, column in np.ndindex(chart.count.shape):
            count, shortest = int(chart.count[row, column]), float(chart.shortest_s[row, column])
            place = f"{chart.gap_m[column]:.4f}", f"{chart.release_m[row]:.4f}"
            if count == NO_COUNT:
                rows.append([*place, "", "", ""])
            else:
                rate = f"{rate_needed_fps(shortest):.0f}"
                rows.append([*place, str(count), _cell(shortest, ".6g"), rate])
    return _csv(("gap_m", "release_m", "count", "shortest_s", "rate_needed_fps"), rows)


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
    return f"'{text}" if text[:1] in ("=", "+", "-", "@") else text


# ---- for a terminal ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Column:
    """A column of a table of text; its cells are text already."""

    heading: str
    width: int
    """Least number of characters, the space before the column included."""
    group: str = ""
    """Heading shared with the columns beside it; empty for none."""
    align: str = ">"
    """``>`` for numbers, ``<`` for words."""


def text_table(
    columns: Sequence[Column], rows: Sequence[Sequence[str] | str], width: int = WIDTH
) -> list[str]:
    """Lay rows out in columns below their headings; a row that is one text stands as it is.

    What is wider than ``width`` goes on below, beginning with the first column again. Columns of
    one group stay together.
    """
    lines: list[str] = []
    parts = [[0]]
    for _, grouped in groupby(range(1, len(columns)), lambda place: columns[place].group or place):
        group = list(grouped)
        fits = sum(columns[place].width for place in parts[-1] + group) <= width
        if fits or parts[-1] == [0]:
            parts[-1] += group
        else:
            parts.append([0, *group])
    for part in parts:
        lines += ["", *_side_by_side(columns, rows, part)]
    return lines[1:]


def _side_by_side(
    columns: Sequence[Column], rows: Sequence[Sequence[str] | str], part: Sequence[int]
) -> list[str]:
    """Lay some of the columns out, by their places."""
    # A group's name stands over its first column and runs on over the others of the group.
    groups, end = "", 0
    for name, grouped in groupby((columns[place] for place in part), lambda column: column.group):
        groups = groups.ljust(end + 4) + name if name else groups
        end += sum(column.width for column in grouped)
    lines = [groups] if groups else []
    for row in ([column.heading for column in columns], *rows):
        # A cell wider than its column keeps its gap: the row grows, the numbers never touch.
        laid = (f" {row[k]:{columns[k].align}{columns[k].width - 1}}" for k in part)
        lines.append(row if isinstance(row, str) else "".join(laid).rstrip())
    return lines


_NUMBERS = {
    "frame": (Column("frame", 10), 2),
    "time_s": (Column("time/s", 10), 5),
    "ball_px": (Column("ball/px", 9), 1),
    **{
        f"{body}_{side}_px_frame": (Column(side, 9, f"{body} px/frame"), 3)
        for body in ("ball", "heavy")
        for side in ("before", "after")
    },
}
"""Columns of the table of collisions by those of the array, and their decimals."""


def collision_lines(result: TrialResult, width: int = WIDTH) -> list[str]:
    """Lay the collisions out in rows; those after the counted ones follow under a line of words.

    Columns of which nothing is known (times without a capture rate, a heavy body that is not
    there) are left out.
    """
    if not result.collisions:
        return []
    table = collisions_array(result)
    known = [name for name in _NUMBERS if np.isfinite(table[name]).any()]
    columns = [Column("no.", 6), Column(" kind", 9, align="<"), *(_NUMBERS[n][0] for n in known)]
    rows: list[Sequence[str] | str] = [
        [
            *(str(row["number"]), f" {row['kind']}{'' if row['seen'] else '*'}"),
            *(_number(row[name], _NUMBERS[name][1]) for name in known),
        ]
        for row in table
    ]
    if result.count is not None and result.count < len(rows):
        rows.insert(result.count, "  after the heavy body turned back:")
    return text_table(columns, rows, width) + ([] if table["seen"].all() else [INFERRED])


def _number(value: float, decimals: int) -> str:
    return fixed(value, decimals) if math.isfinite(value) else NOT_KNOWN

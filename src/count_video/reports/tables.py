"""The track, the collisions and a plan's map as tables: for a spreadsheet, and for NumPy."""

from __future__ import annotations

import csv
import io
import math

import numpy as np
from numpy.typing import NDArray

from count_video.records import Track, TrialResult
from count_video.reports.material import burst_size, scale_of

_TYPES = {"number": "i8", "kind": "U6", "seen": "?", "in_burst": "?", "quality": "U5"}
"""Of the columns that are no float64."""
TRACK_COLUMNS = np.dtype(
    [
        (name, _TYPES.get(name, "f8"))
        for name in (
            *("frame", "time_s", "ball_px", "ball_sigma_px", "heavy_px", "heavy_sigma_px"),
            *("ball_mm", "ball_sigma_mm", "heavy_mm", "heavy_sigma_mm", "quality"),
        )
    ]
)
COLLISION_COLUMNS = np.dtype(
    [
        (name, _TYPES.get(name, "f8"))
        for name in (
            *("number", "kind", "seen", "in_burst", "frame", "frame_sigma", "time_s", "ball_px"),
            *("ball_before_px_frame", "ball_after_px_frame"),
            *("heavy_before_px_frame", "heavy_after_px_frame"),
            *("ball_before_sigma_px_frame", "ball_after_sigma_px_frame"),
            *("heavy_before_sigma_px_frame", "heavy_after_sigma_px_frame"),
        )
    ]
)
_DECIMALS = {
    **dict.fromkeys(("frame", "frame_sigma", "ball_px"), 3),
    **dict.fromkeys(("ball_mm", "ball_sigma_mm", "heavy_mm", "heavy_sigma_mm"), 5),
    "time_s": 6,
}
"""Decimals of numbers in a spreadsheet; 4 where a column is not named."""


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

    ``in_burst`` is true for those that the count includes. Velocities are px a frame along the
    line of motion; ``time_s`` is NaN without a capture rate.
    """
    size = burst_size(result)
    rows = [
        (
            *(c.number, c.kind, c.seen, c.number <= size, c.frame, c.frame_sigma),
            *(math.nan if c.time_s is None else c.time_s, c.position_px),
            *(c.velocity_before.ball_px_frame, c.velocity_after.ball_px_frame),
            *(c.velocity_before.heavy_px_frame, c.velocity_after.heavy_px_frame),
            *(c.velocity_before.ball_sigma_px_frame, c.velocity_after.ball_sigma_px_frame),
            *(c.velocity_before.heavy_sigma_px_frame, c.velocity_after.heavy_sigma_px_frame),
        )
        for c in result.collisions
    ]
    return np.array(rows, COLLISION_COLUMNS)


def table_csv(table: NDArray[np.void], **decimals: int) -> str:
    """Write a structured array as CSV with a heading; what is not known is an empty cell.

    ``decimals`` are those of columns that need others than is usual.
    """
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\n")
    names = table.dtype.names or ()
    writer.writerow(names)
    for row in table.tolist():
        cells = zip(names, row, strict=True)
        writer.writerow([_cell(v, (_DECIMALS | decimals).get(name, 4)) for name, v in cells])
    return target.getvalue()


def _cell(value: object, decimals: int) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.{decimals}f}" if math.isfinite(value) else ""
    return str(value)

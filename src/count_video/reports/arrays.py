"""The collisions and the track as NumPy structured arrays, with the columns of the CSV files."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from count_video.records import BodyTrack, Floats, Track, TrialResult
from count_video.reports.csv_files import COLLISION_HEADINGS, TRACK_HEADINGS
from count_video.reports.material import scale_of

_TYPES = {"number": "i8", "kind": "U6", "seen": "?", "in_burst": "?", "quality": "U5"}
"""Of the columns that are no float64."""


def collisions_array(result: TrialResult) -> NDArray[np.void]:
    """Return a row a collision, those after the burst as well; shape (collisions,).

    ``in_burst`` is true for those that the count includes. Velocities are px a frame along the
    line of motion; ``time_s`` is NaN without a capture rate.
    """
    size = result.count if result.count is not None else result.seen or 0
    rows = [
        (
            c.number,
            c.kind,
            c.seen,
            c.number <= size,
            c.frame,
            c.frame_sigma,
            math.nan if c.time_s is None else c.time_s,
            c.position_px,
            c.velocity_before.ball_px_frame,
            c.velocity_after.ball_px_frame,
            c.velocity_before.heavy_px_frame,
            c.velocity_after.heavy_px_frame,
        )
        for c in result.collisions
    ]
    return np.array(rows, _columns(COLLISION_HEADINGS))


def track_array(track: Track | None, result: TrialResult) -> NDArray[np.void]:
    """Return a row a frame; shape (frames,), and (0,) where no bodies could be followed.

    Positions are those along the line of motion, of the ball's centre and of the heavy body's
    face; NaN where not seen. ``quality`` is ``both``, ``ball``, ``heavy`` or ``none``.
    """
    rows = 0 if track is None else len(track.frame)
    table = np.empty(rows, _columns(TRACK_HEADINGS))
    if track is None:
        return table
    scale = scale_of(result)
    millimetre = scale.length if scale.length_unit == "mm" else math.nan
    table["frame"] = track.frame
    table["time_s"] = track.frame / (result.capture_fps or math.nan)
    for name, body in (("ball", track.ball), ("heavy", track.heavy)):
        for kind, values in zip(("", "_sigma"), _sightings(body, rows), strict=True):
            table[f"{name}{kind}_px"] = values
            table[f"{name}{kind}_mm"] = values * millimetre
    ball, heavy = (np.isfinite(table[f"{name}_px"]) for name in ("ball", "heavy"))
    table["quality"] = np.select([ball & heavy, ball, heavy], ["both", "ball", "heavy"], "none")
    return table


def _columns(headings: tuple[str, ...]) -> np.dtype[np.void]:
    return np.dtype([(name, _TYPES.get(name, "f8")) for name in headings])


def _sightings(body: BodyTrack | None, rows: int) -> tuple[Floats, Floats]:
    if body is None:
        return np.full(rows, np.nan), np.full(rows, np.nan)
    return body.position_px, body.sigma_px

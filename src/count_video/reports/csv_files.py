"""The track and the collisions as tables for a spreadsheet: comma separated, a heading each."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence

from count_video.records import BodyTrack, Track, TrialResult
from count_video.reports.material import scale_of

TRACK_HEADINGS = (
    "frame",
    "time_s",
    "ball_px",
    "ball_sigma_px",
    "heavy_px",
    "heavy_sigma_px",
    "ball_mm",
    "ball_sigma_mm",
    "heavy_mm",
    "heavy_sigma_mm",
    "quality",
)
COLLISION_HEADINGS = (
    "number",
    "kind",
    "seen",
    "in_burst",
    "frame",
    "frame_sigma",
    "time_s",
    "ball_px",
    "ball_before_px_frame",
    "ball_after_px_frame",
    "heavy_before_px_frame",
    "heavy_after_px_frame",
)


def track_csv(track: Track, result: TrialResult) -> str:
    """Write a row a frame.

    Positions are those along the line of motion, of the ball's centre and of the heavy body's
    face; millimetres are counted from the picture's edge like the pixels. ``quality`` says what
    the frame shows: ``both``, ``ball``, ``heavy`` or ``none``. What is not known is left empty.
    """
    scale = scale_of(result)
    millimetre = scale.length if scale.length_unit == "mm" else math.nan
    rows = []
    for row, frame in enumerate(track.frame):
        ball, heavy = _sighting(track.ball, row), _sighting(track.heavy, row)
        time_s = frame / result.capture_fps if result.capture_fps else math.nan
        rows.append(
            [
                _number(frame, 0),
                _number(time_s, 6),
                *(_number(value, 4) for value in (*ball, *heavy)),
                *(_number(value * millimetre, 5) for value in (*ball, *heavy)),
                _quality(math.isfinite(ball[0]), math.isfinite(heavy[0])),
            ]
        )
    return _table(TRACK_HEADINGS, rows)


def collisions_csv(result: TrialResult) -> str:
    """Write a row a collision, those after the burst as well."""
    size = result.count if result.count is not None else result.seen or 0
    rows = []
    for c in result.collisions:
        rates = (
            c.velocity_before.ball_px_frame,
            c.velocity_after.ball_px_frame,
            c.velocity_before.heavy_px_frame,
            c.velocity_after.heavy_px_frame,
        )
        rows.append(
            [
                str(c.number),
                c.kind,
                "yes" if c.seen else "no",
                "yes" if c.number <= size else "no",
                _number(c.frame, 3),
                _number(c.frame_sigma, 3),
                _number(math.nan if c.time_s is None else c.time_s, 6),
                _number(c.position_px, 3),
                *(_number(rate, 4) for rate in rates),
            ]
        )
    return _table(COLLISION_HEADINGS, rows)


def _sighting(body: BodyTrack | None, row: int) -> tuple[float, float]:
    if body is None:
        return math.nan, math.nan
    return float(body.position_px[row]), float(body.sigma_px[row])


def _quality(ball: bool, heavy: bool) -> str:
    return {(True, True): "both", (True, False): "ball", (False, True): "heavy"}.get(
        (ball, heavy), "none"
    )


def _number(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}" if math.isfinite(value) else ""


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\n")
    writer.writerow(headings)
    writer.writerows(rows)
    return target.getvalue()

"""The header of the annotated clip: the running count, the last collision, the frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from count_video.records import Collision, TrialResult
from count_video.reports.lettering import text_width, write
from count_video.reports.overlay import mark
from count_video.reports.palette import MARKS

Pixels = NDArray[np.uint8]
HEADER_PX = 72
_LARGE, _SMALL = 52, 20
_WHITE, _PALE = (255, 255, 255), (200, 200, 200)
_MARGIN = 16


def draw_header(canvas: Pixels, result: TrialResult, index: int) -> None:
    """Write what has happened up to and with frame ``index`` into the top rows."""
    size = result.count if result.count is not None else result.seen or 0
    past = [c for c in result.collisions if c.frame < index + 0.5]
    count = min(len(past), size)
    end = write(canvas, str(count), (_MARGIN, 4), _LARGE, _WHITE)
    end = max(end, text_width("00", _LARGE) + _MARGIN) + _MARGIN
    noun = "collision" if count == 1 else "collisions"
    write(canvas, _with_rest(noun, len(past) - count), (end, 12), _SMALL, _WHITE)
    if past:
        _draw_last(canvas, past[-1], (end, 40))
    _draw_frame(canvas, result, index)


def _with_rest(noun: str, beyond: int) -> str:
    return f"{noun}, {beyond} more after the burst" if beyond else noun


def _draw_last(canvas: Pixels, last: Collision, at: tuple[int, int]) -> None:
    x, y = at
    mark(canvas, last.kind, (x + 9.0, y + 12.0), 9.0, seen=last.seen)
    words = MARKS[last.kind].words + ("" if last.seen else ", inferred")
    write(canvas, f"no. {last.number} {words}", (x + 26, y), _SMALL, _PALE)


def _draw_frame(canvas: Pixels, result: TrialResult, index: int) -> None:
    lines = [f"frame {index}"]
    if result.capture_fps:
        lines.append(f"{1000 * index / result.capture_fps:.1f} ms")
    for place, line in enumerate(lines):
        x = canvas.shape[1] - _MARGIN - text_width(line, _SMALL)
        write(canvas, line, (x, 12 + 28 * place), _SMALL, _PALE)

"""Outlines and marks on a picture, placed to a fraction of a pixel."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import CollisionKind
from count_video.reports.palette import MARKS, rgb

Pixels = NDArray[np.uint8]
Point = tuple[float, float]
_FINE = 4
"""Bits of a fraction of a pixel that the drawing routines take."""
WHITE = (255, 255, 255)


def ring(canvas: Pixels, centre: Point, radius: float, colour: tuple[int, int, int]) -> None:
    """Draw a circle."""
    cv2.circle(canvas, _fixed(centre), _length(radius), colour, 2, cv2.LINE_AA, _FINE)


def path(canvas: Pixels, points: Sequence[Point], colour: tuple[int, int, int]) -> None:
    """Draw a line through points."""
    fixed = np.array([_fixed(point) for point in points], np.int32)
    cv2.polylines(canvas, [fixed], False, colour, 2, cv2.LINE_AA, _FINE)


def mark(canvas: Pixels, kind: CollisionKind, at: Point, size: float, *, seen: bool = True) -> None:
    """Draw the mark of a collision: a disc between the bodies, a square at the wall.

    What is inferred between frames is hollow: white with a thick rim of the colour.
    """
    colour = rgb(MARKS[kind].colour)
    rim, inside = (WHITE, colour) if seen else (colour, WHITE)
    for extent, fill in ((size, rim), (size * (0.75 if seen else 0.5), inside)):
        if MARKS[kind].shape == "o":
            cv2.circle(canvas, _fixed(at), _length(extent), fill, -1, cv2.LINE_AA, _FINE)
        else:
            low, high = (at[0] - extent, at[1] - extent), (at[0] + extent, at[1] + extent)
            cv2.rectangle(canvas, _fixed(low), _fixed(high), fill, -1, cv2.LINE_AA, _FINE)


def _fixed(point: Point) -> tuple[int, int]:
    return round(point[0] * 2**_FINE), round(point[1] * 2**_FINE)


def _length(length: float) -> int:
    fixed: int = round(length * 2**_FINE)
    return max(1, fixed)

"""Numbers beside marks, placed so that none hides another or a mark."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Annotation

from count_video.records import Floats
from count_video.reports.drawing import HALO

GID = "number"
DIGIT_WIDTH = 0.68
"""Width of a bold digit over the size of the type."""
APART = 1.5
"""Points to the left and right of a number, so that two do not read as one."""
STEPS = (1.0, 1.9, 2.8, 3.7)
"""Distances from the mark that are tried, in sizes of the type."""
TURNS_DEG = (0, -35, 35, -70, 70)
"""Directions that are tried, from the wanted one."""


def number_marks(
    axes: Axes, places: Floats, texts: Sequence[str], away: Floats, *, size: float = 10
) -> None:
    """Ask for numbers beside marks; ``place_numbers`` puts them where there is space.

    Parameters
    ----------
    places
        Of the marks, in data coordinates, shape (n, 2).
    texts
        What to write; an empty text is a mark without a number.
    away
        Directions in which the numbers stand, x to the right and y up, shape (n, 2).
    """
    for (x, y), text, (right, up) in zip(places, texts, away, strict=True):
        if np.isfinite([x, y]).all():
            label = axes.annotate(
                text,
                (x, y),
                xytext=(right, up),
                textcoords="offset points",
                ha="center",
                va="center",
                fontsize=size,
                weight="bold",
                path_effects=list(HALO),
                zorder=5,
                gid=GID if text else "no number",
                annotation_clip=True,
            )
            label.set_in_layout(False)


def place_numbers(figure: Figure) -> None:
    """Move the numbers of all panels off each other and off the marks, nearest places first.

    A number for which there is no space is left out: the marks beside it say which it is.
    """
    figure.draw_without_rendering()  # lays out the panels, so that data have a place in points
    for axes in figure.axes:
        labels = [
            text
            for text in axes.texts
            if isinstance(text, Annotation) and text.get_gid() in (GID, "no number")
        ]
        if not labels:
            continue
        marks = axes.transData.transform([label.xy for label in labels]) * 72 / figure.dpi
        taken: list[tuple[float, float, float, float]] = []
        for place, label in zip(marks, labels, strict=True):
            if label.get_gid() != GID:
                continue
            size = float(label.get_fontsize())
            half = (DIGIT_WIDTH * size * len(label.get_text()) / 2 + APART, size / 2)
            wanted = np.array(label.xyann) / np.hypot(*label.xyann)
            for step, turn in product(STEPS, TURNS_DEG):
                angle = np.radians(turn) + np.arctan2(wanted[1], wanted[0])
                offset = step * size * np.array([np.cos(angle), np.sin(angle)])
                box = _box(place + offset, half)
                if not _meets(box, taken) and not _covers(box, marks):
                    taken.append(box)
                    label.set_position((float(offset[0]), float(offset[1])))
                    break
            else:
                label.set_visible(False)


def _box(middle: Floats, half: tuple[float, float]) -> tuple[float, float, float, float]:
    x, y = float(middle[0]), float(middle[1])
    return x - half[0], y - half[1], x + half[0], y + half[1]


def _meets(
    box: tuple[float, float, float, float], taken: Sequence[tuple[float, float, float, float]]
) -> bool:
    return any(
        box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]
        for other in taken
    )


def _covers(box: tuple[float, float, float, float], marks: Floats) -> bool:
    margin = 3.0  # points, the radius of most of a mark
    inside = (marks > np.array(box[:2]) - margin) & (marks < np.array(box[2:]) + margin)
    return bool(inside.all(axis=1).any())

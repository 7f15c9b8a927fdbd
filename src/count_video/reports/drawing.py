"""What all pictures share: colours, marks, typeface, file formats, and drawing on footage.

The colours are those of Okabe and Ito, which differ for people with any kind of colour
blindness; the kinds of collision differ in shape as well.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import cv2
import matplotlib.patheffects as effects
import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont
from matplotlib.ft2font import FT2Font
from matplotlib.text import Annotation
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from count_video.records import CollisionKind, Floats
from count_video.reports.words import printable

Pixels = NDArray[np.uint8]
Point = tuple[float, float]
Colour = tuple[int, int, int]

BLACK, GREY, WHITE = "#000000", "#666666", "#FFFFFF"
ORANGE, SKY_BLUE, GREEN, YELLOW = "#E69F00", "#56B4E9", "#009E73", "#F0E442"
BLUE, VERMILION = "#0072B2", "#D55E00"
BALL, HEAVY = SKY_BLUE, ORANGE
OWN = "#8fd4b4"
"""Colour of the theory's count on a map; the pages have the same."""

FONT = "DejaVu Sans"
"""Comes with matplotlib, so that pictures are the same on every machine."""
STYLE: Any = {
    "font.family": FONT,
    "font.size": 11,
    "axes.titlesize": 12,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 11,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.fontsize": 10,
    "legend.framealpha": 0.9,
    "xtick.labelsize": 10,
    "ytick.labelsize": 10,
    "svg.hashsalt": "count-video",  # the same picture gives the same file
    "svg.fonttype": "none",  # letters stay letters, which can be searched and edited
}
DOTS_PER_INCH = 110
HALO = (effects.withStroke(linewidth=2.5, foreground="white"),)
"""A white rim that keeps numbers readable on footage."""
PAPER = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 2}
"""A white ground that keeps words readable on lines."""
BARS: Any = {"elinewidth": 1.0, "capsize": 2.0}
"""Bars of one standard uncertainty to either side."""
_FINE = 4
"""Bits of a fraction of a pixel that the drawing routines take."""


@dataclass(frozen=True)
class Mark:
    """How one kind of collision is drawn."""

    colour: str
    shape: str
    """Marker of matplotlib: ``o`` is a disc, ``s`` a square."""
    words: str


MARKS: dict[CollisionKind, Mark] = {
    "bodies": Mark(VERMILION, "o", "between the bodies"),
    "wall": Mark(BLUE, "s", "with the wall"),
}


def rgb(colour: str) -> Colour:
    """Red, green and blue of ``#RRGGBB``, each 0 to 255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


# ---- figures ----------------------------------------------------------------------------------


def styled() -> AbstractContextManager[None]:
    """Context in which a figure is made and written, whatever ``matplotlibrc`` lies about here."""
    context: AbstractContextManager[None] = style.context(["default", STYLE])
    return context


def picture_bytes(figure: Figure, picture_format: str) -> bytes:
    """Write a figure as PNG, SVG or JPEG; the same figure gives the same bytes."""
    target = io.BytesIO()
    metadata = {"svg": {"Date": None}, "png": {"Software": "count-video"}}.get(picture_format)
    with styled():
        figure.savefig(target, format=picture_format, dpi=DOTS_PER_INCH, metadata=metadata)
    return target.getvalue()


def drawable(text: str) -> str:
    """Replace what the font has no sign for, so that nothing is left out in silence."""
    return "".join(sign if ord(sign) in _signs() else "?" for sign in printable(text))


@cache
def _signs() -> frozenset[int]:
    return frozenset(FT2Font(_font_path()).get_charmap())


@cache
def _font_path() -> str:
    """File of the font that everything is lettered in."""
    return str(findfont(FONT))


# ---- numbers beside marks, placed so that none hides another or a mark -------------------------

GID, NO_NUMBER = "number", "no number"
DIGIT_WIDTH = 0.68
"""Width of a bold digit over the size of the type."""
APART = 1.5
"""Points to the left and right of a number, so that two do not read as one."""
BEYOND = 5.0
"""Points by which a number may stick out of its panel."""
MARGIN = 3.0
"""Points around a mark that a number leaves free: the radius of most marks."""
STEPS = (1.0, 1.9, 2.8, 3.7)
"""Distances from the mark that are tried, in sizes of the type."""
TURNS_DEG = (0, -35, 35, -80, 80, 180)
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
                gid=GID if text else NO_NUMBER,
                annotation_clip=True,
            )
            label.set_in_layout(False)


def place_numbers(figure: Figure) -> None:
    """Move the numbers of all panels off each other and off the marks, nearest places first.

    A number stands nearer to its own mark than to any other. One for which there is no such place
    is left out: the numbers beside it say which it is.
    """
    figure.draw_without_rendering()  # lays out the panels, so that data have a place in points
    for axes in figure.axes:
        labels = [text for text in axes.texts if isinstance(text, Annotation)]
        labels = [label for label in labels if label.get_gid() in (GID, NO_NUMBER)]
        if labels:
            marks = axes.transData.transform([label.xy for label in labels]) * 72 / figure.dpi
            _place(labels, marks, axes.bbox.get_points() * 72 / figure.dpi)


def _place(labels: Sequence[Annotation], marks: Floats, panel: Floats) -> None:
    """Give each label the first place that is free; marks and the panel's corners in points."""
    taken = np.empty((0, 2, 2))
    for mark_at, label in zip(marks, labels, strict=True):
        if label.get_gid() != GID:
            continue
        size, text = float(label.get_fontsize()), label.get_text()
        half = np.array([DIGIT_WIDTH * size * len(text) / 2 + APART, size / 2])
        turns = np.radians(TURNS_DEG) + np.arctan2(*label.xyann[::-1])
        away = np.multiply.outer(
            size * np.array(STEPS), np.column_stack([np.cos(turns), np.sin(turns)])
        )
        offsets = away.reshape(-1, 2)
        boxes = mark_at + np.stack([offsets - half, offsets + half], axis=1)
        low, high = boxes[:, None, 0], boxes[:, None, 1]
        inside = (low > panel[0] - BEYOND) & (high < panel[1] + BEYOND)
        on_others = ((low < taken[:, 1]) & (taken[:, 0] < high)).all(axis=2).any(axis=1)
        on_marks = ((marks > low - MARGIN) & (marks < high + MARGIN)).all(axis=2).any(axis=1)
        nearest = np.linalg.norm(marks - mark_at - offsets[:, None], axis=2).min(axis=1)
        own = nearest >= np.linalg.norm(offsets, axis=1) - 1e-6
        free = np.flatnonzero(inside.all(axis=(1, 2)) & ~on_others & ~on_marks & own)
        label.set_visible(len(free) > 0)
        if len(free):
            label.set_position(tuple(offsets[free[0]].tolist()))
            taken = np.concatenate([taken, boxes[free[:1]]])


# ---- footage ----------------------------------------------------------------------------------
# A canvas is RGB, shape (height, width, 3); places and lengths on it are px.


def ring(canvas: Pixels, centre: Point, radius: float, colour: Colour) -> None:
    """Draw a circle on a canvas (height, width, 3), placed to a fraction of a pixel."""
    cv2.circle(canvas, _fixed(centre), _length(radius), colour, 2, cv2.LINE_AA, _FINE)


def path(canvas: Pixels, points: Sequence[Point], colour: Colour) -> None:
    """Draw a line through points (x, y) in px."""
    fixed = np.array([_fixed(point) for point in points], np.int32)
    cv2.polylines(canvas, [fixed], False, colour, 2, cv2.LINE_AA, _FINE)


def mark(canvas: Pixels, kind: CollisionKind, at: Point, size: float, *, seen: bool = True) -> None:
    """Draw the mark of a collision: a disc between the bodies, a square at the wall.

    ``size`` is half its width in px. What is inferred between frames is hollow: white with a thick
    rim of the colour.
    """
    colour = rgb(MARKS[kind].colour)
    rim, inside = (rgb(WHITE), colour) if seen else (colour, rgb(WHITE))
    for extent, fill in ((size, rim), (size * (0.75 if seen else 0.5), inside)):
        if MARKS[kind].shape == "o":
            cv2.circle(canvas, _fixed(at), _length(extent), fill, -1, cv2.LINE_AA, _FINE)
        else:
            low, high = (at[0] - extent, at[1] - extent), (at[0] + extent, at[1] + extent)
            cv2.rectangle(canvas, _fixed(low), _fixed(high), fill, -1, cv2.LINE_AA, _FINE)


def _fixed(point: Point) -> tuple[int, int]:
    return round(point[0] * 2**_FINE), round(point[1] * 2**_FINE)


def _length(length: float) -> int:
    return max(1, int(length * 2**_FINE + 0.5))


def write(canvas: Pixels, text: str, at: tuple[int, int], size_px: int, colour: Colour) -> int:
    """Write a line of text with its left top corner at (x, y); what sticks out is cut off.

    Returns the x at which the text ends.
    """
    cover = _cover(drawable(text), size_px)
    x, y = at
    left, top = max(0, -x), max(0, -y)
    height = min(cover.shape[0], canvas.shape[0] - y)
    width = min(cover.shape[1], canvas.shape[1] - x)
    if height > top and width > left:
        piece = cover[top:height, left:width, None]
        under = canvas[y + top : y + height, x + left : x + width]
        under[...] = (under * (1 - piece) + piece * np.array(colour)).astype(np.uint8)
    return int(x + cover.shape[1])


def text_width(text: str, size_px: int) -> int:
    """Width of a line of text in px."""
    return int(_cover(drawable(text), size_px).shape[1])


@lru_cache(maxsize=512)
def _cover(text: str, size_px: int) -> NDArray[np.float32]:
    """How much of each pixel the text covers, 0 to 1, shape (height, width)."""
    font = ImageFont.truetype(_font_path(), size_px)
    width = max(1, round(font.getlength(text)))
    image = Image.new("L", (width, round(1.3 * size_px)))
    ImageDraw.Draw(image).text((0, 0), text, fill=255, font=font)
    return np.asarray(image, np.float32) / np.float32(255)

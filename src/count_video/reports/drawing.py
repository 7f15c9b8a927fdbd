"""What all pictures share: colours, marks, typeface, file formats, and numbers beside marks.

The colours are those of Okabe and Ito, which differ for people with any kind of colour
blindness; the kinds of collision differ in shape as well.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib.patheffects as effects
import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.backend_bases import get_registered_canvas_class
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont, get_font
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox

from count_video.records import CollisionKind
from count_video.reports.words import KINDS, printable

GREY = "#666666"
ORANGE, SKY_BLUE, GREEN, YELLOW = "#E69F00", "#56B4E9", "#009E73", "#F0E442"
BLUE, VERMILION = "#0072B2", "#D55E00"
BALL, HEAVY = SKY_BLUE, ORANGE
OWN = "#8fd4b4"
"""Colour of the theory's count on a map; the pages have the same."""

FONT = "DejaVu Sans"
"""Comes with matplotlib, so that pictures are the same on every machine."""
DOTS_PER_INCH = 110
STYLE: Any = {
    "font.family": FONT,
    "font.size": 11,
    "axes.titlesize": 12,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.fontsize": 10,
    "legend.framealpha": 0.9,
    "xtick.labelsize": 10,
    "ytick.labelsize": 10,
    "svg.hashsalt": "count-video",  # the same picture gives the same file
    "svg.fonttype": "none",  # letters stay letters, which can be searched and edited
}
MEDIA_TYPES = {"png": "image/png", "svg": "image/svg+xml"}
HALO = (effects.withStroke(linewidth=2.5, foreground="white"),)
"""A white rim that keeps numbers readable on footage."""
PAPER = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 2}
"""A white ground that keeps words readable on lines."""
BARS: Any = {"elinewidth": 1.0, "capsize": 2.0}
"""Bars of one standard uncertainty to either side."""


@dataclass(frozen=True)
class Mark:
    """How one kind of collision is drawn."""

    colour: str
    shape: str
    """Marker of matplotlib: ``o`` is a disc, ``s`` a square."""
    signs: str
    """Letters that look like it: filled, and hollow where it is inferred between frames."""
    words: str


MARKS: dict[CollisionKind, Mark] = {
    "bodies": Mark(VERMILION, "o", "●○", KINDS["bodies"]),
    "wall": Mark(BLUE, "s", "■□", KINDS["wall"]),
}


def styled() -> AbstractContextManager[None]:
    """Context in which a figure is made and written, whatever ``matplotlibrc`` lies about here."""
    return style.context(["default", STYLE])


@contextmanager
def figure_of(width: float, height: float) -> Iterator[Figure]:
    """Make a figure of this size in inches to draw on; then its panels get their final place."""
    with styled():
        figure = Figure(figsize=(width, height))
        figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.1)
        yield figure
        _thin_numbers(figure)


def picture_bytes(figure: Figure, picture_format: str) -> bytes:
    """Write a figure as PNG, SVG or JPEG; the same figure gives the same bytes."""
    target = io.BytesIO()
    metadata = {"svg": {"Date": None}, "png": {"Software": "count-video"}}.get(picture_format)
    figure.dpi = DOTS_PER_INCH
    with styled():
        canvas: Any = get_registered_canvas_class(picture_format)(figure)
        # Not savefig, which lays the figure out once more before it draws it.
        getattr(canvas, f"print_{picture_format}")(target, metadata=metadata)
    return target.getvalue()


def drawable(text: str) -> str:
    """Replace what the font has no sign for, so that nothing is left out in silence."""
    font = get_font(findfont(FONT))
    return "".join(sign if font.get_char_index(ord(sign)) else "?" for sign in printable(text))


# ---- numbers beside marks ----------------------------------------------------------------------

Number = tuple[str, tuple[float, float], tuple[float, float]]
"""What to write, its mark's place in data coordinates, and the direction in which it stands from
there, x to the right and y up."""


def number_marks(axes: Axes, numbers: Iterable[Number], *, size: float = 10) -> None:
    """Write numbers beside marks; those that are in the way go once the figure is drawn."""
    for text, place, away in numbers:
        if np.isfinite(place).all():
            right, up = np.divide(away, np.hypot(*away) or 1.0)
            label = axes.annotate(
                text,
                place,
                xytext=(6.0 * right, 6.0 * up),
                textcoords="offset points",
                ha=("right", "center", "left")[round(right) + 1],
                va=("top", "center", "bottom")[round(up) + 1],
                fontsize=size,
                weight="bold",
                path_effects=list(HALO),
                zorder=5,
                gid="number",
                annotation_clip=True,
            )
            label.set_in_layout(False)


def _thin_numbers(figure: Figure) -> None:
    """Take away each number that would lie on one before it or on a mark.

    The same goes for one that is nearer to another mark than to its own: the numbers beside it say
    which it is.
    """
    figure.dpi = DOTS_PER_INCH
    # Without a canvas that draws, every measure of a text would begin to print the whole figure.
    canvas: Any = FigureCanvasAgg(figure)
    renderer = canvas.get_renderer()
    engine = figure.get_layout_engine()
    if engine is not None:  # here alone, so that data have their final place
        engine.execute(figure)
        if any(axes.get_aspect() != "auto" for axes in figure.axes):
            engine.execute(figure)  # again, for such a panel takes less than it was given
        figure.set_layout_engine("none")
        for axes in figure.axes:  # the solver's last digits differ from run to run
            axes.set_position(np.round(axes.get_position(original=True).bounds, 6))
    for axes in figure.axes:
        drawn = [one for one in axes.collections if isinstance(one, PathCollection)]
        places = [axes.transData.transform(np.asarray(one.get_offsets())) for one in drawn]
        taken: list[Bbox] = []
        for label in axes.texts:
            if isinstance(label, Annotation) and label.get_gid() == "number":
                box, marks = label.get_window_extent(renderer), np.concatenate(places)
                middle, own = box.get_points().mean(axis=0), axes.transData.transform(label.xy)
                nearest = np.linalg.norm(marks - middle, axis=1).min()
                around = box.padded(3.0)
                free = around.count_overlaps(taken) == around.count_contains(marks) == 0
                label.set_visible(free and nearest >= np.linalg.norm(own - middle) - 1e-6)
                taken += [box] if label.get_visible() else []

"""What all pictures share: type sizes, the file they end in, and names that fonts can show."""

from __future__ import annotations

import io
from contextlib import AbstractContextManager
from functools import cache
from typing import Any

import matplotlib as mpl
import matplotlib.patheffects as effects
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont
from matplotlib.ft2font import FT2Font

from count_video.reports.printable import printable

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
    "svg.fonttype": "path",
}
DOTS_PER_INCH = 110
HALO = (effects.withStroke(linewidth=2.5, foreground="white"),)
"""A white rim that keeps numbers readable on footage."""


def styled() -> AbstractContextManager[None]:
    """Context in which a figure is made and written."""
    context: AbstractContextManager[None] = mpl.rc_context(STYLE)
    return context


def picture_bytes(figure: Figure, picture_format: str) -> bytes:
    """Write a figure as PNG or SVG; the same figure gives the same bytes."""
    target = io.BytesIO()
    metadata = {"Date": None} if picture_format == "svg" else {"Software": "count-video"}
    with styled():
        figure.savefig(target, format=picture_format, dpi=DOTS_PER_INCH, metadata=metadata)
    return target.getvalue()


def drawable(text: str) -> str:
    """Replace what the font has no sign for, so that nothing is left out in silence."""
    return "".join(sign if ord(sign) in _signs() else "?" for sign in printable(text))


@cache
def _signs() -> frozenset[int]:
    return frozenset(FT2Font(font_path()).get_charmap())


@cache
def font_path() -> str:
    """File of the font that everything is lettered in."""
    return str(findfont(FONT))

"""The theory as a picture: the phase circle with numbered state points, as the paper draws it."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from textwrap import shorten
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc
from matplotlib.transforms import Bbox

from count_video.errors import UsageError
from count_video.outputs import open_outputs
from count_video.physics.theory import collision_count, theta_rad
from count_video.reports.drawing import picture_bytes, styled
from count_video.reports.palette import BLUE
from count_video.reports.phase_circle import MOST_POINTS, Look, draw_phase_circle, number_points
from count_video.reports.theory_text import facts, plain, powers_table

MOST_WRITTEN_OUT = 10**12
"""Larger counts do not fit into the picture with all their digits."""
LONGEST_FACT = 100
"""Characters of a line of words."""
MOST_NUMBERS = 45
"""From more points on only some are numbered, about this many."""


def write_theory_picture(
    masses: tuple[Fraction, Fraction], folder: Path, picture_format: str
) -> None:
    """Write ``theory.png`` or ``theory.svg`` into a folder, which is made if needed.

    ``masses`` are the heavy and the light one, in any one unit.

    Raises
    ------
    UsageError
        If it cannot be written.
    """
    data = picture_bytes(theory_figure(*masses), picture_format)
    outputs = open_outputs(folder)
    try:
        outputs.write(f"theory.{picture_format}", data)
    except OSError as error:
        raise UsageError(f"{folder}: cannot be written to: {error.strerror}") from error


def theory_figure(heavy: Fraction, light: Fraction) -> Figure:
    """Draw the phase circle beside what the theory says in words and the table for 1:100^n."""
    with styled():
        figure = Figure(figsize=(15.0, 9.5))
        figure.set_layout_engine("constrained", w_pad=0.2, h_pad=0.2)
        columns = figure.add_gridspec(1, 2, width_ratios=[1.55, 1])
        count = collision_count(heavy, light)
        circle = figure.add_subplot(columns[0])
        points = draw_phase_circle(circle, heavy, light, count, Look())
        step = max(1, -(-len(points) // MOST_NUMBERS))
        chosen = np.arange(0, len(points), step)
        number_points(circle, points[chosen], chosen.astype(float), size=10, brackets=True)
        _draw_angles(circle, theta_rad(heavy, light))
        circle.set_xlabel(r"$V_1 = \sqrt{M}\,v_1$")
        circle.set_title(f"m : M = 1 : {plain(heavy / light)}", fontsize=18)
        if count >= MOST_POINTS:
            circle.text(
                0, -0.5, f"{_short(count + 1)} state points:\ntoo many to draw", ha="center"
            )
        _draw_words(figure.add_subplot(columns[1]), heavy, light)
        return figure


def _draw_angles(axes: Axes, theta: float) -> None:
    """Draw the step along the circle and the opening of the region where the collisions end."""
    alpha = np.degrees(2 * theta)
    axes.add_patch(Arc((0, 0), 0.5, 0.5, theta1=180 - alpha, theta2=180, color=BLUE, linewidth=2))
    middle = np.pi - theta
    axes.plot([0, np.cos(np.pi - 2 * theta)], [0, np.sin(np.pi - 2 * theta)], color=BLUE, lw=1)
    _name(axes, "α", (0.32 * np.cos(middle), 0.32 * np.sin(middle)))
    _name(axes, "θ", (0.62 * np.cos(theta / 2), 0.62 * np.sin(theta / 2)))
    axes.annotate(
        "no further collision\nfrom here",
        (0.8 * np.cos(theta / 2), 0.8 * np.sin(theta / 2)),
        xytext=(0.45, -0.3),
        ha="center",
        va="top",
        color=BLUE,
        fontsize=11,
        arrowprops={"arrowstyle": "->", "color": BLUE},
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 2},
    )


def _name(axes: Axes, letter: str, place: tuple[float, float]) -> None:
    paper = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1}
    axes.text(*place, letter, fontsize=15, color=BLUE, ha="center", va="center", bbox=paper)


def _short(count: int) -> str:
    return str(count) if count < MOST_WRITTEN_OUT else f"{Decimal(count):.3e}"


def _draw_words(axes: Axes, heavy: Fraction, light: Fraction) -> None:
    axes.set_axis_off()
    count = collision_count(heavy, light)
    place: Any = {"transform": axes.transAxes, "va": "top"}
    axes.text(0, 0.98, f"{_short(count)} collisions", fontsize=34, weight="bold", **place)
    words = "\n".join(
        shorten(f"{label}:  {value}", LONGEST_FACT, placeholder=" …")
        for label, value in facts(heavy, light)[2:]
    )
    axes.text(0, 0.85, words, fontsize=11, linespacing=1.9, **place)
    axes.text(0, 0.56, "m : M = 1 : 100ⁿ", fontsize=14, weight="bold", **place)
    rows = [[str(n), str(number), f"{low} to {high}"] for n, number, low, high in powers_table()]
    table = axes.table(
        cellText=rows,
        colLabels=["n", "collisions", "π lies between"],
        colWidths=[0.1, 0.32, 0.58],
        cellLoc="center",
        edges="horizontal",
        bbox=Bbox.from_bounds(0.0, 0.08, 1.0, 0.43),
    )
    table.auto_set_font_size(False)
    table.set_fontsize(12)

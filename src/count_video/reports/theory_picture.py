"""The phase circle of the paper's figures, and the theory as a picture of its own."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from textwrap import shorten
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Wedge
from matplotlib.transforms import Bbox

from count_video.errors import UsageError
from count_video.outputs import open_outputs
from count_video.physics.theory import Mass, collision_count, state_points, theta_rad
from count_video.records import Floats
from count_video.reports.drawing import (
    BLACK,
    BLUE,
    GREY,
    PAPER,
    SKY_BLUE,
    VERMILION,
    number_marks,
    picture_bytes,
    place_numbers,
    styled,
)
from count_video.reports.theory_text import facts, plain, powers_table

MOST_POINTS = 700
"""More points than this melt into a line; the circle is then drawn alone."""
REACH = 1.24
"""Half the side of the panel, in radii."""
MOST_WRITTEN_OUT = 10**12
"""Larger counts do not fit into the picture with all their digits."""
LONGEST_FACT = 100
"""Characters of a line of words."""
MOST_NUMBERS = 45
"""From more points on only some are numbered, about this many."""


def draw_phase_circle(
    axes: Axes,
    heavy: Mass,
    light: Mass,
    count: int,
    *,
    lines: tuple[str, float] = (VERMILION, 0.7),
    points: bool = True,
) -> Floats:
    """Draw the theory into a panel and return its state points, shape (n, 2); n = 0 if too many.

    The momentum lines have slope -sqrt(M/m), the stopping region lies between the V1 axis and
    the line of slope sqrt(m/M) through the centre.

    Parameters
    ----------
    lines
        Colour and opacity of the momentum lines.
    points
        Draw the state points themselves.
    """
    theta = theta_rad(heavy, light)
    edge = 1.12 * np.array([[0, np.cos(theta)], [0, np.sin(theta)]])
    opening = float(np.degrees(theta))
    axes.add_patch(Wedge((0, 0), 1.0, 0.0, opening, color=SKY_BLUE, alpha=0.35, gid="stopping"))
    axes.plot(*edge, color=SKY_BLUE, linewidth=1.2)
    axes.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor=BLACK, linewidth=1.3, gid="circle"))
    axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=0)
    axes.axvline(0.0, color=GREY, linewidth=0.7, zorder=0)
    states = state_points(heavy, light) if count < MOST_POINTS else np.empty((0, 2))
    for step in range(1, len(states)):
        # Momentum lines slant (odd steps), mirrors at the wall are upright and dashed (even ones).
        gid, colour, dashes = (
            ("momentum", lines[0], "-") if step % 2 else ("mirror", GREY, (0, (3, 2)))
        )
        style: Any = {"color": colour, "linestyle": dashes, "linewidth": 1.0, "alpha": lines[1]}
        axes.plot(*states[step - 1 : step + 1].T, zorder=1, gid=gid, **style)
    if points and len(states):
        axes.plot(*states.T, "o", color=BLACK, markersize=5, gid="state points")
    axes.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), aspect="equal")
    axes.set_xlabel(r"$V_1 = \sqrt{M}\,v_1$  (in units of the first state)")
    axes.set_ylabel(r"$V_2 = \sqrt{m}\,v_2$")
    return states


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
        circle, words = figure.subplots(1, 2, width_ratios=[1.55, 1])
        count = collision_count(heavy, light)
        points = draw_phase_circle(circle, heavy, light, count)
        step = max(1, -(-len(points) // MOST_NUMBERS))
        texts = ["" if k % step else f"({k})" for k in range(len(points))]
        number_marks(circle, points, texts, points)
        _draw_angles(circle, theta_rad(heavy, light))
        circle.set_xlabel(r"$V_1 = \sqrt{M}\,v_1$")
        circle.set_title(f"m : M = 1 : {plain(heavy / light)}", fontsize=18)
        if count >= MOST_POINTS:
            many = f"{_short(count + 1)} state points:\ntoo many to draw"
            circle.text(0, -0.5, many, ha="center")
        _draw_words(words, heavy, light)
        place_numbers(figure)
        return figure


def _draw_angles(axes: Axes, theta: float) -> None:
    """Draw the step along the circle and the opening of the region where the collisions end."""
    alpha = float(np.degrees(2 * theta))
    axes.add_patch(Arc((0, 0), 0.5, 0.5, theta1=180 - alpha, theta2=180, color=BLUE, linewidth=2))
    axes.plot([0, np.cos(np.pi - 2 * theta)], [0, np.sin(np.pi - 2 * theta)], color=BLUE, lw=1)
    for letter, angle, radius in (("α", np.pi - theta, 0.32), ("θ", theta / 2, 0.62)):
        place = (radius * np.cos(angle), radius * np.sin(angle))
        axes.text(*place, letter, fontsize=15, color=BLUE, ha="center", va="center", bbox=PAPER)
    axes.annotate(
        "no further collision\nfrom here",
        (0.8 * np.cos(theta / 2), 0.8 * np.sin(theta / 2)),
        xytext=(0.45, -0.3),
        ha="center",
        va="top",
        color=BLUE,
        fontsize=11,
        arrowprops={"arrowstyle": "->", "color": BLUE},
        bbox=PAPER,
    )


def _short(count: int) -> str:
    return str(count) if count < MOST_WRITTEN_OUT else f"{Decimal(count):.3e}"


def _draw_words(axes: Axes, heavy: Fraction, light: Fraction) -> None:
    axes.set_axis_off()
    place: Any = {"transform": axes.transAxes, "va": "top"}
    count = _short(collision_count(heavy, light))
    axes.text(0, 0.98, f"{count} collisions", fontsize=34, weight="bold", **place)
    words = "\n".join(
        shorten(f"{label}:  {value}", LONGEST_FACT, placeholder=" …")
        for label, value in facts(heavy, light)[2:]
    )
    axes.text(0, 0.85, words, fontsize=11, linespacing=1.9, **place)
    axes.text(0, 0.56, "m : M = 1 : 100ⁿ", fontsize=14, weight="bold", **place)
    table = axes.table(
        cellText=[
            [str(n), str(count), f"{low} to {high}"] for n, count, low, high in powers_table()
        ],
        colLabels=["n", "collisions", "π lies between"],
        colWidths=[0.1, 0.32, 0.58],
        cellLoc="center",
        edges="horizontal",
        bbox=Bbox.from_bounds(0.0, 0.08, 1.0, 0.43),
    )
    table.auto_set_font_size(False)
    table.set_fontsize(12)

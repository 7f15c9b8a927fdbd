"""The phase circle of the paper's figures: momentum lines, state points, stopping region."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Wedge

from count_video.physics.phase_circle import state_points
from count_video.physics.theory import Mass, theta_rad
from count_video.records import Floats
from count_video.reports.palette import BLACK, GREY, SKY_BLUE, VERMILION

MOST_POINTS = 700
"""More points than this melt into a line; the circle is then drawn alone."""
DEEP = 0.6
REACH = 1.24
"""Half the side of the panel, in radii."""


@dataclass(frozen=True)
class Look:
    """What of the theory is drawn how strongly."""

    line_colour: str = VERMILION
    line_alpha: float = 0.7
    points: bool = True
    """Draw the state points themselves."""


def draw_phase_circle(axes: Axes, heavy: Mass, light: Mass, count: int, look: Look) -> Floats:
    """Draw the theory into a panel and return its state points, shape (n, 2); n = 0 if too many.

    The momentum lines have slope -sqrt(M/m), the stopping region lies between the V1 axis and
    the line of slope sqrt(m/M) through the centre.
    """
    opening = np.degrees(theta_rad(heavy, light))
    axes.add_patch(Wedge((0, 0), 1.0, 0.0, opening, color=SKY_BLUE, alpha=0.35, gid="stopping"))
    border = np.radians(opening)
    edge = 1.12
    axes.plot([0, edge * np.cos(border)], [0, edge * np.sin(border)], color=SKY_BLUE, linewidth=1.2)
    axes.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor=BLACK, linewidth=1.3, gid="circle"))
    for line in (axes.axhline, axes.axvline):
        line(0.0, color=GREY, linewidth=0.7, zorder=0)
    points = state_points(heavy, light) if count < MOST_POINTS else np.empty((0, 2))
    _draw_steps(axes, points, look)
    axes.set_xlim(-REACH, REACH)
    axes.set_ylim(-REACH, REACH)
    axes.set_aspect("equal")
    axes.set_xlabel(r"$V_1 = \sqrt{M}\,v_1$  (in units of the first state)")
    axes.set_ylabel(r"$V_2 = \sqrt{m}\,v_2$")
    return points


def number_points(
    axes: Axes, points: Floats, numbers: Floats, *, size: float, brackets: bool = False
) -> None:
    """Write numbers outside the circle, next to points of shape (n, 2)."""
    for number, (x, y) in zip(numbers, points, strict=True):
        length = np.hypot(x, y)
        if not length > 0:  # NaN, or the centre
            continue
        # Close to a point deep inside, else all on one ring outside of the circle.
        away = (max(1.0, length) if length > DEEP else length) + 0.075
        axes.text(
            x / length * away,
            y / length * away,
            f"({int(number)})" if brackets else f"{int(number)}",
            ha="center",
            va="center",
            fontsize=size,
            gid="number",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.5},
            zorder=3,
        )


def _draw_steps(axes: Axes, points: Floats, look: Look) -> None:
    """Momentum lines slant (odd steps), mirrors at the wall are upright and dashed (even ones)."""
    for step in range(1, len(points)):
        x, y = points[step - 1 : step + 1].T
        slanting = step % 2 == 1
        axes.plot(
            x,
            y,
            color=look.line_colour if slanting else GREY,
            linestyle="-" if slanting else (0, (3, 2)),
            linewidth=1.0,
            alpha=look.line_alpha,
            zorder=1,
            gid="momentum" if slanting else "mirror",
        )
    if look.points and len(points):
        axes.plot(points[:, 0], points[:, 1], "o", color=BLACK, markersize=5, gid="state points")

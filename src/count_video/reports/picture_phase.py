"""The panel with the measured states over the phase circle of the theory."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from count_video.physics.theory import collision_count
from count_video.reports.material import Material
from count_video.reports.palette import BLUE, GREY, MARKS
from count_video.reports.phase import States, measured_states
from count_video.reports.phase_circle import Look, draw_phase_circle, number_points

MOST_NUMBERS = 45
"""From more points on only every fifth is numbered."""
SWING_WORTH_A_WORD = 0.05
"""Share of the energy in the swing from which on it is mentioned."""
_PAPER = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 2}


def why_no_states(material: Material) -> str:
    """Say what the states of both bodies are missing."""
    if material.track.heavy is None:
        return "one body alone"
    return "needs the mass ratio:\ngive --masses HEAVY LIGHT"


def draw_measured_phase_circle(axes: Axes, material: Material) -> None:
    """Draw theory and measurement; a sentence where the mass ratio is not known."""
    axes.set_title("Phase circle: theory (lines) and measured states")
    states = measured_states(material)
    ratio = material.result.mass_ratio
    if states is None or ratio is None:
        say_instead(axes, why_no_states(material))
        return
    count = collision_count(ratio)
    draw_phase_circle(axes, ratio, 1, count, Look(GREY, 0.55, points=False))
    _draw_states(axes, material, states)
    points = np.column_stack([states.scaled_heavy, states.scaled_light])
    step = 1 if len(points) <= MOST_NUMBERS else 5
    number_points(axes, points[::step], states.number[::step], size=9)
    axes.text(
        0.0,
        0.06,
        f"M : m = {ratio:.4g} : 1\ntheory counts {_counts(material, ratio)}",
        ha="center",
        va="bottom",
        fontsize=11,
        bbox=_PAPER,
    )
    axes.text(0.97, -0.03, "stops here", ha="right", va="top", fontsize=9, color=BLUE)
    if float(states.swing_energy.max()) > SWING_WORTH_A_WORD:
        axes.text(
            0.0,
            -0.12,
            "inside the circle: the swing\nholds part of the energy",
            ha="center",
            va="top",
            fontsize=9,
            bbox=_PAPER,
        )


def _counts(material: Material, ratio: float) -> str:
    """Say the counts of the theory within two standard uncertainties of the mass ratio."""
    spread = 1 + 2 * (material.result.mass_ratio_sigma or 0.0) / ratio
    low, high = collision_count(ratio / spread), collision_count(ratio * spread)
    if low == high:
        return str(low)
    return f"{low} or {high}" if high == low + 1 else f"{low} to {high}"


def say_instead(axes: Axes, sentence: str) -> None:
    """Fill a panel that cannot be drawn with the reason."""
    axes.set_axis_off()
    axes.text(0.5, 0.5, sentence, transform=axes.transAxes, ha="center", va="center", fontsize=12)


def _draw_states(axes: Axes, material: Material, states: States) -> None:
    axes.plot(
        states.scaled_heavy[0],
        states.scaled_light[0],
        "^",
        color="black",
        markersize=8,
        gid="state",
        zorder=4,
    )
    kinds = [collision.kind for collision in material.burst]
    for kind, mark in MARKS.items():
        chosen = np.array([False, *(k == kind for k in kinds)])
        if chosen.any():
            axes.plot(
                states.scaled_heavy[chosen],
                states.scaled_light[chosen],
                mark.shape,
                color=mark.colour,
                markeredgecolor="white",
                markersize=7,
                gid="state",
                zorder=4,
            )

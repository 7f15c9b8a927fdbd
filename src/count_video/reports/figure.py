"""Whole pictures: of a trial, with each panel alone, of the theory, and of a campaign.

That of a trial has the space-time image with tracks and collisions on the left, whole and enlarged,
above the velocities; on the right the phase circle and the energy.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc
from matplotlib.ticker import MaxNLocator

from count_video.physics.theory import collision_count, theta_rad
from count_video.reports.campaign import CampaignSummary, Summary, TrialRow, theory_words
from count_video.reports.drawing import (
    BLUE,
    DOTS_PER_INCH,
    HALO,
    MEDIA_TYPES,
    PAPER,
    SKY_BLUE,
    VERMILION,
    drawable,
    figure_of,
    number_marks,
    picture_bytes,
    styled,
)
from count_video.reports.material import Material
from count_video.reports.page import campaign_page
from count_video.reports.panels import TIME, draw_phase_circle, draw_space_time, panels_of
from count_video.reports.plan_text import plain
from count_video.reports.text import answer_words, review_words
from count_video.reports.words import plural, ratio_words, shortened


def add_legend(figure: Figure, axes: Axes, title: str | None = None, columns: int = 4) -> None:
    """Say below a figure what the lines and marks of a panel mean."""
    style: Any = {"loc": "outside lower center", "ncols": columns, "markerscale": 1.2}
    legend = figure.legend(*axes.get_legend_handles_labels(), title=title, **style)
    legend.get_title().set_parse_math(False)


def trial_figure(material: Material) -> Figure:
    """Draw the picture of a trial."""
    result = material.result
    title = answer_words(result) + review_words(result)
    if result.count is not None and result.mass_ratio is not None:
        title += f" at a mass ratio of {shortened(result.mass_ratio)}"
    shown = panels_of(material)
    columns = [["space-time", "enlarged" if "enlarged" in shown else "space-time", "velocities"]]
    if "energy" in shown:
        columns.append(["phase-circle", "phase-circle", "energy"])
    with figure_of(16.0, 10.5) as figure:
        figure.suptitle(title, fontsize=20, weight="bold")
        panels = figure.subplot_mosaic(
            np.transpose(columns).tolist(),
            width_ratios=[1.75, 1][: len(columns)],
            height_ratios=[1, 1.4, 1.25],
        )
        for name, axes in panels.items():
            shown[name](axes, material)
        add_legend(figure, panels["space-time"], drawable(Path(result.clip).name))
    return figure


def time_panels(figure: Figure) -> list[dict[str, list[float]]]:
    """Return where on the picture of a trial time runs to the right, and which frames it shows.

    ``box`` is left, top, right and bottom as shares of the picture's width and height; ``frames``
    the frame coordinates at its left and right.
    """
    panels = []
    for axes in figure.axes:
        if axes.get_gid() == TIME:
            (left, bottom), (right, top) = axes.get_position().get_points()
            box = [round(float(share), 6) for share in (left, 1 - top, right, 1 - bottom)]
            panels.append({"box": box, "frames": [float(end) for end in axes.get_xlim()]})
    return panels


def panel_figures(material: Material) -> dict[str, Figure]:
    """Draw each panel as a figure of its own, by the name that its file gets."""
    figures = {}
    for name, draw in panels_of(material).items():
        with figure_of(10.0, 6.0) as figures[name]:
            axes = figures[name].add_subplot()
            draw(axes, material)
            if axes.get_gid() == TIME:
                add_legend(figures[name], axes, columns=3)
    return figures


def thumbnail_jpeg(material: Material) -> bytes:
    """Draw the whole of a trial in small, for lists: tracks and marks, no letters."""
    with styled():
        figure = Figure(figsize=(480 / DOTS_PER_INCH, 130 / DOTS_PER_INCH))
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        draw_space_time(axes, material, material.shown_frames, size=14)
        axes.set_axis_off()
        return picture_bytes(figure, "jpeg")


# ---- the theory --------------------------------------------------------------------------------


def theory_figure(heavy: Fraction, light: Fraction) -> Figure:
    """Draw the phase circle with its state points and angles; above it the exact count.

    The masses are in any one unit.
    """
    with figure_of(10.0, 10.5) as figure:
        figure.suptitle(f"{collision_count(heavy, light):.10g} collisions", fontsize=30)
        axes = figure.add_subplot()
        points = draw_phase_circle(axes, heavy, light)
        x, y = points.T
        axes.scatter(x, y, s=25, color="black", zorder=3, gid="state points")
        step = max(1, -(-len(points) // 45))
        places = list(enumerate(map(tuple, points.tolist())))[::step]
        number_marks(axes, [(f"({number})", at, at) for number, at in places])
        _draw_angles(axes, theta_rad(heavy, light))
        axes.set_title(f"m : M = 1 : {plain(heavy / light)}", fontsize=18)
        if not points.size:
            axes.text(0, -0.5, "state points:\ntoo many to draw", ha="center")
    return figure


def _draw_angles(axes: Axes, theta: float) -> None:
    """Draw the step along the circle and the opening of the region where the collisions end."""
    alpha = float(np.degrees(2 * theta))
    axes.add_patch(Arc((0, 0), 0.5, 0.5, theta1=180 - alpha, theta2=180, color=BLUE, linewidth=2))
    axes.plot([0, np.cos(np.pi - 2 * theta)], [0, np.sin(np.pi - 2 * theta)], color=BLUE, lw=1)
    for letter, angle, radius in (("α", np.pi - theta, 0.32), ("θ", theta / 2, 0.62)):
        place = (radius * np.cos(angle), radius * np.sin(angle))
        axes.text(*place, letter, fontsize=15, color=BLUE, ha="center", va="center", bbox=PAPER)


# ---- a campaign --------------------------------------------------------------------------------


def campaign_figure(summary: CampaignSummary) -> Figure:
    """Draw the histogram of the counts of each mass ratio against the theory."""
    groups = summary.groups
    with figure_of(9.0, 5.0 * len(groups)) as figure:
        panels = figure.subplots(len(groups), squeeze=False).flat
        for axes, group in zip(panels, groups, strict=True):
            ratio = f", mass ratio {ratio_words(group.mass_ratio)}" if len(groups) > 1 else ""
            axes.set_title(f"Counts of {plural(group.counted, 'trial')}{ratio}")
            _draw_histogram(axes, group)
    return figure


def _draw_histogram(axes: Axes, group: Summary) -> None:
    theories = group.theories
    shown = [*group.histogram, *theories[:1], *theories[-1:]]
    axes.set_xlabel("collisions counted")
    axes.set_ylabel("trials")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(integer=True))
    if not shown:
        return
    trials = list(group.histogram.values())
    bars = axes.bar(list(group.histogram), trials, color=SKY_BLUE, label="trials", gid="bar")
    axes.bar_label(bars, padding=3, path_effects=list(HALO))
    for count in {theories[0], theories[-1]} if theories else ():
        label = f"theory: {theory_words(group)}" if count == theories[0] else None
        axes.axvline(count, color=VERMILION, linestyle="--", linewidth=2, label=label)
    if group.mean is not None:
        label = f"mean: {group.mean:.2f}"
        axes.axvline(group.mean, color="black", linestyle=":", linewidth=2, label=label)
    axes.set_xlim(min(shown) - 1.5, max(shown) + 1.5)
    axes.set_ylim(0, 1.15 * max([*trials, 1]))
    axes.legend(loc="best")


def campaign_files(
    rows: Sequence[TrialRow], summary: CampaignSummary, picture_format: str = "png"
) -> dict[str, bytes]:
    """Draw and write ``campaign.png`` (or ``.svg``) and ``campaign.html``: contents by names."""
    picture = picture_bytes(campaign_figure(summary), picture_format)
    page = campaign_page(rows, summary, (picture, MEDIA_TYPES[picture_format]))
    return {f"campaign.{picture_format}": picture, "campaign.html": page.encode("utf-8")}

"""The picture of a trial: what was seen, what it means, on one sheet, and each panel alone.

Left the space-time image with tracks and collisions, whole and enlarged, and the velocities;
right the phase circle and the energy.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from count_video.reports.drawing import (
    drawable,
    picture_bytes,
    place_numbers,
    styled,
)
from count_video.reports.material import (
    Material,
)
from count_video.reports.panels import (
    TIME,
    draw_energy,
    draw_enlarged,
    draw_space_time,
    draw_states,
    draw_velocities,
    draw_whole,
    legend_handles,
    worth_enlarging,
)
from count_video.reports.words import plural

PANELS = ("space-time", "enlarged", "velocities", "phase-circle", "energy")
"""Names of the panels that may get files of their own."""
SIZE_INCHES = (16.0, 10.5)
PANEL_INCHES = (10.0, 6.0)
THUMBNAIL_PX = (480, 130)


def trial_figure(material: Material) -> Figure:
    """Draw the picture of a trial."""
    with styled():
        figure = Figure(figsize=SIZE_INCHES)
        figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.1)
        figure.suptitle(_headline(material), fontsize=20, weight="bold")
        columns = figure.add_gridspec(1, 2, width_ratios=[1.75, 1])
        left, right = columns[0], columns[1].subgridspec(2, 1, height_ratios=[1.6, 1])
        if worth_enlarging(material):
            rows = left.subgridspec(3, 1, height_ratios=[1, 1.5, 1.15])
            draw_whole(figure.add_subplot(rows[0]), material)
            enlarged = figure.add_subplot(rows[1])
            draw_enlarged(enlarged, material)
        else:
            rows = left.subgridspec(3, 1, height_ratios=[1.25, 1.25, 1.15])
            enlarged = figure.add_subplot(rows[:2])
            draw_whole(enlarged, material)
        draw_velocities(figure.add_subplot(rows[2], sharex=enlarged), material)
        draw_states(figure.add_subplot(right[0]), material)
        draw_energy(figure.add_subplot(right[1]), material)
        legend = figure.legend(
            handles=legend_handles(material),
            loc="outside lower center",
            ncols=6,
            title=drawable(Path(material.result.clip).name),
        )
        legend.get_title().set_parse_math(False)
        place_numbers(figure)
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
            box = [float(share) for share in (left, 1 - top, right, 1 - bottom)]
            panels.append({"box": box, "frames": [float(end) for end in axes.get_xlim()]})
    return panels


def panel_figures(material: Material) -> dict[str, Figure]:
    """Draw each panel as a figure of its own, by the name that its file gets."""
    panels: Mapping[str, Callable[[Axes, Material], object]] = {
        "space-time": draw_whole,
        **({"enlarged": draw_enlarged} if worth_enlarging(material) else {}),
        "velocities": draw_velocities,
        "phase-circle": draw_states,
        "energy": draw_energy,
    }
    figures = {}
    with styled():
        for name, draw in panels.items():
            figure = Figure(figsize=PANEL_INCHES, layout="constrained")
            draw(figure.add_subplot(), material)
            if name in ("space-time", "enlarged", "velocities"):
                figure.legend(handles=legend_handles(material), loc="outside lower center", ncols=4)
            place_numbers(figure)
            figures[name] = figure
    return figures


def thumbnail_jpeg(material: Material) -> bytes:
    """Draw the whole of a trial in small, for lists: tracks and marks, no letters."""
    with styled():
        width, height = THUMBNAIL_PX
        figure = Figure(figsize=(width / 100, height / 100), dpi=100)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        draw_space_time(axes, material, material.shown_frames, size=14)
        axes.set_axis_off()
        target = io.BytesIO()
        Image.open(io.BytesIO(picture_bytes(figure, "png"))).convert("RGB").resize(
            THUMBNAIL_PX, Image.Resampling.LANCZOS
        ).save(target, "JPEG", quality=85)
    return target.getvalue()


def _headline(material: Material) -> str:
    result = material.result
    if result.count is None:
        return "not counted"
    text = plural(result.count, "collision")
    if result.reviewed_count is not None:
        text += f", {result.reviewed_count} after review"
    if result.mass_ratio is not None:
        text += f" at a mass ratio of {result.mass_ratio:.4g}"
    return text

"""The picture of a trial: what was seen, what it means, on one sheet.

Left the space-time image with tracks and collisions, whole and enlarged, and the velocities;
right the phase circle and the energy.
"""

from __future__ import annotations

from matplotlib.figure import Figure

from count_video.reports.drawing import drawable, styled
from count_video.reports.material import Material
from count_video.reports.picture_energy import draw_energy
from count_video.reports.picture_phase import draw_measured_phase_circle
from count_video.reports.picture_space_time import draw_space_time, legend_handles
from count_video.reports.picture_velocity import draw_velocities
from count_video.reports.stretch import crowded_frames, shown_frames
from count_video.reports.text import headline

SIZE_INCHES = (16.0, 10.5)


def trial_figure(material: Material) -> Figure:
    """Draw the picture of a trial."""
    with styled():
        figure = Figure(figsize=SIZE_INCHES)
        figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.1)
        figure.suptitle(
            drawable(headline(material.result)), fontsize=20, weight="bold", parse_math=False
        )
        columns = figure.add_gridspec(1, 2, width_ratios=[1.75, 1])
        rows = columns[0].subgridspec(3, 1, height_ratios=[1, 1.5, 1.15])
        whole, crowd = figure.add_subplot(rows[0]), figure.add_subplot(rows[1])
        velocities = figure.add_subplot(rows[2], sharex=crowd)
        circle_and_energy = columns[1].subgridspec(2, 1, height_ratios=[1.6, 1])
        crowded = crowded_frames(material)
        draw_space_time(whole, material, shown_frames(material), enlarged=crowded)
        draw_space_time(crowd, material, crowded)
        draw_velocities(velocities, material, crowded)
        draw_measured_phase_circle(figure.add_subplot(circle_and_energy[0]), material)
        draw_energy(figure.add_subplot(circle_and_energy[1]), material)
        figure.legend(handles=legend_handles(material), loc="outside lower center", ncols=6)
        return figure

"""The picture of a plan: its map, and the planned trial as a measured one is drawn."""

from __future__ import annotations

from matplotlib.figure import Figure

from count_video.planning.whole import Plan
from count_video.reports.drawing import drawable, styled
from count_video.reports.picture_phase import draw_measured_phase_circle
from count_video.reports.picture_plan_map import draw_plan_map
from count_video.reports.picture_space_time import draw_space_time, legend_handles
from count_video.reports.plan_material import planned_material
from count_video.reports.plan_text import plan_headline
from count_video.reports.stretch import crowded_frames, shown_frames

SIZE_INCHES = (16.0, 12.0)


def plan_figure(plan: Plan) -> Figure:
    """Draw the map above the space-time picture, and the phase circle."""
    material = planned_material(plan)
    with styled():
        figure = Figure(figsize=SIZE_INCHES)
        figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.1)
        title = f"Plan: {plan_headline(plan)}"
        figure.suptitle(drawable(title), fontsize=20, weight="bold", parse_math=False)
        rows = figure.add_gridspec(2, 1, height_ratios=[1.25, 1])
        above = rows[0].subgridspec(1, 2, width_ratios=[1.25, 1])
        below = rows[1].subgridspec(1, 2, width_ratios=[1, 1])
        if plan.chart is not None:
            draw_plan_map(figure.add_subplot(above[0]), plan, plan.chart)
        circle = figure.add_subplot(above[1])
        draw_measured_phase_circle(circle, material)
        circle.set_title("Phase circle: theory (lines) and planned states")
        crowded = crowded_frames(material)
        whole, crowd = figure.add_subplot(below[0]), figure.add_subplot(below[1])
        draw_space_time(whole, material, shown_frames(material), enlarged=crowded)
        whole.set_title("Space and time: the wall at the bottom, the framed part at the right")
        whole.set_xlabel("frame, from the release")
        draw_space_time(crowd, material, crowded)
        crowd.tick_params(labelbottom=True)
        crowd.set_xlabel("frame, from the release")
        figure.legend(handles=legend_handles(material), loc="outside lower center", ncols=6)
        return figure

"""The structure of the pictures: what is drawn where, how often, with which words and limits."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from evidence_made import CLIP, Made
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from PIL import Image
from PIL.ImageColor import getrgb

from count_video.batch.summary import summarise
from count_video.reports.drawing import MARKS, drawable, picture_bytes
from count_video.reports.figure import (
    campaign_figure,
    panel_figures,
    theory_figure,
    thumbnail_jpeg,
    trial_figure,
)
from count_video.reports.material import Material
from count_video.reports.panels import TIME
from count_video.video.reader import open_footage
from table_rows import row, rows_of
from tiers import rest_slow

PNG, SVG = b"\x89PNG\r\n\x1a\n", b"<?xml"


@pytest.fixture(scope="module")
def material(made: Made) -> Material:
    trial = made.trial
    assert trial.track is not None
    empty = Material(trial.result, trial.track)
    with open_footage(CLIP) as footage:
        lines = [empty.line_of_motion(frame.luma, frame.index) for frame in footage.frames()]
    return replace(empty, lines=lines)


@pytest.fixture(scope="module")
def figure(material: Material) -> Figure:
    return trial_figure(material)


def panel(figure: Figure, title: str) -> Axes:
    (found,) = [axes for axes in figure.axes if axes.get_title(loc="left").startswith(title)]
    return found


def marks(axes: Axes, gid: str = "collision") -> Iterator[tuple[float, float]]:
    for collection in axes.collections:
        if collection.get_gid() == gid:
            yield from (tuple(place) for place in np.asarray(collection.get_offsets()))


def numbers(axes: Axes) -> list[str]:
    return [
        text.get_text() for text in axes.texts if text.get_gid() == "number" and text.get_visible()
    ]


def test_the_whole_picture_has_a_mark_for_every_collision(
    figure: Figure, material: Material
) -> None:
    drawn = sorted(marks(panel(figure, "Space and time")))
    assert len(drawn) == material.result.count == 12
    assert [x for x, _ in drawn] == [c.frame for c in material.result.collisions]


def test_the_two_kinds_differ_in_colour_and_in_shape() -> None:
    bodies, wall = MARKS["bodies"], MARKS["wall"]
    assert bodies.shape != wall.shape
    # In grey, as a printer without colours has it, they differ as well.
    grey = [np.dot(getrgb(mark.colour), (0.299, 0.587, 0.114)) for mark in (bodies, wall)]
    assert abs(grey[0] - grey[1]) > 20


def test_inferred_collisions_are_hollow(material: Material) -> None:
    guessed = [replace(c, seen=c.number != 5) for c in material.result.collisions]
    result = replace(material.result, collisions=tuple(guessed))
    axes = panel(trial_figure(replace(material, result=result)), "Space and time")
    hollow = [c for c in axes.collections if np.all(np.asarray(c.get_facecolor())[0] == 1.0)]
    assert sum(len(c.get_offsets()) for c in hollow) == 1


def test_the_enlarged_part_numbers_every_collision_that_it_shows(
    figure: Figure, material: Material
) -> None:
    axes = panel(figure, "Enlarged")
    low, high = material.dense_frames
    inside = [str(c.number) for c in material.result.collisions if low <= c.frame <= high]
    assert numbers(axes) == inside
    assert len(inside) >= round(0.6 * len(material.result.collisions))
    assert axes.get_xlim() == (low, high)


@pytest.mark.parametrize("closeness", [1.0, 0.3])
def test_no_number_lies_on_another_and_each_is_nearest_to_its_own_mark(
    material: Material, closeness: float
) -> None:
    closer = tuple(
        replace(c, frame=120.0 + closeness * (c.frame - 120.0)) for c in material.result.collisions
    )
    figure = trial_figure(replace(material, result=replace(material.result, collisions=closer)))
    for axes in figure.axes:
        shown = [text for text in axes.texts if isinstance(text, Annotation)]
        drawn = [*marks(axes), *marks(axes, "beyond"), *marks(axes, "state")]
        places = axes.transData.transform(drawn) if drawn else np.empty(0)
        numbered = [text for text in shown if text.get_gid() == "number" and text.get_visible()]
        boxes = [text.get_window_extent() for text in numbered]
        assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))
        for text, box in zip(numbered, boxes, strict=True):
            middle = (box.get_points()[0] + box.get_points()[1]) / 2
            assert drawn[int(np.argmin(np.hypot(*(places - middle).T)))] == text.xy


def test_a_trial_without_a_dense_part_is_not_enlarged(material: Material) -> None:
    three = material.result.collisions[:3]
    frames = (40.0, 120.0, 200.0)
    spread = tuple(replace(c, frame=frame) for c, frame in zip(three, frames, strict=True))
    result = replace(material.result, collisions=spread, count=3)
    titles = [
        axes.get_title(loc="left") for axes in trial_figure(replace(material, result=result)).axes
    ]
    assert not any(title.startswith("Enlarged") for title in titles)
    assert "enlarged" not in panel_figures(replace(material, result=result))


def test_frames_are_marked_by_whole_numbers(material: Material) -> None:
    one = replace(material.result, collisions=material.result.collisions[:1], count=1)
    short = trial_figure(replace(material, result=one)).axes
    ticks = [axes.get_xticks() for axes in short if axes.get_gid() == TIME]
    assert len(ticks) == 2
    assert all(float(tick).is_integer() for own in ticks for tick in own)


def test_each_panel_is_a_picture_of_its_own(material: Material) -> None:
    panels = panel_figures(material)
    assert list(panels) == ["space-time", "enlarged", "velocities", "phase-circle", "energy"]
    for figure in panels.values():
        assert picture_bytes(figure, "png").startswith(PNG)


def test_the_title_is_the_answer_and_the_clips_name_stands_below(figure: Figure) -> None:
    assert figure.get_suptitle().startswith("12 collisions")
    assert CLIP.name not in figure.get_suptitle()
    assert [legend.get_title().get_text() for legend in figure.legends] == [CLIP.name]


def test_letters_of_an_svg_are_letters(figure: Figure) -> None:
    assert "12 collisions" in picture_bytes(figure, "svg").decode("utf-8")


def test_axes_say_what_they_show_and_in_which_unit(figure: Figure) -> None:
    whole, enlarged = panel(figure, "Space and time"), panel(figure, "Enlarged")
    assert "(px)" in whole.get_ylabel()
    assert "(px)" in enlarged.get_ylabel()
    assert "(m/s)" in panel(figure, "Velocities").get_ylabel()
    for axes in (whole, enlarged, panel(figure, "Velocities")):
        assert axes.get_xlabel() == "frame"
    assert "V₁" in panel(figure, "Phase circle").get_xlabel()
    assert "(%" in panel(figure, "Energy").get_ylabel()
    units = [axis.get_ylabel() for axis in whole.child_axes]
    units += [axis.get_xlabel() for axis in whole.child_axes]
    assert "from the wall (mm)" in units
    assert "time (ms)" in units


def test_the_picture_shows_all_collisions_and_not_much_more(
    figure: Figure, material: Material
) -> None:
    low, high = panel(figure, "Space and time").get_xlim()
    frames = [c.frame for c in material.result.collisions]
    assert low <= frames[0] < frames[-1] <= high
    assert (low, high) == material.shown_frames
    assert high - low <= 1.3 * (frames[-1] - frames[0]) + 20


def test_the_wall_is_at_the_bottom_on_whichever_side_it_stands(
    material: Material, figure: Figure
) -> None:
    left = panel(figure, "Space and time").get_ylim()
    other = replace(material, track=replace(material.track, wall_side="right"))
    right = panel(trial_figure(other), "Space and time").get_ylim()
    assert left[0] < left[1]
    assert right[0] > right[1]


def test_the_measured_states_start_on_the_circle_and_keep_their_energy(
    figure: Figure, material: Material
) -> None:
    axes = panel(figure, "Phase circle")
    x, y = np.array(list(marks(axes, "state"))).T
    assert len(x) == len(material.result.collisions) + 1
    assert np.isclose(np.hypot(x, y), 1.0).any()
    (total,) = [line for line in panel(figure, "Energy").lines if line.get_gid() == "total"]
    energy = np.asarray(total.get_ydata(), float)
    assert energy[0] == pytest.approx(100.0)
    kept = np.array(material.result.energy_kept)
    # Places are measured, energies are those of the fit.
    np.testing.assert_allclose(energy[1:], 100 * kept, atol=1.0)


def bars(axes: Axes, name: str) -> np.ndarray:
    """Half the lengths of the vertical bars around the points of a name, shape (n,)."""
    drawn = [one for one in axes.containers if isinstance(one, ErrorbarContainer)]
    (found,) = [one for one in drawn if one.get_label() == name]
    (segments,) = (np.array(lines.get_segments()) for lines in found[2])
    return np.asarray(np.ptp(segments[:, :, 1], axis=1) / 2)


def test_velocities_and_energies_have_bars_of_their_standard_uncertainty(
    figure: Figure, material: Material
) -> None:
    sides = [v for c in material.result.collisions for v in (c.velocity_before, c.velocity_after)]
    sigma = np.array([(v.ball_sigma_px_frame, v.heavy_sigma_px_frame) for v in sides])
    assert np.isfinite(sigma).all()
    assert sigma[0, 0] == 0.0  # the model has the ball at rest before the first collision
    assert sigma.ravel()[1:].min() > 0
    speed, unit = material.speed_scale
    assert unit == "m/s"
    velocities = panel(figure, "Velocities")
    assert bars(velocities, "ball") == pytest.approx(sigma[:, 0] * speed)
    assert bars(velocities, "cylinder") == pytest.approx(sigma[:, 1] * speed)
    states = material.states
    assert states is not None
    assert states.swing_energy is not None
    first = 1 + states.swing_energy[0]
    wanted = 200 * np.abs(states.scaled[1]) * states.sigma[1] / first
    assert bars(panel(figure, "Energy"), "ball, moving") == pytest.approx(wanted, abs=1e-9)


def test_without_a_mass_ratio_the_panels_say_what_they_need(material: Material) -> None:
    figure = trial_figure(replace(material, result=replace(material.result, mass_ratio=None)))
    for title in ("Phase circle", "Energy"):
        assert any("--masses" in text.get_text() for text in panel(figure, title).texts)


def test_the_picture_of_one_body_has_no_panel_that_needs_two(material: Material) -> None:
    alone = replace(material, track=replace(material.track, heavy=None))
    titles = " ".join(axes.get_title(loc="left") for axes in trial_figure(alone).axes)
    assert "Space and time" in titles
    assert "Velocities" in titles
    assert "Phase circle" not in titles
    assert "Energy" not in titles


def test_a_clip_without_collisions_has_a_picture(material: Material) -> None:
    nothing = replace(material.result, collisions=(), count=None, seen=0, status="not_counted")
    figure = trial_figure(replace(material, result=nothing))
    assert list(marks(panel(figure, "Space and time"))) == []
    assert picture_bytes(figure, "png").startswith(PNG)


@pytest.mark.parametrize(("picture_format", "beginning"), rest_slow([("svg", SVG), ("png", PNG)]))
def test_the_same_material_gives_the_same_bytes(
    material: Material, picture_format: str, beginning: bytes
) -> None:
    first, second = (picture_bytes(trial_figure(material), picture_format) for _ in range(2))
    assert first == second
    assert first.startswith(beginning)


def test_a_clip_name_is_drawn_as_it_is_whatever_it_holds(material: Material) -> None:
    name = "$x$ 球 \udcff <b>.mp4"
    figure = trial_figure(replace(material, result=replace(material.result, clip=name)))
    assert picture_bytes(figure, "png").startswith(PNG)
    assert drawable(name) == "$x$ ? \\udcff <b>.mp4"


def test_the_evidence_is_a_png_unless_an_svg_is_asked_for(made: Made) -> None:
    assert made.file("png").read_bytes().startswith(PNG)
    assert not made.file("svg").exists()
    assert made.file("strip.jpg").read_bytes().startswith(b"\xff\xd8")


def test_the_small_picture_is_as_large_as_lists_show_it(material: Material) -> None:
    with Image.open(io.BytesIO(thumbnail_jpeg(material))) as picture:
        assert (picture.format, picture.size) == ("JPEG", (480, 130))


@pytest.mark.parametrize(("heavy", "count"), [(1, 3), (100, 31)])
def test_the_theory_numbers_every_state_point_as_the_paper_does(heavy: int, count: int) -> None:
    axes = theory_figure(Fraction(heavy), Fraction(1)).axes[0]
    assert numbers(axes) == [f"({k})" for k in range(count + 1)]
    lines = {
        gid: sum(line.get_gid() == gid for line in axes.lines) for gid in ("momentum", "mirror")
    }
    assert lines == {"momentum": -(-count // 2), "mirror": count // 2}
    assert {patch.get_gid() for patch in axes.patches} >= {"stopping", "circle"}


def test_momentum_lines_have_the_slope_of_the_masses() -> None:
    axes = theory_figure(Fraction(1050), Fraction("10.5")).axes[0]
    for line in axes.lines:
        if line.get_gid() == "momentum":
            (x0, y0), (x1, y1) = line.get_xydata()
            assert y1 - y0 == pytest.approx(-10.0 * (x1 - x0), rel=1e-9)


def test_a_theory_with_too_many_points_says_so() -> None:
    axes = theory_figure(Fraction(10**8), Fraction(1)).axes[0]
    assert numbers(axes) == []
    assert any("too many to draw" in text.get_text() for text in axes.texts)


def test_the_histogram_has_a_bar_a_count_and_the_theory() -> None:
    histogram = {28: 1, 29: 3, 30: 4, 31: 22}
    axes = campaign_figure(summarise(rows_of(histogram))).axes[0]
    heights = {round(bar.get_x() + bar.get_width() / 2): bar.get_height() for bar in axes.patches}
    assert heights == histogram
    assert "theory: 31" in [line.get_label() for line in axes.lines]
    assert [text.get_text() for text in axes.texts] == ["1", "3", "4", "22"]
    assert all(text.get_bbox_patch() is None for text in axes.texts), "no box hides bars and lines"
    assert picture_bytes(campaign_figure(summarise([])), "png").startswith(PNG)


def test_a_theory_of_very_many_collisions_adds_no_bars() -> None:
    axes = campaign_figure(summarise([row("a", 31, mass_ratio=1e12)])).axes[0]
    assert [bar.get_height() for bar in axes.patches] == [1]
    assert axes.get_xlim()[1] > math.pi * 1e6


def test_bodies_of_different_masses_have_a_histogram_each() -> None:
    rows = [row("a", 31, mass_ratio=100.0), row("b", 12, mass_ratio=16.0, mass_ratio_sigma=0.1)]
    titles = [axes.get_title(loc="left") for axes in campaign_figure(summarise(rows)).axes]
    assert titles == [
        "Counts of 1 trial, mass ratio 16.00 ± 0.10",
        "Counts of 1 trial, mass ratio 100.0 ± 1.0",
    ]


@pytest.mark.parametrize(("upright", "way"), [(False, "to the right"), (True, "downward")])
def test_pictures_of_two_bodies_without_a_wall_speak_of_none(
    material: Material, upright: bool, way: str
) -> None:
    result = replace(material.result, wall_side=None, mass_ratio=None, upright=upright)
    free = replace(material, result=result)
    drawn = trial_figure(free)
    written = [text.get_text() for axes in drawn.axes for text in axes.texts]
    labels = [label for axes in drawn.axes for label in (axes.get_title("left"), axes.get_ylabel())]

    assert list(panel_figures(free)) == ["space-time", "enlarged", "velocities"]
    assert [label for label in labels if "wall" in label] == []
    assert any(label.endswith(f"{way} is up") for label in labels)
    assert not any("--masses" in text for text in written)

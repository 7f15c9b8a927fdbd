from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filming import BARE, CoverageCamera, edge_px, small_scene

from synth_video.appearance import BallSettings
from synth_video.body_picture import BodyPicture
from synth_video.moving_layers import STEPS_OF_A_TURN, Spinning
from synth_video.paint_bodies import BallView, paint_ball

EXACT_PX = 1e-3
"""Rounding of float32 cells, summed over an edge of some ten pixels of up to 255."""
CHORD_PX = 0.012
"""A row one pixel high meets a round body at its chord; see test_subpixel_coverage.py."""
STEPS_M = np.linspace(0.0, 0.0013, 5)
STRAIGHT = {"block": EXACT_PX, "cart": EXACT_PX, "puck": CHORD_PX}
SPUN = BallSettings(spin_hz=2.0, ring=False)
VIEW = BallView(diameter_px=24.0, tilt_deg=0.0, blur_px=0.5, cells_per_px=4)


@pytest.mark.parametrize("shape", STRAIGHT)
@pytest.mark.parametrize("side", [-1, 1])
def test_the_faces_of_a_light_body_are_seen_where_they_are(shape: str, side: int) -> None:
    camera = CoverageCamera(small_scene("paper", *BARE, f"ball.shape={shape}"))
    for step_m in STEPS_M:
        body_m = 0.06 + step_m
        row = camera.coverage(np.array([body_m]), np.array([0.15]))[camera.row_of(body_m)]
        face = float(camera.projection.tilted(np.array(body_m + side * 0.020), np.array(0.0))[0])
        middle = round(face)
        seen = edge_px(row, middle + 8 * side, middle - 8 * side)
        assert seen == pytest.approx(face, abs=STRAIGHT[shape])


@pytest.mark.parametrize("shape", STRAIGHT)
def test_the_face_of_a_heavy_body_is_seen_where_it_is(shape: str) -> None:
    camera = CoverageCamera(small_scene("paper", *BARE, f"cylinder.shape={shape}"))
    for step_m in STEPS_M:
        heavy_m = 0.15 + step_m
        row = camera.coverage(np.array([0.05]), np.array([heavy_m]))[camera.row_of(heavy_m)]
        face = float(camera.projection.tilted(np.array(heavy_m), np.array(0.0))[0])
        middle = round(face)
        assert edge_px(row, middle - 8, middle + 8) == pytest.approx(face, abs=STRAIGHT[shape])


@pytest.mark.parametrize("axis", ["upright", "sight"])
def test_a_turn_moves_what_is_printed_and_never_the_outline(axis: str) -> None:
    ball = BallSettings(spin_axis=axis, ring=False)  # type: ignore[arg-type]
    still, turned, whole = (paint_ball(ball, VIEW, turn).cells for turn in (0.0, 1.0, 2 * np.pi))
    assert np.array_equal(still[..., 3], turned[..., 3])
    assert np.abs(still - turned).max() > 30
    assert whole == pytest.approx(still, abs=1e-2)


def test_half_a_turn_about_the_thread_shows_the_other_half() -> None:
    halves = replace(SPUN, pattern="halves", color=(10, 10, 10), mark_color=(240, 240, 240))
    views = [paint_ball(halves, VIEW, turn).cells[..., 0] for turn in (np.pi / 2, -np.pi / 2)]
    middle = views[0].shape[0] // 2
    dark, bright = sorted(float(view[middle, middle]) for view in views)
    assert dark < 60
    assert bright > 150


def test_stripes_lie_across_the_line_of_motion() -> None:
    striped = BallSettings(pattern="stripes", gloss=0.0, ring=False)
    plain = BallSettings(pattern="plain", gloss=0.0, ring=False)
    marks = paint_ball(striped, VIEW).cells[..., 0] - paint_ball(plain, VIEW).cells[..., 0]
    middle = marks.shape[0] // 2
    along, across = np.abs(np.diff(marks[middle])).sum(), np.abs(np.diff(marks[:, middle])).sum()
    assert along > 3 * across


def test_a_turning_body_is_painted_once_a_step() -> None:
    painted: list[float] = []

    def paint(turn_rad: float) -> BodyPicture:
        painted.append(turn_rad)
        return paint_ball(SPUN, VIEW, turn_rad)

    spinning = Spinning(paint, spin_hz=2.0)
    first = spinning.at(0.0)
    assert spinning.at(0.5) is first  # a whole turn later
    assert spinning.at(0.25) is not first
    assert painted == pytest.approx([0.0, np.pi], abs=2 * np.pi / STEPS_OF_A_TURN)

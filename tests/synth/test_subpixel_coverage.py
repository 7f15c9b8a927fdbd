from __future__ import annotations

import numpy as np
import pytest
from filming import BARE, CoverageCamera, edge_px, small_scene

EXACT_PX = 1e-3
"""Rounding of float32 cells, summed over an edge of some ten pixels of up to 255."""
CHORD_PX = 0.012
"""A row one pixel high, seen through a lens blur of 0.5 px, meets a ball of radius 21 px at its
chord: (1/12 + 0.5**2) / (2 * 21) px inside the tangent, and that again for the anchor's row."""
STEPS_M = np.linspace(0.0, 0.0013, 9)
"""Covers a little more than one pixel, at steps that are no multiple of a cell."""


@pytest.mark.parametrize("tilt_deg", [0.0, 6.0, -3.0])
def test_the_cylinders_face_is_seen_where_it_is(tilt_deg: float) -> None:
    camera = CoverageCamera(small_scene("paper", *BARE, f"camera.tilt_deg={tilt_deg}"))
    seen, true = [], []
    for step_m in STEPS_M:
        heavy_m = 0.15 + step_m
        cover = camera.coverage(np.array([0.05]), np.array([heavy_m]))
        x, y = camera.projection.tilted(np.array(heavy_m), np.array(0.0))
        row = camera.row_of(heavy_m)
        middle = round(float(x))
        seen.append(edge_px(cover[row], middle - 8, middle + 8))
        # A face at right angles to a tilted line leans: take it where it crosses this row.
        true.append(float(x) - (row - float(y)) * np.tan(np.radians(tilt_deg)))
    assert np.array(seen) == pytest.approx(np.array(true), abs=EXACT_PX)


@pytest.mark.parametrize("side", [-1, 1])
def test_both_faces_of_the_ball_are_seen_where_they_are(side: int) -> None:
    camera = CoverageCamera(small_scene("paper", *BARE))
    radius_m = 0.020
    for step_m in STEPS_M:
        ball_m = 0.06 + step_m
        row = camera.coverage(np.array([ball_m]), np.array([0.15]))[camera.row_of(ball_m)]
        face = camera.projection.tilted(np.array(ball_m + side * radius_m), np.array(0.0))[0]
        middle = round(float(face))
        seen = edge_px(row, middle + 8 * side, middle - 8 * side)
        assert seen == pytest.approx(float(face), abs=CHORD_PX)


def test_a_face_moves_in_the_picture_exactly_as_far_as_the_body_moves() -> None:
    camera = CoverageCamera(small_scene("paper", *BARE))
    seen = []
    for step_m in STEPS_M:
        row = camera.coverage(np.array([0.06 + step_m]), np.array([0.15]))[camera.row_of(0.06)]
        middle = round(float(camera.projection.tilted(np.array(0.04), np.array(0.0))[0]))
        seen.append(edge_px(row, middle - 8, middle + 9))
    moved_px = np.array(seen) - seen[0]
    assert moved_px == pytest.approx(STEPS_M * camera.projection.px_per_m, abs=EXACT_PX)


def test_a_steady_path_during_the_exposure_is_seen_at_its_middle() -> None:
    camera = CoverageCamera(small_scene("paper", *BARE))
    path_m = 0.15 + np.linspace(-0.002, 0.002, 40)  # 4 px, centres of equal parts
    row = camera.coverage(np.full(40, 0.05), path_m)[camera.row_of(0.15)]
    middle = camera.projection.tilted(np.array(0.15), np.array(0.0))[0]
    assert edge_px(row, round(float(middle)) - 10, round(float(middle)) + 10) == pytest.approx(
        float(middle), abs=EXACT_PX
    )


def test_a_bounce_during_the_exposure_is_seen_at_the_mean_of_the_path() -> None:
    camera = CoverageCamera(small_scene("paper", *BARE))
    path_m = 0.15 + 0.004 * np.abs((np.arange(40) + 0.5) / 40 - 0.3)
    row = camera.coverage(np.full(40, 0.05), path_m)[camera.row_of(0.15)]
    mean = float(camera.projection.tilted(path_m, np.zeros(40))[0].mean())
    assert edge_px(row, round(mean) - 10, round(mean) + 10) == pytest.approx(mean, abs=EXACT_PX)


def test_a_moving_edge_is_wider_by_the_way_it_goes() -> None:
    camera = CoverageCamera(small_scene("paper", *BARE))
    way_px = 6.0
    part = (np.arange(48) + 0.5) / 48 - 0.5

    def variance_px2(path_m: np.ndarray) -> float:
        cover = camera.coverage(np.full_like(path_m, 0.05), path_m)
        row = cover[camera.row_of(0.15)]
        middle = round(float(camera.projection.tilted(np.array(0.15), np.array(0.0))[0]))
        slope = np.diff(row[middle - 12 : middle + 12])
        place = np.arange(len(slope))
        mean = (slope * place).sum() / slope.sum()
        return float((slope * (place - mean) ** 2).sum() / slope.sum())

    still = variance_px2(np.array([0.15]))
    moved = variance_px2(0.15 + part * way_px / camera.projection.px_per_m)
    # An even spread over a way has a variance of the way squared over 12.
    assert moved - still == pytest.approx(way_px**2 / 12, rel=0.01)

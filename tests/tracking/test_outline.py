"""The outline of a body: beside its own shadow, and where one of its ends is not clear."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from count_video.tracking.outline import Mean, find_outline
from count_video.tracking.template import Pixels

SIZE = 120, 150
WALL, BODY, BLACK, PRINT = 150.0, 90.0, 30.0, 190.0
RADIUS_PX, SOFT_PX, DEPTH = 30.0, 6.0, 0.25
EVERYWHERE = -np.inf, np.inf


def disc(x_px: float, y_px: float, radius_px: float, blur_px: float) -> Pixels:
    """Share of each pixel that a blurred disc covers."""
    y, x = np.indices(SIZE)
    plain = (np.hypot(x - x_px, y - y_px) < radius_px).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(plain, (0, 0), blur_px), np.float32)


def mean_of(appearance: Pixels) -> Mean:
    behind = np.full(SIZE, WALL, np.float32)
    moving = np.abs(appearance - behind) > 3
    return Mean(appearance, np.ones(SIZE, np.float32), moving, behind, np.zeros_like(behind))


def test_a_soft_shadow_beside_a_ball_is_no_part_of_its_outline() -> None:
    shade = 1 - DEPTH * disc(85, 70, RADIUS_PX, SOFT_PX)
    ball = disc(55, 55, RADIUS_PX, 1.0)
    mean = mean_of(np.asarray(WALL * shade * (1 - ball) + BODY * ball, np.float32))
    outside = mean.moving & (disc(55, 55, RADIUS_PX + 2, 0.3) < 0.5)
    assert outside.sum() > 0.35 * mean.moving.sum()  # most of a ball alone would be within

    outline = find_outline(mean, EVERYWHERE)

    assert outline is not None
    assert outline.round_
    assert outline.box[2] - outline.box[0] == pytest.approx(2 * RADIUS_PX, abs=1.5)


def test_a_disc_printed_on_a_dark_box_is_not_its_outline() -> None:
    box = np.zeros(SIZE, np.float32)
    box[20:100, 25:125] = 1
    box = np.asarray(cv2.GaussianBlur(box, (0, 0), 1.0), np.float32)
    mark = disc(75, 60, 25, 1.0)
    appearance = WALL * (1 - box) + box * (BODY * (1 - mark) + PRINT * mark)

    outline = find_outline(mean_of(np.asarray(appearance, np.float32)), EVERYWHERE)

    assert outline is not None
    assert outline.box[2] - outline.box[0] == pytest.approx(100, abs=1.5)


def boxed(left: int, right: int, blur_px: float = 1.0) -> Pixels:
    """Share of each pixel that a blurred box covers."""
    box = np.zeros(SIZE, np.float32)
    box[30:90, left:right] = 1
    return np.asarray(cv2.GaussianBlur(box, (0, 0), blur_px), np.float32)


def test_a_soft_shadow_that_reaches_beyond_a_box_does_not_move_its_end() -> None:
    box = boxed(25, 105)
    shade = 1 - DEPTH * np.roll(boxed(40, 125, SOFT_PX), 35, axis=0)
    mean = mean_of(np.asarray(WALL * shade * (1 - box) + BLACK * box, np.float32))
    assert mean.moving[:, 115].sum() > 0.3 * mean.moving[:, 60].sum()  # the shadow reaches further

    outline = find_outline(mean, EVERYWHERE)

    assert outline is not None
    assert outline.box[2] - outline.box[0] == pytest.approx(80, abs=1.5)


def test_an_end_before_what_changes_is_where_the_body_stops_moving_with_its_template() -> None:
    box = boxed(25, 105)
    mean = mean_of(np.asarray(WALL * (1 - box) + BODY * box, np.float32))
    variance = mean.variance.copy()
    variance[:, 95:] += (120.0 * (1 - box[:, 95:])) ** 2  # what lies behind it, as far as it shows
    unclear = replace(mean, variance=variance)

    outline = find_outline(unclear, EVERYWHERE)

    assert outline is not None
    assert outline.box[2] - outline.box[0] == pytest.approx(80, abs=1.5)


def test_a_ball_as_bright_as_the_clutter_behind_it_ends_where_that_begins_to_vary() -> None:
    ball = disc(60, 60, RADIUS_PX, 1.0)
    alike = mean_of(np.full(SIZE, BODY, np.float32))
    variance = np.asarray(1.0 + (40.0 * (1 - ball)) ** 2, np.float32)

    outline = find_outline(replace(alike, variance=variance, moving=ball > 0.02), EVERYWHERE)

    assert outline is not None
    assert outline.round_
    assert outline.box[2] - outline.box[0] == pytest.approx(2 * RADIUS_PX, abs=1.5)

from __future__ import annotations

import numpy as np
import pytest

from count_video.tracking.corners import Trajectories
from count_video.tracking.rigid import RIGID_PX, rigid_groups, scene_path

SAMPLES = 60
NOISE_PX = 0.1
"""Following a corner errs by so much."""
PATH_PX = 5 * NOISE_PX
"""A path is the mean of many corners, each about its own mean: far below the noise of one."""

ZIGZAG = 20.0 * np.abs((np.arange(SAMPLES) / 10) % 2 - 1)
SWING = 30.0 * np.sin(np.arange(SAMPLES) / 25)
STILL = np.zeros((SAMPLES, 2))
SHAPE = 200, 600
"""Rows and columns of a sample."""


def moved(
    path: np.ndarray, corners: int, rng: np.random.Generator, left: float = 0.0
) -> np.ndarray:
    """Corners of a body 60 px wide that moves along image x, shape (corners, SAMPLES, 2)."""
    places = rng.uniform(0, 60, (corners, 1, 2)) + np.stack([left + path, 0 * path], axis=1)
    return places + rng.normal(0, NOISE_PX, (corners, SAMPLES, 2))


def trajectories(*bodies: np.ndarray, anywhere: int = 0) -> Trajectories:
    """All corners together; the last ones were taken from the whole picture."""
    places = np.concatenate(bodies).astype(np.float32)
    return Trajectories(places, np.arange(len(places)) >= len(places) - anywhere)


def test_corners_that_move_together_make_one_body_each() -> None:
    rng = np.random.default_rng(1)
    still = moved(0 * SWING, 30, rng)
    groups = rigid_groups(
        trajectories(moved(ZIGZAG, 20, rng), moved(SWING, 12, rng, 100), still), STILL
    )
    assert [len(group.corners_px) for group in groups] == [20, 12]
    for group, path in zip(groups, (ZIGZAG, SWING), strict=True):
        away = group.path_px[:, 0] - path
        assert np.abs(away - np.median(away)).max() < PATH_PX


def test_corners_that_are_lost_and_strays_cost_nothing_but_themselves() -> None:
    rng = np.random.default_rng(2)
    body = moved(ZIGZAG, 20, rng)
    body[::2, 40:] = np.nan
    body[1::4, :15] = np.nan
    strays = rng.uniform(0, 60, (6, 1, 2)) + rng.normal(0, 3.0, (6, SAMPLES, 2)).cumsum(axis=1)
    groups = rigid_groups(trajectories(body, strays), STILL)
    assert len(groups) == 1
    assert len(groups[0].corners_px) == 20
    assert np.isfinite(groups[0].path_px).all()


def test_corners_that_are_smeared_by_a_fast_motion_make_one_body() -> None:
    """Each is followed worse by some hundredths of its way from sample to sample."""
    rng = np.random.default_rng(14)
    fast = 6.0 * ZIGZAG
    smeared = 0.04 * np.abs(np.gradient(fast))[:, None]
    body = moved(fast, 20, rng)
    body += smeared * rng.normal(0, 1, body.shape)
    groups = rigid_groups(trajectories(body, moved(SWING, 12, rng, 100)), STILL)
    assert [len(group.corners_px) for group in groups] == [20, 12]


def test_a_corner_beyond_another_body_makes_none_hollow() -> None:
    rng = np.random.default_rng(12)
    near = moved(SWING, 29, rng)
    beyond = moved(SWING, 1, rng, 200)
    groups = rigid_groups(trajectories(near, beyond, moved(2 * SWING, 20, rng, 100)), STILL)
    assert [len(group.corners_px) for group in groups] == [30, 20]


def test_a_thread_that_moves_less_than_its_body_is_no_part_of_it() -> None:
    rng = np.random.default_rng(3)
    thread = moved(0.8 * SWING, 8, rng, 70)
    groups = rigid_groups(trajectories(moved(SWING, 20, rng), thread), STILL)
    assert [len(group.corners_px) for group in groups] == [20, 8]


def test_corners_around_a_body_that_hardly_move_are_none() -> None:
    rng = np.random.default_rng(6)
    around = np.array([[[x, y]] for x in (-150, 0, 150) for y in (-80, 60, 140)])
    drift = np.stack([np.linspace(0, 3, SAMPLES), np.zeros(SAMPLES)], axis=1)
    chance = around + drift + rng.normal(0, NOISE_PX, (len(around), SAMPLES, 2))
    body = moved(SWING, 20, rng)
    assert [len(g.corners_px) for g in rigid_groups(trajectories(chance), STILL)] == [len(chance)]
    groups = rigid_groups(trajectories(body, chance), STILL)
    assert [len(group.corners_px) for group in groups] == [len(body)]


@pytest.mark.parametrize("shake_px", [0.0, 3.0])
def test_the_scene_is_the_one_that_spreads(shake_px: float) -> None:
    rng = np.random.default_rng(4)
    shake = shake_px * rng.normal(0, 1, (SAMPLES, 2))
    scene = np.array([[[x, y]] for x in range(0, 600, 60) for y in (0, 150)]) + shake
    scene = scene + rng.normal(0, NOISE_PX, scene.shape)
    body = moved(SWING, 20, rng) + shake
    corners = trajectories(body, scene, anywhere=len(scene))
    measured = scene_path(corners, SHAPE)
    wanted = shake - np.median(shake, axis=0)
    assert np.abs(measured - wanted).max() < PATH_PX
    assert bool(measured.any()) == (shake_px > 0)
    groups = rigid_groups(corners, measured)
    assert [len(group.corners_px) for group in groups] == [20]


def test_a_title_that_stays_in_the_picture_does_not_hide_the_motion_of_the_camera() -> None:
    rng = np.random.default_rng(9)
    shake = 3.0 * rng.normal(0, 1, (SAMPLES, 2))
    scene = np.array([[[x, y]] for x in range(0, 600, 60) for y in (0, 150)]) + shake
    title = moved(0 * SWING, 6, rng)
    corners = trajectories(scene + rng.normal(0, NOISE_PX, scene.shape), title)
    wanted = shake - np.median(shake, axis=0)
    assert np.abs(scene_path(corners, SHAPE) - wanted).max() < PATH_PX


def test_a_body_with_many_corners_is_not_the_scene_that_few_show() -> None:
    rng = np.random.default_rng(5)
    body = moved(SWING, 25, rng)
    still = moved(0 * SWING, 4, rng)
    assert not scene_path(trajectories(body, still, anywhere=len(body) + len(still)), SHAPE).any()


def test_a_background_whose_corners_jitter_each_by_itself_stands_still() -> None:
    rng = np.random.default_rng(8)
    body = moved(SWING, 12, rng)
    body[:, :, 1] += rng.uniform(0, SHAPE[0], (12, 1))  # it spreads as far as a scene does
    anywhere = rng.uniform(0, SHAPE[::-1], (25, 1, 2))
    jitter = anywhere + rng.normal(0, RIGID_PX, (25, SAMPLES, 2))
    every = trajectories(body, jitter, anywhere=len(body) + len(jitter))

    assert scene_path(trajectories(body, anywhere=len(body)), SHAPE).any()
    assert not scene_path(every, SHAPE).any()
    few = trajectories(body, jitter[:8], anywhere=len(body) + 8)
    assert scene_path(few, SHAPE).any()


def test_a_body_before_a_plain_background_is_not_the_scene() -> None:
    body = moved(ZIGZAG, 20, np.random.default_rng(7))
    assert not scene_path(trajectories(body, anywhere=len(body)), SHAPE).any()


def test_nothing_moves_without_corners() -> None:
    nothing = Trajectories(np.empty((0, SAMPLES, 2), np.float32), np.empty(0, bool))
    assert rigid_groups(nothing, STILL) == []
    assert not scene_path(nothing, SHAPE).any()
    lost = Trajectories(np.full((9, SAMPLES, 2), np.nan, np.float32), np.ones(9, bool))
    assert rigid_groups(lost, STILL) == []
    assert RIGID_PX > NOISE_PX

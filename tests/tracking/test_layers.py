"""What bodies hide: of the background, and of each other."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from count_video.tracking.background import agree_better, background_of
from count_video.tracking.light import Light
from count_video.tracking.regions import find_regions
from count_video.tracking.shape import DIFFERENT_PX, MARGIN_PX, Shape, hidden

FRAMES = range(20)
STILL, LIGHTS = np.zeros((len(FRAMES), 2)), [Light()] * len(FRAMES)
SIZE = 60, 160
BODY = 30
"""Side of a square body, in px."""


def scene() -> NDArray[np.uint8]:
    return np.random.default_rng(5).integers(60, 120, SIZE).astype(np.uint8)


def resting_then_moving() -> Shape:
    """A body that rests for most of the clip."""
    path = [(20.0 + (6.0 * (k - 14) if k > 14 else 0.0), 15.0) for k in FRAMES]
    return Shape(np.array(path), (0, 0, BODY, BODY))


def with_body(body: Shape) -> list[NDArray[np.uint8]]:
    pictures = [scene() for _ in FRAMES]
    for picture, (x, y) in zip(pictures, body.path_px.astype(int).tolist(), strict=True):
        picture[y : y + BODY, x : x + BODY] = 255
    return pictures


def background(known: list[Shape]) -> NDArray[np.uint8]:
    return background_of(with_body(resting_then_moving()), STILL, LIGHTS, known).luma


def test_a_body_at_rest_is_taken_for_background_until_it_is_known() -> None:
    assert (background([])[20:40, 25:45] == 255).all()


def test_a_known_body_is_no_background_where_it_ever_leaves_it_free() -> None:
    seen = background([resting_then_moving()])
    left_free = slice(15, 15 + BODY), slice(20, 44 - int(MARGIN_PX))  # by its last step of 30 px
    assert np.array_equal(seen[left_free], scene()[left_free])


def test_what_a_known_body_hid_is_no_region_that_moves() -> None:
    body = resting_then_moving()
    pictures = with_body(body)
    regions = find_regions(pictures)
    assert any(len(boxes) for boxes in regions.boxes)
    without = find_regions(pictures, known=[[body.part(k)] for k in FRAMES])
    assert not any(len(boxes) for boxes in without.boxes)


def test_the_camera_moves_the_background_and_not_what_stands_in_it() -> None:
    moved = [np.roll(scene(), k % 3, axis=1) for k in FRAMES]
    seen = background_of(moved, np.array([(k % 3, 0.0) for k in FRAMES]), LIGHTS)
    assert np.array_equal(seen.luma[:, 4:-4], scene()[:, 4:-4])
    piece = seen.behind(1, (50.0, 10.0), (20, 30))
    assert piece.shape == (20, 30)


def camera_moved(pictures, shift) -> bool:
    return agree_better(pictures, np.zeros_like(shift), pictures, shift)


def before_the_scene(body_px: NDArray[np.float64], scene_px: NDArray[np.float64]) -> list[NDArray]:
    """Pictures of a large body, striped across its way, and of a scene that move on their own."""
    coarse = np.random.default_rng(5).integers(40, 140, (SIZE[0] // 6, SIZE[1] // 2))
    wide = np.kron(coarse, np.ones((6, 6))).astype(np.uint8)
    striped = np.repeat(np.random.default_rng(6).integers(0, 255, (40, 1)), 90, axis=1)
    pictures = []
    for x, shake in zip(body_px, scene_px, strict=True):
        picture = np.roll(wide, round(shake), axis=1)[:, 40 : 40 + 2 * SIZE[1]].copy()
        picture[10:50, 20 + round(x) : 110 + round(x)] = striped
        pictures.append(picture)
    return pictures


def test_pictures_that_are_moved_back_by_parts_of_a_pixel_are_not_less_sharp_for_that() -> None:
    rng = np.random.default_rng(8)
    soft = cv2.GaussianBlur(rng.normal(0, 20, (80, 200)), (0, 0), 3.0)
    path = 2.7 * np.sin(np.arange(60) / 10)
    pictures = []
    for x in path:
        there = np.array([[1.0, 0.0, x - 20.0], [0.0, 1.0, -10.0]])
        seen = cv2.warpAffine(soft, there, SIZE[::-1], flags=cv2.INTER_CUBIC)
        pictures.append(np.clip(100 + seen + rng.normal(0, 6, SIZE), 0, 255).astype(np.uint8))
    along = np.stack([path, 0 * path], axis=1)
    assert camera_moved(pictures, along)
    assert not camera_moved([pictures[0]] * 60, along)


def test_a_camera_moves_only_if_that_explains_the_scene_behind_the_body() -> None:
    swing = np.rint(40 * np.sin(np.arange(60) / 10) + 45)
    shake = np.rint(np.random.default_rng(7).normal(0, 3, 60))
    along_x = np.zeros(60)
    still = before_the_scene(swing, along_x)
    assert not camera_moved(still, np.stack([swing, along_x], axis=1))
    shaken = before_the_scene(swing, shake)
    assert camera_moved(shaken, np.stack([shake, along_x], axis=1))


def test_a_camera_stands_where_a_body_is_larger_than_all_that_shows_it() -> None:
    swing = np.rint(40 * np.sin(np.arange(60) / 10) + 45)
    striped = np.repeat(np.random.default_rng(6).integers(0, 255, (30, 1)), 40, axis=1)
    pictures = []
    for x in swing:
        picture = np.full((200, 300), 40, np.uint8)
        picture[:, 20:24] = 80  # the edge of a wall
        picture[90:120, 100 + round(x) : 140 + round(x)] = striped
        pictures.append(picture)
    assert not camera_moved(pictures, np.stack([swing, 0 * swing], axis=1))


def test_a_knock_of_few_pictures_counts() -> None:
    knock = np.zeros(200)
    knock[90:96] = 4.0, 7.0, 5.0, -3.0, -2.0, 1.0
    pictures = before_the_scene(0 * knock, knock)
    assert camera_moved(pictures, np.stack([knock, 0 * knock], axis=1))


def test_flicker_is_taken_out() -> None:
    lamps = [Light(1.0 + 0.1 * (k % 2)) for k in FRAMES]
    flickering = [np.asarray(np.rint(scene() * lamp.gain), np.uint8) for lamp in lamps]
    seen = background_of(flickering, STILL, lamps)
    assert np.abs(seen.luma.astype(int) - scene()).max() <= 1  # rounded twice


def test_a_shape_is_marked_where_it_is_with_a_margin() -> None:
    shape = Shape(np.array([(10.0, 5.0), (np.nan, np.nan)]), (0.0, 0.0, 8.0, 6.0))
    marked = hidden([shape], 0, (0.0, 0.0), (30, 40))
    rows, columns = np.nonzero(marked)
    margin = int(MARGIN_PX)
    assert (columns.min(), columns.max() + 1) == (10 - margin, 18 + margin)
    assert (rows.min(), rows.max() + 1) == (5 - margin, 11 + margin)
    assert not hidden([shape], 1, (0.0, 0.0), (30, 40)).any()  # not seen in that one
    piece = hidden([shape], 0, (10.0, 5.0), (30, 40))
    assert np.nonzero(piece)[1].max() + 1 == 8 + margin


def test_shapes_of_one_body_keep_their_distance() -> None:
    one = resting_then_moving()
    part = Shape(one.path_px + np.array([11.0, 3.0]), (0, 0, 4, 4))
    still = Shape(np.full((len(FRAMES), 2), (20.0, 15.0)), (0, 0, 4, 4))
    assert one.moves_with(part)
    assert part.moves_with(one)
    assert not one.moves_with(still)
    assert one.holds(part)
    assert not part.holds(one)


@pytest.mark.parametrize(("share", "is_part"), [(0.03, True), (0.2, False)])
def test_what_metal_mirrors_creeps_over_it_and_is_no_other_body(
    share: float, is_part: bool
) -> None:
    way = np.stack([np.linspace(0.0, 400.0, 50), np.full(50, 30.0)], axis=1)
    creeps = np.stack([0.0 * way[:, 0], share * way[:, 0]], axis=1)
    assert np.std(creeps[:, 1]) > DIFFERENT_PX  # by px alone it would be another one
    metal, mirrored = (Shape(path, (0, 0, 40, 30)) for path in (way, way + creeps))
    assert metal.moves_with(mirrored) is is_part

"""Bodies side by side: which pixels are whose, and which places."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from drawn import texture
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.background import background_of
from count_video.tracking.composite import Source
from count_video.tracking.following import Followed
from count_video.tracking.layers import apart, same_body
from count_video.tracking.learning import Body, learn
from count_video.tracking.light import Light
from count_video.tracking.pairing import has_pair, ranked_pairs
from count_video.tracking.paths import Rough
from count_video.tracking.shape import Shape
from count_video.tracking.template import Template, make_template, piece_at

Luma = NDArray[np.uint8]

SIZE = 90, 300
SIDE = 40
BLOCK_PX = 4
TOP = 25
"""Side of two square bodies in px, and the row at which they begin."""
FRAMES = range(40)
TOGETHER = 32
"""So many frames long they touch; then one of them moves on alone."""
EDGE_PX = 1.5
"""Outlines are found to about half a pixel; the blur of a texture's last pixels adds to it."""


def left_at(frame: int) -> float:
    return 60.0 + 2.0 * frame


def right_at(frame: int) -> float:
    return left_at(frame) + SIDE + 5.0 * max(0, frame - TOGETHER)


def path_of(left: Callable[[int], float], top: float = TOP) -> Floats:
    """Place of a body in each picture, shape (pictures, 2)."""
    return np.array([(left(frame), top) for frame in FRAMES])


def rough_of(path, box) -> Rough:
    return Rough(path, box, (-np.inf, np.inf), Shape(path, box), again=True)


STILL, LIGHTS = np.zeros((len(FRAMES), 2)), [Light()] * len(FRAMES)


def pictures() -> list[Luma]:
    seen = []
    for frame in FRAMES:
        picture = texture(1, SIZE, 90, 130, BLOCK_PX)
        for seed, x in ((2, left_at(frame)), (3, right_at(frame))):
            body = texture(seed, (SIDE, SIDE), 20, 230, BLOCK_PX)
            picture[TOP : TOP + SIDE, round(x) : round(x) + SIDE] = body
        seen.append(picture)
    return seen


def shape_of_right() -> Shape:
    whole = piece_at(texture(3, (SIDE, SIDE), 20, 230, BLOCK_PX), 0.0, 0.0, (SIDE, SIDE))
    template = make_template(whole, np.ones((SIDE, SIDE), np.float32))
    appearance = template.appearance, template.weight > 0
    return Shape(path_of(right_at), (0.0, 0.0, SIDE - 1.0, SIDE - 1.0), appearance)


def test_a_neighbour_that_touches_most_of_the_time_is_no_part_of_a_body() -> None:
    path, right = path_of(left_at), shape_of_right()
    known = [Shape(path, (0.0, 0.0, SIDE - 1.0, SIDE - 1.0)), right]
    seen = pictures()
    background = background_of(seen, STILL, LIGHTS, known)
    rough = rough_of(path, (0.0, 0.0, float(SIDE), float(SIDE)))

    body = learn(Source(seen, background, [right]), rough, [right.path_px])

    assert body is not None
    first = int(body.learnt[0])
    right_px = body.path_px[first, 0] + body.box[2] - left_at(first)
    assert right_px == pytest.approx(SIDE - 0.5, abs=EDGE_PX)


@pytest.mark.parametrize("corners", [(0.0, 0.0, 20.0, 20.0), (60.0, 0.0, 90.0, 20.0)])
def test_a_plain_body_is_learnt_whole_from_corners_on_a_small_part_of_it(
    corners: tuple[float, float, float, float],
) -> None:
    """A cylinder shows along its axis nothing but its two ends."""
    height, width = 50, 90
    shading = np.linspace(40, 220, height).astype(np.uint8)[:, None]
    path = path_of(lambda frame: 40.0 + 3.0 * frame, top=20)
    seen = [texture(1, SIZE, 90, 130, BLOCK_PX) for _ in FRAMES]
    for picture, (left, top) in zip(seen, path.astype(int).tolist(), strict=True):
        picture[top : top + height, left : left + width] = shading
    background = background_of(seen, STILL, LIGHTS)

    rough = rough_of(path, corners)
    body = learn(Source(seen, background), rough, [])

    assert body is not None
    assert body.box[2] - body.box[0] == pytest.approx(width, abs=EDGE_PX)


@pytest.mark.parametrize(("alike", "learnt"), [(24, True), (16, False)])
def test_what_looks_alike_in_few_of_its_pictures_is_no_body(alike: int, *, learnt: bool) -> None:
    seen = [texture(1, SIZE, 90, 130, BLOCK_PX) for _ in FRAMES]
    for frame in FRAMES:
        left = round(left_at(frame))
        body = texture(2 if frame < alike else 100 + frame, (SIDE, SIDE), 20, 230, BLOCK_PX)
        seen[frame][TOP : TOP + SIDE, left : left + SIDE] = body
    background = background_of(seen, STILL, LIGHTS)

    rough = rough_of(path_of(left_at), (0.0, 0.0, float(SIDE), float(SIDE)))

    assert (learn(Source(seen, background), rough, []) is not None) == learnt


@pytest.mark.parametrize("is_round", [False, True])
def test_a_box_as_high_as_wide_is_no_ball(*, is_round: bool) -> None:
    side = 50
    y, x = np.indices((side, side)) - (side - 1) / 2
    own = np.hypot(x, y) <= side / 2 if is_round else np.ones((side, side), np.bool_)
    shading = np.linspace(200, 230, side).astype(np.uint8)[:, None] * np.ones((1, side), np.uint8)
    path = path_of(lambda frame: 40.0 + 3.0 * frame, top=20)
    seen = [texture(1, SIZE, 90, 130, BLOCK_PX) for _ in FRAMES]
    for picture, (left, top) in zip(seen, path.astype(int).tolist(), strict=True):
        picture[top : top + side, left : left + side][own] = shading[own]
    background = background_of(seen, STILL, LIGHTS)

    found = learn(Source(seen, background), rough_of(path, (0.0, 0.0, 50.0, 50.0)), [])

    assert found is not None
    assert found.round_ == is_round


def test_a_body_that_leaves_the_picture_is_learnt_from_those_that_hold_it() -> None:
    path = path_of(lambda frame: 150.0 + 8.0 * frame)  # half of the pictures show none of it
    seen = [texture(1, SIZE, 90, 130, BLOCK_PX) for _ in FRAMES]
    body = texture(2, (SIDE, SIDE), 20, 230, BLOCK_PX)
    for picture, (left, _) in zip(seen, path.astype(int).tolist(), strict=True):
        shown = picture[TOP : TOP + SIDE, left : left + SIDE]
        shown[:] = body[:, : shown.shape[1]]
    background = background_of(seen, STILL, LIGHTS)

    found = learn(Source(seen, background), rough_of(path, (0.0, 0.0, 40.0, 40.0)), [])

    assert found is not None
    assert found.box[2] - found.box[0] == pytest.approx(SIDE, abs=EDGE_PX)


def test_a_body_is_painted_where_it_is() -> None:
    right = shape_of_right()
    right.path_px[-1] = np.nan
    piece = np.zeros((SIDE + 20, SIDE + 20), np.float32)
    corner = right.path_px[0, 0] - 10.0, TOP - 10.0

    painted = right.paint(piece, 0, corner)

    assert right.appearance is not None
    inside = slice(10, 10 + SIDE)
    assert np.array_equal(piece[inside, inside], right.appearance[0])
    assert painted.sum() == SIDE * SIDE
    assert not right.paint(piece, len(FRAMES) - 1, corner).any()  # not seen in that one


def template() -> Template:
    return make_template(np.ones((SIDE, SIDE), np.float32), np.ones((SIDE, SIDE), np.float32))


def followed(x_px: Floats) -> Followed:
    nowhere = np.empty((0, 2)), np.empty(0, np.intp)
    body = Body(template(), (0.0, 0.0, float(SIDE), float(SIDE)), False, *nowhere, 1.0)
    known = np.where(np.isfinite(x_px), 1.0, np.nan)
    return Followed(body, x_px, TOP * known, 0.01 * known)


def test_a_place_belongs_to_the_body_that_came_there_by_an_unbroken_path() -> None:
    frame = np.arange(60.0)
    stays = 200.0 + 0.5 * frame
    leaves = np.where(frame < 40, 100.0 - 3.0 * frame, np.nan)
    mistaken = np.where(frame < 50, leaves, stays)  # having left, it is taken for its like

    first, second = apart([followed(mistaken), followed(stays)])

    np.testing.assert_array_equal(first.x_px, leaves)
    np.testing.assert_array_equal(second.x_px, stays)


def test_what_never_moves_or_only_jumps_is_no_body() -> None:
    frame = np.arange(60.0)
    rests = np.full(60, 80.0)
    jumps = 20.0 + 200.0 * (frame // 12 % 2)

    assert apart([followed(rests), followed(jumps)]) == []


@pytest.mark.parametrize("way_px", [24.0, 8.0])
def test_a_ball_that_rests_but_for_a_moment_moves(way_px: float) -> None:
    """At 1:1 the ball is struck, turns at the wall, and rests again where it was."""
    frame = np.arange(300.0)
    struck = 80.0 - np.maximum(0.0, way_px - 4.0 * np.abs(frame - 150.0))

    (ball,) = apart([followed(struck)])

    np.testing.assert_array_equal(ball.x_px, struck)


@pytest.mark.parametrize("misplaced", [slice(None, 5), slice(-5, None)])
def test_a_body_that_is_misplaced_in_the_first_or_last_pictures_moves(misplaced: slice) -> None:
    path = 100.0 + 1.5 * np.arange(60.0)
    path[misplaced] -= 200.0

    (body,) = apart([followed(path)])

    np.testing.assert_array_equal(body.x_px, path)


def test_of_two_templates_of_a_body_the_one_that_was_followed_is_kept() -> None:
    path = 100.0 + 0.5 * np.arange(60.0)
    strays = path.copy()
    strays[20:24] += 200.0

    (kept,) = apart([followed(strays), followed(path)])

    np.testing.assert_array_equal(kept.x_px, path)


def test_two_templates_of_a_smeared_ball_make_one_path() -> None:
    frame = np.arange(120.0)
    fast_px, smeared_px = 20.0, 1.5
    path = 50.0 + fast_px * np.abs((frame + 10.0) % 20.0 - 10.0)
    late = np.where(frame > 15, path, np.nan)
    early = np.where(frame < 100, path + 7.0 + smeared_px * (-1) ** frame, np.nan)

    (ball,) = apart([followed(late), followed(early)])

    np.testing.assert_allclose(ball.x_px, path, atol=2 * smeared_px)


def test_bodies_that_move_across_the_pictures_are_not_one_body() -> None:
    still = followed(np.full(60, 40.0))
    up = np.linspace(0.0, 30.0, 60)
    one, other = (replace(still, y_px=TOP + way) for way in (up, 2 * up))

    assert not same_body(one.xy_px, other.xy_px)
    assert same_body(one.xy_px, one.xy_px + np.array([0.0, 9.0]))


def test_scenery_whose_template_slides_in_a_few_pictures_takes_no_body_its_place() -> None:
    frames = np.arange(60.0)
    slid = np.where(np.isin(frames, [20.0, 41.0]), -2.5, 0.0)
    scenery = replace(followed(np.full(60, 45.0)), y_px=TOP + slid)
    moves = followed(np.where(frames < 50, 40.0 + frames / 5, np.nan))

    kept = apart([scenery, moves])

    assert len(kept) == 1
    np.testing.assert_array_equal(kept[0].x_px, moves.x_px)


def test_what_passes_over_a_ball_is_no_body_that_collides_with_it() -> None:
    frame = np.arange(200.0)
    ball = 20.0 + 1.5 * np.abs((frame + 20.0) % 40.0 - 20.0)
    ball_body = replace(followed(ball), body=replace(followed(ball).body, round_=True))
    heavy = followed(50.0 + SIDE + 0.01 * (frame - 100.0) ** 2)
    hand = followed(200.0 - 10.0 * (25.0 - np.abs(frame - 25.0)))

    assert has_pair([ball_body, heavy, hand])
    assert not has_pair([ball_body, hand])


def test_two_that_exchange_momentum_are_a_pair_whatever_their_outlines() -> None:
    frame = np.arange(200.0)
    ball = followed(20.0 + 1.5 * np.abs((frame + 20.0) % 40.0 - 20.0))
    since = (frame - 20.0) % 40.0
    bounces = followed(50.0 + SIDE + 0.01 * since * (40.0 - since))
    pushes = followed(50.0 + SIDE - 0.01 * since * (40.0 - since) + 4.0)

    assert has_pair([ball, bounces])
    assert not has_pair([ball, pushes]), "both velocities jump in one direction"


def test_one_contact_shows_no_ratio_in_which_momentum_goes_over() -> None:
    frame = np.arange(60.0)
    ball = followed(np.minimum(20.0 + 1.5 * frame, 65.0 - 0.5 * (frame - 30.0)))
    other = followed(65.0 + SIDE + np.maximum(0.0, frame - 30.0))

    assert not has_pair([ball, other])


def test_a_mirror_image_stands_for_a_body_that_is_not_followed_and_for_no_other() -> None:
    frame = np.arange(200.0)
    ball = followed(20.0 + 1.5 * np.abs((frame + 20.0) % 40.0 - 20.0))
    ball = replace(ball, body=replace(ball.body, round_=True))
    heavy = followed(50.0 + SIDE + 0.01 * (frame - 100.0) ** 2)
    mirrored = replace(heavy, y_px=heavy.y_px + 3.0 * SIDE)

    assert ranked_pairs([mirrored, ball, heavy]) == [(ball, heavy)]
    assert ranked_pairs([mirrored, ball]) == [(ball, mirrored)]
    assert has_pair([mirrored, ball, heavy])
    assert not has_pair([mirrored, ball]), "the body itself is still to be sought"

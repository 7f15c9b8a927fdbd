from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from drawn import background, paint_box, paint_disc, to_luma

from count_video.motion.time_base import at_rows
from count_video.records import BodyTrack, Floats, MotionLine, Track
from count_video.tracking.beside import changes, has_face, stands_beyond, turning_side


def strip(face: int | None, body: int) -> np.ndarray:
    """What lies ahead of a body that ends at a place, with a wall that begins at another."""
    picture = np.full((21, 80), 100.0)
    picture[:, :body] = 40.0
    if face is not None:
        picture[:, face:] = 120.0
    return picture


def test_a_wall_ahead_is_seen_and_the_edge_of_the_body_itself_is_not() -> None:
    assert has_face(strip(60, 20), strip(60, 30))
    assert not has_face(strip(None, 20), strip(None, 30))


def test_what_is_lower_than_the_body_is_no_wall() -> None:
    before, after = strip(60, 20), strip(60, 30)
    for picture in (before, after):
        picture[:10] = np.where(np.arange(80) < 30, picture[:10], 100.0)

    assert not has_face(before, after)


def strips(ball_at: list[int | None], light: list[float]) -> np.ndarray:
    """A textured wall in some pictures, each in its own light, with a ball at a place in front."""
    wall = 100.0 + 10.0 * np.random.default_rng(0).normal(size=(21, 40))
    pictures = []
    for place, factor in zip(ball_at, light, strict=True):
        picture = wall.copy()
        if place is not None:
            picture[5:16, place : place + 10] = 160.0
        pictures.append(factor * picture)
    return np.array(pictures)


STILL, STEADY = [None] * 8, [1.0] * 8


def test_a_ball_that_comes_and_goes_moves_and_a_lamp_that_flickers_does_not() -> None:
    coming = [None, None, None, 30, 20, 10, None, None]
    flicker = [1.0, 1.2, 0.8, 1.1, 0.9, 1.2, 0.8, 1.0]

    assert changes(strips(coming, STEADY))
    assert changes(strips(coming, flicker))
    assert not changes(strips(STILL, flicker))


@pytest.mark.parametrize("unseen", [range(0), range(37, 45)], ids=["seen", "hidden"])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_body_that_is_hidden_where_it_turns_turns_at_that_end(unseen: range, side: int) -> None:
    frames = np.arange(100.0)
    place = side * (200.0 - 2 * np.abs(frames - 41.3))
    place[list(unseen)] = np.nan

    assert turning_side(frames, place, 41.3) == side


def test_a_title_is_no_motion_and_neither_is_what_is_covered() -> None:
    titled = strips(STILL, STEADY)
    titled[0] = 40.0
    titled[0, 5:10] = 200.0
    covered = strips([None, 30, 20, 10, None, None, None, None], STEADY)
    covered[1:4, 5:16] = np.nan

    assert not changes(titled)
    assert not changes(covered)
    assert not changes(np.full((8, 21, 40), np.nan))


HEIGHT, WIDTH, MIDDLE_PX, RADIUS_PX, FACE_PX = 120, 480, 60.0, 20.0, 430.0
PICTURES = 30
LEAVES_PX = 4.0
"""Step of a body from picture to picture."""


def two_that_part() -> Track:
    """Two bodies that part, of which the right one nears a face."""
    frame = np.arange(float(PICTURES))
    away = LEAVES_PX * (frame - frame[-1])
    left, right = (
        BodyTrack(place, np.full(PICTURES, 0.05), -RADIUS_PX, RADIUS_PX)
        for place in (150.0 - away, 370.0 + away)
    )
    line = MotionLine(0.0, 0.0, MIDDLE_PX, upright=False)
    return Track(frame, left, right, "left", 2 * RADIUS_PX, line, (), wall_seen=False)


def seen_with(
    track: Track,
    shift_px: Floats,
    region: tuple[int, int, int, int] = (0, 0, WIDTH, HEIGHT),
    *,
    face: bool,
) -> Any:
    """Pictures of these bodies, with the face or without it, by a camera that is shifted."""
    assert track.heavy is not None
    x, y, width, height = region
    pictures = []
    for row, (right, down) in enumerate(shift_px.tolist()):
        canvas = np.full((HEIGHT, WIDTH), 140.0) + 0.1 * background((HEIGHT, WIDTH))
        if face:
            paint_box(canvas, (FACE_PX + right, -1.0, WIDTH + 50.0, HEIGHT + 1.0), 60.0)
        for body in (track.ball, track.heavy):
            place = float(body.position_px[row])
            paint_disc(canvas, place + right, MIDDLE_PX + down, RADIUS_PX, 220.0)
        pictures.append(to_luma(canvas)[y : y + height, x : x + width])
    info = SimpleNamespace(width_px=WIDTH, height_px=HEIGHT)
    view = SimpleNamespace(region=region, footage=SimpleNamespace(info=info))
    return SimpleNamespace(
        view=view, frames=track.frame.astype(int), picture=lambda row: pictures[row]
    )


STANDS = np.zeros((PICTURES, 2))


@pytest.mark.parametrize("face", [True, False])
def test_a_face_that_a_body_nears_as_the_clip_ends_is_seen(face: bool) -> None:
    track = two_that_part()
    assert stands_beyond(seen_with(track, STANDS, face=face), track) == (False, face)


def test_the_border_of_a_region_is_no_face() -> None:
    track, region = two_that_part(), (8, 8, WIDTH - 16, HEIGHT - 16)
    assert stands_beyond(seen_with(track, STANDS, region, face=False), track) == (False, False)


def test_a_face_is_seen_while_the_camera_trembles() -> None:
    trembles = 6.0 * np.stack([np.sin(np.arange(PICTURES) * 0.9), np.zeros(PICTURES)], axis=1)
    track = replace(two_that_part(), shift_px=trembles)
    assert stands_beyond(seen_with(track, trembles, face=True), track) == (False, True)


def test_the_ends_are_those_of_the_part_that_is_explained() -> None:
    """Behind a still picture no body moves; and rows of a part are not those of the clip."""
    track = two_that_part()
    seen = seen_with(track, STANDS, face=True)
    nearing = at_rows(track, track.frame >= 10)
    assert stands_beyond(seen, nearing) == (False, True)
    assert stands_beyond(seen, at_rows(track, track.frame < 10)) == (False, True)

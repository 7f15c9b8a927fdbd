"""A ball whose surface changes is placed, found and followed by its outline."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drawn import (
    Canvas,
    Luma,
    background,
    paint_box,
    paint_cylinder,
    paint_disc,
    scene,
    texture,
    to_luma,
)

from count_video.records import Floats
from count_video.tracking.background import Background
from count_video.tracking.composite import Source
from count_video.tracking.disc import SURFACE_PX, Disc, differing, register_discs
from count_video.tracking.following import Clip, follow
from count_video.tracking.layers import is_fixed_to
from count_video.tracking.learning import Body
from count_video.tracking.light import Light
from count_video.tracking.observation import observe
from count_video.tracking.pairing import pair_tracks
from count_video.tracking.round_bodies import find_ball
from count_video.tracking.search import likely_places
from count_video.tracking.template import make_template
from count_video.tracking.view import view_of
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

SIZE = 120, 360
RADIUS_PX = 22.0
FRAMES = np.arange(48)
TURN_RAD = 2 * np.pi / 30
"""By so much the ball turns from picture to picture."""
LIGHT, DARK = 215.0, 45.0
RADIUS_WITHIN_PX = 0.5
"""Edges of single pictures are found to about half a pixel."""
AWAY_PX = 3.0
"""A guess may be wrong by so much along either axis."""


def paint_halves(canvas: Canvas, place: tuple[float, float], radius: float, turn: float) -> None:
    """Lay a ball of a light and a dark half over the canvas; its axis stands upright."""
    x, y = place
    light, dark = canvas.copy(), canvas.copy()
    paint_disc(light, x, y, radius, LIGHT)
    paint_disc(dark, x, y, radius, DARK)
    down, along = np.indices(canvas.shape, dtype=np.float64)
    right = (along - x) / radius
    towards = np.sqrt(np.maximum(1 - right**2 - ((down - y) / radius) ** 2, 0))
    canvas[:] = np.where(right * np.cos(turn) + towards * np.sin(turn) > 0, light, dark)


def centres() -> Floats:
    return np.stack([180.0 + 90.0 * np.sin(FRAMES / 9.0), 60.0 + 0.0 * FRAMES], axis=1)


def pictures(behind: Canvas, noise: float = 1.0, gain: float = 1.0) -> list[Luma]:
    rng, seen = np.random.default_rng(4), []
    for frame, place in zip(FRAMES.tolist(), centres().tolist(), strict=True):
        canvas = behind.copy()
        paint_halves(canvas, (place[0], place[1]), RADIUS_PX, frame * TURN_RAD)
        seen.append(to_luma(gain * canvas, noise, rng))
    return seen


def before(behind: Canvas, seen: list[Luma]) -> tuple[list[Luma], Luma, Floats]:
    return seen, to_luma(behind), np.zeros((len(seen), 2))


def corner_of(disc: Disc) -> Floats:
    return centres() - disc.middle_px


@pytest.mark.parametrize("gain", [0.8, 1.0, 1.1])
@pytest.mark.parametrize("behind", [background(SIZE), texture(1, SIZE, 100, 150)])
def test_a_ball_of_two_colours_is_placed_as_it_turns(behind: Canvas, gain: float) -> None:
    """Also where a lamp flickers, and whether its halves are brighter or darker than behind it."""
    disc, behind = Disc(RADIUS_PX), np.asarray(behind, np.float64)
    away = np.random.default_rng(5).uniform(-AWAY_PX, AWAY_PX, (len(FRAMES), 2))

    fits = register_discs(
        *before(behind, pictures(behind, gain=gain)), disc, corner_of(disc) + away
    )

    error = fits.places_px - corner_of(disc)
    assert np.sqrt(np.mean(error**2)) < SURFACE_PX
    assert np.quantile(np.abs(error / fits.sigmas_px), 0.95) < 2.0
    assert np.median(fits.agreement) > 0.7


def test_a_guess_is_needed_and_a_shift_of_the_camera_is_known() -> None:
    behind, disc = texture(1, SIZE, 60, 190).astype(np.float64), Disc(RADIUS_PX)
    seen, shift = pictures(behind), np.array([3.0, -2.0])
    moved = [np.roll(one, (-2, 3), axis=(0, 1)) for one in seen]
    guesses = corner_of(disc) + shift
    guesses[5] = np.nan

    fits = register_discs(moved, to_luma(behind), np.tile(shift, (len(FRAMES), 1)), disc, guesses)

    assert np.isnan(fits.places_px[5]).all()
    error = np.delete(fits.places_px - guesses, 5, axis=0)
    assert np.sqrt(np.mean(error**2)) < SURFACE_PX


def test_beside_the_picture_and_where_nothing_differs_there_is_no_disc() -> None:
    behind, disc = background(SIZE), Disc(RADIUS_PX)
    still = [to_luma(behind)] * 2

    fits = register_discs(*before(behind, still), disc, np.array([[100.0, 30.0], [-200.0, 0.0]]))

    assert np.isnan(fits.places_px).all()


def test_a_disc_is_found_far_from_where_it_was() -> None:
    behind, disc = background(SIZE), Disc(RADIUS_PX)
    frame = 12
    near = corner_of(disc)[frame] - (80.0, 0.0)

    one = pictures(behind)[frame]
    shown = differing(one, to_luma(behind), np.zeros(2))
    places = np.array(likely_places(shown, disc, tuple(near), (100.0, 10.0)))
    count = len(places)
    fits = register_discs([one] * count, to_luma(behind), np.zeros((count, 2)), disc, places)
    found = max(map(fits.fit, range(count)), key=lambda fit: fit.agreement if fit else 0)

    assert (found.x_px, found.y_px) == pytest.approx(corner_of(disc)[frame], abs=3 * SURFACE_PX)


def samples(seen: list[Luma], behind: Canvas) -> tuple[list[Luma], Background]:
    still = np.zeros((len(seen), 2))
    return seen, Background(to_luma(behind), still, [Light()] * len(seen))


ROUGHLY = 2.0 * np.sin(np.arange(len(FRAMES)))[:, None] * np.ones(2)
"""Paths of regions are right to some px."""
BOX = -26.0, -25.0, 27.0, 24.0


def test_single_pictures_show_the_radius_of_a_ball_that_turns() -> None:
    behind = background(SIZE)

    ball = find_ball(Source(*samples(pictures(behind), behind)), centres() + ROUGHLY, BOX)

    assert ball is not None
    assert ball.round_
    assert ball.box[2] - ball.box[0] == pytest.approx(2 * RADIUS_PX, abs=2 * RADIUS_WITHIN_PX)
    middle = (ball.box[0] + ball.box[2]) / 2
    error = ball.path_px + middle - centres()
    assert np.isfinite(error).all()
    assert np.sqrt(np.mean(error**2)) < SURFACE_PX


def cart(canvas: Canvas, x: float) -> None:
    paint_box(canvas, (x - 40.0, 20.0, x + 40.0, 60.0), 200.0)
    paint_disc(canvas, x, 62.0, 16.0, 40.0)


def cylinder(canvas: Canvas, x: float) -> None:
    paint_cylinder(canvas, x - 24.0, 60.0, (48.0, 44.0))


def nothing(canvas: Canvas, x: float) -> None:
    """Leave everything as it stands."""


@pytest.mark.parametrize("paint", [cart, cylinder, nothing])
def test_what_is_not_round_is_no_ball_nor_is_a_part_of_it(paint: object) -> None:
    assert callable(paint)
    behind, seen = background(SIZE), []
    for x, _ in centres().tolist():
        canvas = behind.copy()
        paint(canvas, x)
        seen.append(to_luma(canvas))

    assert find_ball(Source(*samples(seen, behind)), centres(), BOX) is None


def test_a_body_that_hardly_any_sample_shows_is_no_ball() -> None:
    behind, path = background(SIZE), np.full((len(FRAMES), 2), np.nan)
    path[7:9] = centres()[7:9]

    assert find_ball(Source(*samples(pictures(behind), behind)), path, BOX) is None


def print_of(first: Luma, corner_px: Floats, number: int) -> Body:
    """What a print on a ball is as it is learnt from so many pictures, the first of them."""
    left, top = corner_px[0].astype(int)
    piece = first[top : top + 18, left : left + 18].astype(np.float32)
    mark = make_template(piece, np.ones_like(piece))
    return Body(mark, (5.0, 5.0, 13.0, 13.0), True, corner_px, np.arange(number), 1.0)


@pytest.mark.parametrize(("swing_px", "fixed"), [(0.0, True), (2.0, False)])
def test_a_mark_is_fixed_to_a_ball_if_it_keeps_its_distance_from_the_outline(
    swing_px: float, fixed: bool
) -> None:
    """A print on a ball that turns a little is seen in every picture, but in another place."""
    behind, seen = background(SIZE), []
    away = swing_px * np.sin(FRAMES / 3.0)
    for (x, y), along in zip(centres().tolist(), away.tolist(), strict=True):
        canvas = behind.copy()
        paint_disc(canvas, x, y, RADIUS_PX, LIGHT)
        paint_disc(canvas, x + along, y - 6.0, 4.0, DARK)
        seen.append(to_luma(canvas))
    lumas, still = samples(seen, behind)
    ball = find_ball(Source(lumas, still), centres(), BOX)
    assert ball is not None
    corner = np.round(centres() + np.stack([away, 0 * away], axis=1)) - (9.0, 15.0)
    body = print_of(seen[0], corner, len(FRAMES))
    clip = Clip(lumas, FRAMES, np.arange(len(FRAMES)), still, np.zeros((len(FRAMES), 2)))

    assert np.isfinite(follow(clip, body).x_px).all()
    assert is_fixed_to(body, ball, clip) == fixed


def test_a_print_that_shows_in_half_of_the_pictures_is_not_fixed_to_a_ball() -> None:
    """Learnt from those that show it alone, it is in one place of the ball in all of them."""
    behind, seen, shown = background(SIZE), [], len(FRAMES) // 2
    for number, (x, y) in enumerate(centres().tolist()):
        canvas = behind.copy()
        paint_disc(canvas, x, y, RADIUS_PX, LIGHT)
        if number < shown:
            paint_disc(canvas, x, y - 6.0, 4.0, DARK)
        seen.append(to_luma(canvas))
    lumas, still = samples(seen, behind)
    path = np.where(FRAMES[:, None] < shown, centres(), np.nan)
    ball = find_ball(Source(lumas, still), path, BOX)
    assert ball is not None
    corner = np.round(path) - (9.0, 15.0)
    body = print_of(seen[0], corner, shown)
    clip = Clip(lumas, FRAMES, np.arange(len(FRAMES)), still, np.zeros((len(FRAMES), 2)))

    assert not is_fixed_to(body, ball, clip)


def test_a_ball_of_two_colours_is_followed_through_a_trial(tmp_path: Path) -> None:
    """Its template is a part of it at best: it is no half, and is where it was drawn."""
    drawn = scene(wall_left=False)
    path, behind = tmp_path / "spinning.mp4", background(drawn.shape)
    frames, rng = [], np.random.default_rng(3)
    row = (drawn.shape[0] - 1) / 2
    for frame, (x, face) in enumerate(zip(drawn.ball_px, drawn.face_px, strict=True)):
        canvas = behind.copy()
        paint_cylinder(canvas, face, row, (-70.0, 2.4 * drawn.radius_px))
        paint_halves(canvas, (x, row), drawn.radius_px, frame * TURN_RAD)
        frames.append(to_luma(canvas, 0.8, rng))
    write_clip(path, frames, WriteOptions(crf=8, preset="superfast"))

    with open_footage(path) as footage, observe(view_of(footage)) as seen:
        track = pair_tracks(seen.movers, seen.frames, seen.view)[0]

    assert track.ball_diameter_px == pytest.approx(2 * drawn.radius_px, abs=2.0)
    error = track.ball.position_px - drawn.ball_px
    assert np.isfinite(error).mean() > 0.9
    assert np.sqrt(np.nanmedian(error**2)) < SURFACE_PX

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import pytest
from drawn import (
    Luma,
    Scene,
    background,
    displaced,
    paint_box,
    paint_cylinder,
    to_luma,
)

from count_video.records import Floats
from count_video.tracking import bodies
from count_video.tracking.background import background_of
from count_video.tracking.camera import Motion, camera_motion, scenery
from count_video.tracking.light import Light
from count_video.tracking.samples import Thumbnails
from count_video.tracking.sequences import chosen
from count_video.tracking.shape import Box

FRAMES = 96
SAMPLES = 29
SHIFT_PX = 0.05
"""Four parts of some thousand px with slopes of some grey levels a px, noise of 0.8: 0.01 px, and
what the displacing of a picture adds."""
NORMAL_ERROR = (0.6, 1.6)
KNOCK_PX = 8.0
SEEN_SHARE = 0.9
"""In so many frames a shift is measured."""
DRIFT_PX, HIDDEN_SHARE = 3.5, 0.15
"""A part that is hidden in this share of the pictures lies in the median by half of it times the
drift, 0.5 px, beside the rest."""
CLEAR_SIGMAS = 4.0
"""No normal error of some dozen is larger."""
FAINT_SHARE = 0.3
"""Of the backdrop's usual contrast."""
SWEPT: list[Box] = [(40.0, 30.0, 270.0, 80.0)]
"""What ball and cylinder pass over."""


def scene() -> Scene:
    """A ball between a cylinder that comes and goes and a wall at its left, at 40 px."""
    time = np.arange(float(FRAMES))
    face = 190.0 - 1.2 * np.minimum(time, 60.0) + 1.0 * np.maximum(time - 60.0, 0)
    ball = np.minimum(90.0, face - 24.0 + 4.0 * np.sin(time / 3.0) ** 2 - 4.0)
    return Scene(ball_px=ball, face_px=face)


def measured(
    pictures: Sequence[Luma],
    shifts_px: Floats | None = None,
    swept: Sequence[Box] = (),
    lamp: Floats | None = None,
) -> Motion | None:
    """Measure the camera's motion, known to a px in some pictures; without shifts, none there."""
    some = np.linspace(0, len(pictures) - 1, SAMPLES).astype(int)
    rough = np.zeros((len(pictures), 2)) if shifts_px is None else np.round(shifts_px)
    lights = [Light() if lamp is None else Light(float(lamp[k])) for k in some]
    samples = chosen(pictures, some)
    parts = scenery(samples, background_of(samples, rough[some], lights), swept)
    every = [np.interp(range(len(pictures)), some, along) for along in rough[some].T]
    return camera_motion(parts, pictures, np.stack(every, axis=1))


def shake(count: int = FRAMES) -> Floats:
    """A tremble of 3 px, and a knock; shape (count, 2)."""
    time = np.arange(float(count))
    tremble = np.stack([3.0 * np.sin(time / 5.0), 1.5 * np.sin(time / 7.0 + 1.0)], axis=1)
    tremble[count // 2 :, 0] += KNOCK_PX * np.exp(-(time[count // 2 :] - count // 2) / 6.0)
    return tremble


def shaken(pictures: Sequence[Luma], shifts_px: Floats) -> list[Luma]:
    return [displaced(p, (x, y)) for p, (x, y) in zip(pictures, shifts_px, strict=True)]


def errors(motion: Motion | None, shifts_px: Floats) -> Floats:
    assert motion is not None
    away = motion.shift_px - shifts_px
    return np.asarray(away - np.median(away, axis=0))


@pytest.fixture(scope="module")
def still() -> list[Luma]:
    return scene().frames()


@pytest.mark.parametrize("swept", [SWEPT, []], ids=["bodies known", "bodies not known"])
def test_a_shaken_camera_is_followed_from_its_first_frame_on(
    still: list[Luma], swept: list[Box]
) -> None:
    shifts = shake()
    motion = measured(shaken(still, shifts), shifts, swept)

    assert float(np.std(errors(motion, shifts), axis=0).max()) <= SHIFT_PX


def test_a_tremble_of_half_a_pixel_is_followed_where_nothing_is_known_of_it(
    still: list[Luma],
) -> None:
    rng = np.random.default_rng(5)
    tremble = rng.normal(0.0, 0.5, (FRAMES, 2))
    motion = measured(shaken(still, tremble), swept=SWEPT)

    assert float(np.std(errors(motion, tremble), axis=0).max()) <= 2 * SHIFT_PX


def test_brightness_and_contrast_do_not_move_the_picture(still: list[Luma]) -> None:
    shifts = shake()
    lamp = 0.85 + 0.15 * np.sin(np.arange(FRAMES))
    dimmed = [
        to_luma(share * one + 10.0)
        for one, share in zip(shaken(still, shifts), lamp.tolist(), strict=True)
    ]
    motion = measured(dimmed, shifts, SWEPT, lamp)

    assert float(np.std(errors(motion, shifts), axis=0).max()) <= 2 * SHIFT_PX


def test_the_stated_uncertainty_is_that_of_the_shifts() -> None:
    shifts = shake()
    motion = measured(shaken(scene().frames(noise=5.0), shifts), shifts, SWEPT)

    assert motion is not None
    scaled = errors(motion, shifts) / motion.sigma_px
    rms = np.sqrt(np.mean(scaled**2, axis=0))
    assert NORMAL_ERROR[0] < rms.min()
    assert rms.max() < NORMAL_ERROR[1]


def test_a_knock_in_a_still_clip_is_noticed_without_delay(still: list[Luma]) -> None:
    knocked = np.zeros((FRAMES, 2))
    knocked[50:58, 0] = KNOCK_PX * np.sin(np.pi * (np.arange(8) + 1) / 9)
    motion = measured(shaken(still, knocked), knocked, SWEPT)

    assert motion is not None
    assert motion.shift_px[:, 0] == pytest.approx(knocked[:, 0], abs=3 * SHIFT_PX)


def test_a_picture_of_something_else_has_no_shift(still: list[Luma]) -> None:
    shifts = shake()
    pictures = shaken(still, shifts)
    pictures[41] = to_luma(background((112, 320), seed=77))
    motion = measured(pictures, shifts, SWEPT)

    assert motion is not None
    assert np.flatnonzero(np.isnan(motion.shift_px[:, 0])).tolist() == [41]


def test_a_camera_at_rest_is_left_alone(still: list[Luma]) -> None:
    assert measured(still, swept=SWEPT) is None
    assert measured(still) is None


def test_a_picture_without_texture_shows_no_motion() -> None:
    plain = [np.full((112, 320), 90, dtype=np.uint8) for _ in range(2 * SAMPLES)]

    assert measured(plain) is None


def test_faint_textures_that_rise_and_fall_between_straight_edges_are_no_scenery() -> None:
    # The edges lie where they lay however far the picture moves along them.
    rng = np.random.default_rng(1)
    column = np.arange(320.0)
    posts = 20 * sum(np.tanh((column - x) / 2) * (-1) ** x for x in (31, 90, 155, 210, 284))
    texture = cv2.GaussianBlur(rng.normal(110.0, 20.0, (112, 320)), (0, 0), 1.5)
    moved = {step: displaced(to_luma(texture), (0.0, step / 4)) for step in range(-8, 9)}
    phases = rng.uniform(0, 2 * np.pi, 40)
    pictures = []
    for time in range(FRAMES):
        steps = np.rint(8 * np.sin(time / 7 + phases)).astype(int).tolist()
        strips = [moved[step][:, 8 * k : 8 * k + 8] for k, step in enumerate(steps)]
        pictures.append(to_luma(posts + np.concatenate(strips, axis=1)))

    assert measured(pictures) is None


def test_a_few_patches_that_move_each_its_own_way_are_no_scenery() -> None:
    turn = 2 * np.pi * np.arange(4) / 4
    pictures = []
    for time in range(2 * SAMPLES):
        picture = np.full((112, 320), 90.0)
        for column, phase in enumerate(turn + time / 3.0):
            patch = to_luma(background((14, 14), seed=column))
            there = displaced(patch, (1.8 * np.sin(phase), 1.8 * np.cos(phase)))
            picture[40:54, 30 + 64 * column : 44 + 64 * column] = there
        pictures.append(to_luma(picture))

    assert measured(pictures) is None


def test_a_body_before_a_plain_wall_is_no_scenery() -> None:
    body = background((36, 40), seed=3)
    pictures = []
    for time in range(2 * SAMPLES):
        picture = np.full((112, 320), 90.0)
        paint_box(picture, (20.0, 20.0, 26.0, 26.0), 150.0)
        paint_box(picture, (290.0, 90.0, 296.0, 96.0), 150.0)
        left = 120 + round(5.0 * np.sin(time / 4.0))
        picture[30:66, left : left + 40] = body
        pictures.append(to_luma(picture))

    assert measured(pictures, swept=[(115.0, 30.0, 165.0, 66.0)]) is None


def test_a_bright_body_that_all_but_rests_is_no_scenery() -> None:
    """The cylinder creeps by a pixel in the middle of the clip, before a faint backdrop."""
    creeping = np.interp(np.arange(float(FRAMES)), [0, 12, 80, FRAMES], [160, 140.5, 139.5, 125])
    faint = 125.0 + FAINT_SHARE * (background((112, 320)) - 125.0)
    rng = np.random.default_rng(2)
    pictures = []
    for face in creeping:
        canvas = faint.copy()
        paint_cylinder(canvas, float(face), 56.0, (70.0, 43.0))
        pictures.append(to_luma(canvas, 0.8, rng))

    assert measured(pictures, swept=[(125.0, 34.0, 230.0, 78.0)]) is None


def test_threads_that_swing_above_a_body_are_no_scenery() -> None:
    # Before a plain wall with one edge, threads have the clearest slopes along the motion.
    rng = np.random.default_rng(2)
    shifts = np.stack([2.0 * np.sin(np.arange(FRAMES) / 6.0), np.zeros(FRAMES)], axis=1)
    swing = np.where(np.arange(FRAMES) < 60, 0.0, 12.0 * np.sin((np.arange(FRAMES) - 60) / 8.0))
    pictures = []
    for shift, away in zip(shifts[:, 0], swing, strict=True):
        canvas = np.full((160, 320), 150.0)
        paint_box(canvas, (250.0 + shift, 0.0, 330.0, 160.0), 128.0)
        for thread in (96.0, 104.0, 112.0):
            paint_box(canvas, (thread + away + shift, 0.0, thread + 2 + away + shift, 80.0), 60.0)
        paint_box(canvas, (80.0 + away + shift, 80.0, 130.0 + away + shift, 120.0), 70.0)
        pictures.append(to_luma(canvas, 0.8, rng))

    motion = measured(pictures, shifts, swept=[(66.0, 78.0, 144.0, 122.0)])

    assert motion is not None
    away = motion.shift_px[:, 0] - shifts[:, 0]
    assert np.isfinite(away).mean() > SEEN_SHARE
    assert float(np.nanstd(away)) <= SHIFT_PX


def test_pictures_that_lose_the_edges_along_the_motion_keep_their_place_across(
    still: list[Luma],
) -> None:
    # A smear by y leaves edges that show x, and hardly any that show y.
    shifts = shake() * (1.0, 0.0)
    smeared = np.arange(FRAMES) % 4 == 1
    pictures = [
        to_luma(cv2.blur(one, (1, 9))) if lost else one
        for one, lost in zip(shaken(still, shifts), smeared, strict=True)
    ]
    motion = measured(pictures, shifts, SWEPT)

    assert motion is not None
    assert np.isfinite(motion.shift_px[:, 0]).all()
    assert float(np.std(errors(motion, shifts)[:, 0])) <= 2 * SHIFT_PX


def test_pictures_that_hide_most_of_the_scenery_keep_their_place_less_surely(
    still: list[Luma],
) -> None:
    shifts, few, hidden = shake(), FRAMES // 8, 192
    pictures = shaken(still, shifts)
    for number, one in enumerate(pictures[:few]):
        one[:, :hidden] = background((112, 320), seed=number)[:, :hidden]

    motion = measured(pictures, shifts, SWEPT)

    assert motion is not None
    assert np.isfinite(motion.shift_px).all()
    sigma_px = motion.sigma_px[:, 0]
    assert np.median(sigma_px[:few]) > 1.5 * np.median(sigma_px[few:])
    assert (np.abs(errors(motion, shifts)[:few, 0]) < CLEAR_SIGMAS * sigma_px[:few]).all()


def test_a_drift_is_followed_by_scenery_of_which_some_pictures_hide_a_part() -> None:
    """The median of that part is where the camera was in the other pictures: it lies beside."""
    rng = np.random.default_rng(3)
    drift = np.stack([np.linspace(-DRIFT_PX, DRIFT_PX, FRAMES), np.zeros(FRAMES)], axis=1)
    canvas = np.full((112, 320), 100.0)
    for x in (60.0, 260.0):
        paint_box(canvas, (x, -1.0, x + 8.0, 113.0), 180.0)
    bars = to_luma(cv2.GaussianBlur(canvas, (0, 0), 2.0))
    pictures = []
    for number, one in enumerate(shaken([bars] * FRAMES, drift)):
        shown = one.astype(np.float64)
        if number < HIDDEN_SHARE * FRAMES:
            shown[:, 200:] = 100.0
        pictures.append(to_luma(shown, 0.8, rng))

    motion = measured(pictures)

    assert motion is not None
    away = (motion.shift_px - drift)[round(HIDDEN_SHARE * FRAMES) :, 0]
    assert np.isfinite(away).mean() >= SEEN_SHARE
    assert float(np.nanstd(away)) <= 2 * SHIFT_PX


@pytest.mark.parametrize("camera_moves", [True, False])
def test_what_bodies_do_not_share_is_not_the_camera(
    camera_moves: bool, still: list[Luma], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Encoders drag the faint texture of a wall along; a camera moves all that it shows."""
    shifts = shake()
    said = Motion(shifts, np.full(shifts.shape, SHIFT_PX))
    monkeypatch.setattr(bodies, "camera_motion", lambda *_: said)
    pictures = shaken(still, shifts) if camera_moves else still
    thumbnails = Thumbnails()
    for row, picture in enumerate(pictures):
        thumbnails.add(row, picture)

    found = bodies.find_movers(pictures, np.arange(FRAMES), thumbnails)

    assert found.bodies
    assert (found.shift_px is not None) is camera_moves

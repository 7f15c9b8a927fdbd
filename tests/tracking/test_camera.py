from __future__ import annotations

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
from count_video.tracking.camera import Camera
from count_video.tracking.displacement import measure
from count_video.tracking.landmarks import (
    WINDOW_PX,
    Landmarks,
    agreement,
    clear_of,
    correlations_of,
    evidence,
)
from count_video.tracking.standing import landmarks_of

FRAMES = 96
SAMPLES = 32
SHIFT_PX = 0.05
"""Two dozen windows with slopes of some grey levels a px, noise of 0.8: 0.01 px, and what the
displacing of a picture adds."""
SIGMAS = 3.0
NORMAL_ERROR = (0.6, 1.6)
KNOCK_PX = 8.0
FAINT_SHARE = 0.3
"""Of the backdrop's usual contrast."""
ALONG_SHARE = 0.02
"""Of what all landmarks say of the shift along."""


def scene() -> Scene:
    """A ball between a cylinder that comes and goes and a wall at its left, at 40 px."""
    time = np.arange(float(FRAMES))
    face = 190.0 - 1.2 * np.minimum(time, 60.0) + 1.0 * np.maximum(time - 60.0, 0)
    ball = np.minimum(90.0, face - 24.0 + 4.0 * np.sin(time / 3.0) ** 2 - 4.0)
    return Scene(ball_px=ball, face_px=face)


def seen_in(pictures: list[Luma], shifts_px: Floats | None = None) -> Landmarks | None:
    """What stands still in pictures whose shifts are known to a px; without shifts, at rest."""
    some = np.linspace(0, len(pictures) - 1, SAMPLES).astype(int)
    rough = np.zeros((SAMPLES, 2)) if shifts_px is None else np.round(shifts_px[some])
    return landmarks_of([pictures[k] for k in some], rough)


def shake(count: int = FRAMES) -> Floats:
    """A tremble of 3 px, and a knock; shape (count, 2)."""
    time = np.arange(float(count))
    tremble = np.stack([3.0 * np.sin(time / 5.0), 1.5 * np.sin(time / 7.0 + 1.0)], axis=1)
    tremble[count // 2 :, 0] += KNOCK_PX * np.exp(-(time[count // 2 :] - count // 2) / 6.0)
    return tremble


@pytest.fixture(scope="module")
def still() -> list[Luma]:
    return scene().frames()


@pytest.fixture(scope="module")
def landmarks(still: list[Luma]) -> Landmarks:
    found = seen_in(still)
    assert found is not None
    return found


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.4, -0.3), (-2.6, 1.2), (KNOCK_PX, 2.0)])
def test_the_shift_of_a_displaced_picture_is_measured(
    still: list[Luma], landmarks: Landmarks, shift: tuple[float, float]
) -> None:
    found = measure(displaced(still[5], shift), landmarks, (0.0, 0.0))

    assert found is not None
    assert max(found.sigma_x_px, found.sigma_y_px) < 2 * SHIFT_PX
    assert abs(found.x_px - shift[0]) <= SIGMAS * found.sigma_x_px
    assert abs(found.y_px - shift[1]) <= SIGMAS * found.sigma_y_px


def test_brightness_and_contrast_do_not_move_the_picture(
    still: list[Luma], landmarks: Landmarks
) -> None:
    dimmed = to_luma(0.75 * still[5].astype(float) + 10.0)

    found = measure(dimmed, landmarks, (0.0, 0.0))

    assert found is not None
    assert found.place == pytest.approx((0.0, 0.0), abs=SHIFT_PX)


def test_the_stated_uncertainty_is_that_of_the_shifts(landmarks: Landmarks) -> None:
    drawn = scene()
    behind = Scene(drawn.ball_px, drawn.face_px).frames(noise=5.0, seed=0)
    found = [measure(picture, landmarks, (0.0, 0.0)) for picture in behind]

    errors = [shift.x_px / shift.sigma_x_px for shift in found if shift is not None]
    assert len(errors) == FRAMES
    assert NORMAL_ERROR[0] < float(np.sqrt(np.mean(np.square(errors)))) < NORMAL_ERROR[1]


def test_what_moves_has_no_part_in_the_motion_along(landmarks: Landmarks) -> None:
    """The cylinder, 70 px long, sweeps the rows about the middle; its stripes may stand out."""
    drawn = scene()
    first, last = float(drawn.face_px.min()), float(drawn.face_px.max()) + 70.0
    middle = np.array(landmarks.left) + 5, np.array(landmarks.top) + 5
    swept = (first < middle[0]) & (middle[0] < last)
    swept &= np.abs(middle[1] - 55.5) < drawn.radius_px - 5
    stated = landmarks.normal[:, 0, 0]
    assert stated[swept].sum() <= ALONG_SHARE * stated.sum()


def test_another_picture_does_not_show_the_landmarks(landmarks: Landmarks) -> None:
    other = to_luma(background((112, 320), seed=77))

    assert measure(other, landmarks, (0.0, 0.0)) is None


def test_a_picture_without_texture_has_no_landmarks() -> None:
    plain = [np.full((112, 320), 90, dtype=np.uint8) for _ in range(2 * SAMPLES)]

    assert seen_in(plain) is None


def test_a_few_windows_that_move_each_its_own_way_are_no_scenery() -> None:
    turn = 2 * np.pi * np.arange(4) / 4
    pictures = []
    for time in range(2 * SAMPLES):
        picture = np.full((112, 320), 90.0)
        for column, phase in enumerate(turn + time / 3.0):
            patch = to_luma(background((14, 14), seed=column))
            there = displaced(patch, (1.8 * np.sin(phase), 1.8 * np.cos(phase)))
            picture[40:54, 30 + 64 * column : 44 + 64 * column] = there
        pictures.append(to_luma(picture))

    assert seen_in(pictures) is None


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

    camera = Camera(seen_in(pictures))
    for picture in pictures:
        camera.see(picture)

    assert camera.motion() is None


def test_a_camera_at_rest_is_left_alone(still: list[Luma]) -> None:
    camera = Camera(seen_in(still))

    heeded = [camera.see(picture) for picture in still]

    assert camera.motion() is None
    assert set(heeded) == {(0.0, 0.0)}


def test_without_landmarks_the_camera_is_taken_to_stand(still: list[Luma]) -> None:
    camera = Camera(None)

    assert camera.see(still[0]) == (0.0, 0.0)
    assert camera.motion() is None


def test_a_shaken_camera_is_followed_from_its_first_frame_on(still: list[Luma]) -> None:
    shifts = shake()
    shaken = [displaced(p, (x, y)) for p, (x, y) in zip(still, shifts, strict=True)]

    camera = Camera(seen_in(shaken, shifts))
    for picture in shaken:
        camera.see(picture)
    motion = camera.motion()

    assert motion is not None
    error = motion.shift_px - shifts
    assert float(np.std(error, axis=0).max()) <= SHIFT_PX


def test_a_knock_in_a_still_clip_is_noticed_without_delay(still: list[Luma]) -> None:
    knocked = np.zeros((FRAMES, 2))
    knocked[50:58, 0] = KNOCK_PX * np.sin(np.pi * (np.arange(8) + 1) / 9)
    shaken = [displaced(p, (x, y)) for p, (x, y) in zip(still, knocked, strict=True)]
    camera = Camera(seen_in(still))

    for picture in shaken:
        camera.see(picture)
    motion = camera.motion()

    assert motion is not None
    assert motion.shift_px[:, 0] == pytest.approx(knocked[:, 0], abs=3 * SHIFT_PX)


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

    camera = Camera(seen_in(pictures))
    for picture in pictures:
        camera.see(picture)

    assert camera.motion() is None


def test_windows_seen_surely_outweigh_more_that_are_a_little_alike() -> None:
    """Half of them hidden and half exact, against all of them at a correlation of 0.8."""
    rng = np.random.default_rng(4)
    appearance = rng.normal(size=(12, 121))
    appearance -= appearance.mean(axis=1, keepdims=True)
    other = rng.normal(size=appearance.shape)
    half = np.where(np.arange(12)[:, None] % 2 == 0, appearance, other)
    hidden = correlations_of(half, appearance)
    alike = correlations_of(0.8 * appearance + 0.6 * other, appearance)

    assert agreement(hidden) < agreement(alike)
    assert evidence(hidden) > evidence(alike)


def test_what_bodies_sweep_is_left_out_unless_too_little_is_left(landmarks: Landmarks) -> None:
    middle = sorted(landmarks.left)[len(landmarks.left) // 2]

    half = clear_of(landmarks, [(middle, 0.0, 320.0, 112.0)])
    everything = clear_of(landmarks, [(0.0, 0.0, 320.0, 112.0)])

    assert max(half.left) + WINDOW_PX <= middle
    assert half.normal.shape == (len(half.left), 2, 2)
    assert everything is landmarks

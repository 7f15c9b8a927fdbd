from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drawn import Scene, as_frames, background, paint_ball, to_luma

from count_video.tracking.pairs.features import MovingFeatures, moving_features
from count_video.tracking.pairs.seeds import (
    Patch,
    motion_direction_deg,
    pairs_across_runs,
    patches,
    rank_pairs,
)

RUN = np.arange(12.0)
SPEED_PX_FRAME = 0.1
SMALL_PX = 6.0
DIRECTION_DEG = 1.5
FLICKER = 0.15


def run_of(scene: Scene) -> MovingFeatures:
    return moving_features(as_frames(scene.frames()))


def moving(tilt_deg: float = 0.0) -> Scene:
    return Scene(ball_px=80.0 + 1.5 * RUN, face_px=190.0 - 0.8 * RUN, tilt_deg=tilt_deg)


def test_a_close_look_tells_the_speeds_of_bodies_of_a_few_px() -> None:
    pictures = []
    for time in RUN:
        canvas = np.asarray(background((80, 200), seed=5), dtype=np.float64)
        paint_ball(canvas, 120.0 + 0.4 * time, 40.0, SMALL_PX)
        paint_ball(canvas, 100.0 + 0.1 * time, 40.0, SMALL_PX)
        pictures.append(to_luma(canvas))

    close = moving_features(as_frames(pictures), close=True)

    right = close.x_px > 120.0 + 0.4 * 5.5 - SMALL_PX
    assert close.grain_px == 0.5
    assert min(right.sum(), (~right).sum()) >= 5
    for speed, body in ((0.4, right), (0.1, ~right)):
        found = np.median(close.speed_x_px_frame[body])
        assert found == pytest.approx(speed, abs=SPEED_PX_FRAME / 2)


def test_features_of_both_bodies_move_as_they_do() -> None:
    found = run_of(moving())

    ball = np.hypot(found.x_px - (80.0 + 1.5 * 5.5), found.y_px - 55.5) < 20.0
    heavy = found.x_px > 170.0
    assert ball.sum() >= 5
    assert heavy.sum() >= 5
    assert np.median(found.speed_x_px_frame[ball]) == pytest.approx(1.5, abs=SPEED_PX_FRAME)
    assert np.median(found.speed_x_px_frame[heavy]) == pytest.approx(-0.8, abs=SPEED_PX_FRAME)
    assert found.frame == 5.5
    assert found.span_frames == 11.0


def test_lamps_that_flicker_hide_no_features() -> None:
    steady = moving().frames()
    lamps = 1 + FLICKER * np.sin(2.1 * RUN)
    flickering = [to_luma(lamp * luma) for lamp, luma in zip(lamps, steady, strict=True)]

    found = moving_features(as_frames(flickering))

    for speed, left, right in ((1.5, 60.0, 120.0), (-0.8, 170.0, 270.0)):
        body = (found.x_px > left) & (found.x_px < right)
        assert body.sum() >= 5
        assert np.median(found.speed_x_px_frame[body]) == pytest.approx(speed, abs=SPEED_PX_FRAME)


def test_nothing_moves_in_a_still_picture() -> None:
    still = Scene(ball_px=np.full(12, 80.0), face_px=np.full(12, 190.0))

    assert len(run_of(still).x_px) == 0


def test_a_run_of_three_frames_shows_nothing() -> None:
    found = moving_features(as_frames(moving().frames()[:3]))

    assert len(found.x_px) == 0


@pytest.mark.parametrize("tilt_deg", [-8.0, -3.0, 0.0, 5.0, 8.0])
def test_the_line_of_motion_is_found_at_any_tilt(tilt_deg: float) -> None:
    direction = motion_direction_deg([run_of(moving(tilt_deg))])

    assert direction == pytest.approx(tilt_deg, abs=DIRECTION_DEG)


def test_nothing_that_moves_gives_no_direction() -> None:
    assert motion_direction_deg([]) is None


def test_the_two_bodies_are_two_patches_from_left_to_right() -> None:
    found = patches(run_of(moving()), 0.0, 320)

    assert len(found) == 2
    left, right = found
    assert left.speed_px_frame == pytest.approx(1.5, abs=SPEED_PX_FRAME)
    assert right.speed_px_frame == pytest.approx(-0.8, abs=SPEED_PX_FRAME)
    assert left.right_px < right.left_px
    assert left.left_px > 80.0 + 1.5 * 5.5 - 22.0
    assert left.right_px < 80.0 + 1.5 * 5.5 + 22.0


def a_patch(frame: float, left: float, speed: float, features: int = 20) -> Patch:
    return Patch(frame, 11.0, speed, left, left + 30.0, 40.0, 70.0, features)


def test_a_pair_moves_at_different_velocities() -> None:
    alike = [a_patch(5, 50, 1.0), a_patch(5, 120, 1.0)]
    apart = [a_patch(5, 50, 1.0), a_patch(5, 120, -1.0)]

    assert rank_pairs([alike]) == []
    (pair,) = rank_pairs([apart])
    assert (pair.left, pair.right) == tuple(apart)


def test_bodies_at_different_heights_are_no_pair() -> None:
    low = replace(a_patch(5, 120, -1.0), top_px=80.0, bottom_px=110.0)

    assert rank_pairs([[a_patch(5, 50, 1.0), low]]) == []


def test_the_pair_with_more_features_comes_first() -> None:
    poor = [a_patch(5, 50, 1.0, 6), a_patch(5, 120, -1.0, 40)]
    rich = [a_patch(30, 50, 1.0, 30), a_patch(30, 120, -1.0, 25)]

    assert [pair.left.frame for pair in rank_pairs([poor, rich])] == [30, 5]


def test_bodies_that_move_in_turns_pair_across_runs() -> None:
    runs = [[a_patch(5, 120, -1.0)], [a_patch(30, 50, -1.0)]]

    (pair,) = pairs_across_runs(runs)

    assert (pair.left.frame, pair.right.frame) == (30, 5)

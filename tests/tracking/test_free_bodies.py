from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from drawn import Luma, background, paint_ball, paint_box, paint_disc, to_luma

from count_video.errors import TrackingError
from count_video.records import Floats, Track, TrialResult
from count_video.reports.material import Material
from count_video.tracking.observation import observe
from count_video.tracking.pairing import pair_tracks
from count_video.tracking.single import single_tracks
from count_video.tracking.view import view_of
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

SHAPE = (160, 240)
RADIUS_PX = 10.0
FRAMES = 60
PLACED_PX = 0.5
"""RMS of the centre of a patch about its mean offset: a fraction of a pixel of its outline."""


def bounce(frames: int = FRAMES) -> tuple[Floats, Floats]:
    """A ball's centre that drifts to the right and bounces on a floor every 20 frames."""
    frame = np.arange(frames)
    phase = frame % 20 - 10.0
    return 40.0 + 2.0 * frame, 140.0 - 0.9 * (100.0 - phase**2)


def drawn(
    paths: Sequence[tuple[Floats, Floats]], noise: float = 1.0, radius: float = RADIUS_PX
) -> list[Luma]:
    rng = np.random.default_rng(3)
    behind = background(SHAPE, 5)
    pictures = []
    for place in zip(*(zip(*path, strict=True) for path in paths), strict=True):
        canvas = behind.copy()
        for x, y in place:
            paint_ball(canvas, x, y, radius)
        pictures.append(to_luma(canvas, noise, rng))
    return pictures


def tracks_of(folder: Path, pictures: Sequence[Luma], *, pair: bool = False) -> list[Track]:
    path = folder / "clip.mp4"
    write_clip(path, pictures, WriteOptions(crf=16))
    with open_footage(path) as footage, observe(view_of(footage)) as seen:
        return pair_tracks(seen.movers, seen.frames, seen.view) if pair else single_tracks(seen)


def track_of(folder: Path, pictures: Sequence[Luma], *, pair: bool = False) -> Track:
    track = tracks_of(folder, pictures, pair=pair)[0]
    assert isinstance(track.ball_diameter_px, float), "a kept result is read back as it was written"
    return track


def test_a_lone_ball_is_followed_along_the_line_of_its_bounces(tmp_path: Path) -> None:
    x, y = bounce()

    track = track_of(tmp_path, drawn([(x, y)]))

    assert track.heavy is None
    assert track.line.upright
    assert track.line.tilt_deg == pytest.approx(0.0, abs=3.0)
    seen = np.isfinite(track.ball.position_px)
    assert seen.mean() > 0.9
    tilt = np.tan(np.radians(track.line.tilt_deg))
    error = (track.ball.position_px - y - tilt * (x - x.mean()))[seen]
    assert float(np.std(error)) <= PLACED_PX
    assert track.wall_side == "right"  # below: positions grow downward
    shown = Material(TrialResult("", "counted", None), track)
    places = [shown.image_point(row, track.ball.position_px[row]) for row in np.flatnonzero(seen)]
    away = np.array(places) - np.stack([x, y], axis=1)[seen]
    assert away.std(axis=0) == pytest.approx(0.0, abs=PLACED_PX), "also across that line"
    assert track.ball_diameter_px == pytest.approx(2 * RADIUS_PX, abs=4.0)


def test_a_title_at_the_start_shows_no_body(tmp_path: Path) -> None:
    pictures = drawn([bounce()])
    title = background(SHAPE, 5)
    paint_box(title, (20.0, 20.0, 220.0, 120.0), 250.0)

    track = track_of(tmp_path, [to_luma(title)] * 3 + pictures)

    assert track.frame[0] == 3  # another shot begins with the first picture of the body
    assert np.isfinite(track.ball.position_px).mean() > 0.9


def test_two_bodies_stay_apart_through_their_contact(tmp_path: Path) -> None:
    time = np.arange(-30, 30) + 0.5
    left = 118.0 - RADIUS_PX + np.where(time < 0, 3.0, -1.5) * time
    right = 118.0 + RADIUS_PX + np.where(time < 0, -1.5, 3.0) * time
    level = np.full(60, 80.0)

    track = track_of(tmp_path, drawn([(left, level), (right, level)]), pair=True)

    assert track.heavy is not None
    for body, truth in ((track.ball, left), (track.heavy, right - RADIUS_PX)):
        error = body.position_px - truth
        assert np.isfinite(error).mean() > 0.8
        assert float(np.nanstd(error)) <= PLACED_PX


@pytest.mark.parametrize("speed_px", [1.0, 6.0])
def test_a_body_that_is_seen_no_more_is_lost_unless_it_leaves_the_picture(
    tmp_path: Path, speed_px: float
) -> None:
    time = np.arange(-30, 30) + 0.5
    left = 118.0 - RADIUS_PX + np.where(time < 0, 3.0, -1.0) * time
    right = 118.0 + RADIUS_PX + np.where(time < 0, -1.0, speed_px) * time
    leaves, gone = speed_px > 5.0, 50
    if not leaves:
        right[gone:] = -100.0  # as behind a curtain

    track = track_of(
        tmp_path, drawn([(left, 0 * left + 80.0), (right, 0 * left + 80.0)]), pair=True
    )

    assert track.lost_beyond == pytest.approx([] if leaves else [gone - 1.0], abs=1.0)


def test_nothing_that_moves_is_said_so(tmp_path: Path) -> None:
    still = to_luma(background(SHAPE, 5), 1.0, np.random.default_rng(0))

    with pytest.raises(TrackingError, match="nothing moves"):
        track_of(tmp_path, [still + np.uint8(number % 2) for number in range(30)])


def test_three_bodies_that_move_apart_are_each_followed(tmp_path: Path) -> None:
    frame = np.arange(50)
    paths = [(60.0 + 50 * np.sin(frame / 8 + k), np.full(50, 30.0 + 45 * k)) for k in range(3)]

    tracks = tracks_of(tmp_path, drawn(paths))

    assert sorted(track.line.anchor_y_px for track in tracks) == pytest.approx(
        [30.0, 75.0, 120.0], abs=RADIUS_PX / 2
    )


def test_a_camera_that_moves_is_refused(tmp_path: Path) -> None:
    wide = background((SHAPE[0], 2 * SHAPE[1]), 5)
    rng = np.random.default_rng(1)
    for _ in range(150):
        paint_disc(wide, rng.uniform(0, 480), rng.uniform(0, 160), 6.0, rng.uniform(0, 250))
    pictures = [to_luma(wide[:, 3 * k : 3 * k + SHAPE[1]]) for k in range(40)]

    with pytest.raises(TrackingError):
        track_of(tmp_path, pictures)


def test_like_bodies_that_rest_before_and_after_they_meet_are_no_scenery(tmp_path: Path) -> None:
    # The right one rests for 30 of 60 frames, the left one stays where it struck it.
    time = np.arange(-30, 30) + 0.5
    left = 118.0 - RADIUS_PX + np.where(time < 0, 2.5 * time, 0.0)
    right = 118.0 + RADIUS_PX + np.where(time < 0, 0.0, 2.5 * time)
    level = np.full(60, 80.0)

    track = track_of(tmp_path, drawn([(left, level), (right, level)]), pair=True)

    assert track.heavy is not None
    for body, truth in ((track.ball, left), (track.heavy, right - RADIUS_PX)):
        error = body.position_px - truth
        assert np.isfinite(error).all()
        assert float(np.std(error)) <= PLACED_PX

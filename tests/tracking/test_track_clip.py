from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn import FRAMES, RADIUS_PX, Scene, background, displaced, scene, to_luma

from count_video.errors import UsageError
from count_video.records import Track
from count_video.tracking import bodies
from count_video.tracking.observation import observe
from count_video.tracking.pairing import pair_tracks
from count_video.tracking.view import view_of
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

PLACED_PX = 0.05
"""RMS of positions about their mean offset, in a clean clip."""
SHAKEN_PX = 0.15
"""Encoders displace what moves by quarters of a px, and now everything moves."""
CORNERS_PX = 0.3
"""A corner errs by so much, and all of them together where an encoder holds the background back."""
SHAKE_PX = 3.0
"""The picture that positions refer to may lie so far from the middle of the tremble."""
FAINT = 0.2
FAINT_PX = 0.15
"""Of the ball's contrast only so much is left; its noise counts for so much more."""
OUTLINE_PX = 1.0
"""Outlines are found to about half a pixel on either side."""
TILT_DEG = 1.0


def track_of(path: Path, wall=None, **part) -> Track:
    with open_footage(path) as footage, observe(view_of(footage, **part)) as seen:
        return pair_tracks(seen.movers, seen.frames, seen.view, wall)[0]


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("clips") / "trial.mp4"
    write_clip(path, scene().frames(), WriteOptions(crf=8, preset="superfast"))
    return path


def check_positions(
    track: Track, drawn: Scene, placed_px: float = PLACED_PX, offset_px: float = OUTLINE_PX
) -> None:
    rows = track.frame.astype(int)
    assert track.heavy is not None
    for body, truth in ((track.ball, drawn.ball_px), (track.heavy, drawn.face_px)):
        error = body.position_px - truth[rows]
        assert np.isfinite(error).all()
        assert float(np.std(error)) <= placed_px
        assert abs(float(np.mean(error))) <= offset_px


def test_positions_are_those_that_were_drawn(clip: Path) -> None:
    track = track_of(clip)

    assert track.frame.tolist() == list(range(FRAMES))
    assert track.wall_side == "left"
    assert track.ball_diameter_px == pytest.approx(2 * RADIUS_PX, abs=2 * OUTLINE_PX)
    assert track.line.tilt_deg == pytest.approx(0.0, abs=TILT_DEG)
    assert not track.line.upright
    check_positions(track, scene())


@pytest.mark.parametrize("tilt_deg", [-8.0, 6.0])
def test_a_tilted_line_of_motion_is_followed(tmp_path: Path, tilt_deg: float) -> None:
    drawn = scene(tilt_deg, wall_left=tilt_deg > 0)
    write_clip(tmp_path / "tilted.mp4", drawn.frames(), WriteOptions(crf=8, preset="superfast"))

    track = track_of(tmp_path / "tilted.mp4")

    assert track.line.tilt_deg == pytest.approx(tilt_deg, abs=TILT_DEG)
    assert track.wall_side == ("left" if tilt_deg > 0 else "right")
    check_positions(track, drawn)


def test_positions_in_a_shaken_clip_are_those_of_a_still_camera(tmp_path: Path) -> None:
    time = np.arange(float(FRAMES))
    shake_px = SHAKE_PX * np.sin(time / 5.0), 1.5 * np.sin(time / 7.0)
    shaken = map(displaced, scene().frames(), zip(*shake_px, strict=True))
    write_clip(tmp_path / "shaken.mp4", shaken, WriteOptions(crf=14))

    check_positions(track_of(tmp_path / "shaken.mp4"), scene(), SHAKEN_PX, OUTLINE_PX + SHAKE_PX)


def test_where_no_scenery_shows_a_tremble_sharply_that_of_the_corners_is_taken_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bodies, "scenery", lambda *_: None)
    shake_px = SHAKE_PX * np.sin(np.arange(float(FRAMES)) / 5.0)
    shaken = map(displaced, scene().frames(), zip(shake_px, 0.0 * shake_px, strict=True))
    write_clip(tmp_path / "shaken.mp4", shaken, WriteOptions(crf=14))

    check_positions(track_of(tmp_path / "shaken.mp4"), scene(), CORNERS_PX, OUTLINE_PX + SHAKE_PX)


def test_a_faint_plain_ball_is_followed(tmp_path: Path) -> None:
    faint = replace(scene(), ball_contrast=FAINT)
    write_clip(tmp_path / "faint.mp4", faint.frames(), WriteOptions(crf=14))

    check_positions(track_of(tmp_path / "faint.mp4"), scene(), FAINT_PX)


def test_positions_within_a_region_are_those_of_the_whole_picture(clip: Path) -> None:
    check_positions(track_of(clip, region=(16, 20, 300, 80)), scene())


def test_start_and_end_choose_the_frames(clip: Path) -> None:
    track = track_of(clip, start=20, end=200)

    assert track.frame.tolist() == list(range(20, 200))


def test_start_and_end_do_not_move_the_bodies(clip: Path) -> None:
    check_positions(track_of(clip, start=20, end=200), scene())


def test_the_wall_stands_where_the_user_says(clip: Path) -> None:
    assert track_of(clip, wall="right").wall_side == "right"


@pytest.mark.parametrize("region", [(-1, 0, 50, 50), (300, 0, 50, 50), (0, 100, 50, 50)])
def test_a_region_beyond_the_picture_is_refused(
    clip: Path, region: tuple[int, int, int, int]
) -> None:
    with pytest.raises(UsageError, match="does not fit"):
        track_of(clip, region=region)


def test_a_clip_in_which_nothing_moves_has_no_bodies(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    still = [to_luma(background((112, 320)), 1.0, rng) for _ in range(40)]
    write_clip(tmp_path / "still.mp4", still, WriteOptions())

    with pytest.raises(IndexError):
        track_of(tmp_path / "still.mp4")

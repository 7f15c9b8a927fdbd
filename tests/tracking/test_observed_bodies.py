"""Bodies found in drawn clips, against where they were drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drawn import RADIUS_PX, scene

from count_video.records import Track
from count_video.tracking.observation import observe
from count_video.tracking.pairing import pair_tracks
from count_video.tracking.view import view_of
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip
from tiers import rest_slow

PLACED_PX = 0.05
"""RMS of positions about their mean offset, in a clean clip."""
OUTLINE_PX = 1.0
"""Outlines are found to about half a pixel on either side."""


def track_of(path: Path, wall=None, **part) -> Track:
    with open_footage(path) as footage, observe(view_of(footage, **part)) as seen:
        return pair_tracks(seen.movers, seen.frames, seen.view, wall)[0]


@pytest.fixture(
    scope="module",
    params=rest_slow(["wall left", "wall right, upright", "wall left, upright", "wall right"], 2),
)
def filmed(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, bool, bool]:
    side, upright = "left" in request.param, "upright" in request.param
    path = tmp_path_factory.mktemp("clips") / "trial.mp4"
    frames = (luma.T if upright else luma for luma in scene(wall_left=side).frames())
    write_clip(path, frames, WriteOptions(crf=8, preset="superfast"))
    return path, side, upright


def test_both_bodies_are_where_they_were_drawn(filmed: tuple[Path, bool, bool]) -> None:
    path, wall_left, upright = filmed
    track, drawn = track_of(path), scene(wall_left=wall_left)
    assert track.wall_seen
    assert track.wall_side == ("left" if wall_left else "right")
    assert track.line.upright == upright
    assert track.shift_px is None
    assert track.heavy is not None
    for found, truth in ((track.ball, drawn.ball_px), (track.heavy, drawn.face_px)):
        away = found.position_px - truth
        assert abs(float(np.median(away))) < OUTLINE_PX
        assert float(np.std(away)) < PLACED_PX
    assert track.ball_diameter_px == pytest.approx(2 * RADIUS_PX, abs=2 * OUTLINE_PX)


def test_a_part_of_the_clip_gives_the_same_places(filmed: tuple[Path, bool, bool]) -> None:
    path, wall_left, _ = filmed
    track = track_of(path, start=20, end=200)
    drawn = scene(wall_left=wall_left)
    assert track.frame[0] == 20
    assert track.frame[-1] == 199
    away = track.ball.position_px - drawn.ball_px[20:200]
    assert float(np.std(away)) < PLACED_PX


def test_a_clip_in_which_nothing_moves_shows_no_bodies(tmp_path: Path) -> None:
    path = tmp_path / "still.mp4"
    still = next(iter(scene().frames()))
    write_clip(path, [still] * 40, WriteOptions(crf=8, preset="superfast"))
    with (
        open_footage(path) as footage,
        observe(view_of(footage)) as seen,
    ):
        assert pair_tracks(seen.movers, seen.frames, seen.view) == []

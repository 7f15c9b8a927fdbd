"""What is drawn over shaken footage lies where the bodies are in the shaken picture."""

from __future__ import annotations

import json
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from outlines import OUTLINE_WITHIN_PX, drawn_shift

from count_video.evidence import EvidenceSettings, draw_evidence
from count_video.pipeline import TrialSettings, work_through
from count_video.records import Floats, Track
from count_video.reports.clip import HEADER_PX
from count_video.video.reader import open_footage
from synth_video.film import render_clip
from synth_video.scene_file import load_scene

SHAKE_PX = 3.0
EVERY = 12
"""The outline is sought in every so many frames."""


@pytest.fixture(scope="module")
def shaken(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Track]:
    """A clip with its evidence beside it, and what was followed in it."""
    path = tmp_path_factory.mktemp("shaken") / "shaken.mp4"
    short = ("clip.lead_frames=12", "clip.tail_frames=16")
    render_clip(load_scene("equal-masses", (f"tripod.shake_px={SHAKE_PX}", *short)), 3, path)
    trial = work_through(path, TrialSettings())
    draw_evidence(trial, EvidenceSettings(path.parent))
    assert trial.track is not None
    return path, trial.track


def lumas(path: Path) -> list[Floats]:
    with open_footage(path) as footage:
        return [frame.luma.astype(float) for frame in islice(footage.frames(), 0, None, EVERY)]


def centres(path: Path) -> tuple[Floats, float]:
    """Centre of the ball in each picture, shape (n, 2), and its diameter."""
    truth = json.loads(path.with_suffix(".truth.json").read_text("utf-8"))
    rows = truth["frames"]
    faces = [[row[f"ball_{face}_point_px"] for row in rows] for face in ("near", "far")]
    return np.array(faces).mean(axis=0), truth["ball_diameter_px"]


def test_outlines_follow_the_shake_and_positions_are_freed_of_it(
    shaken: tuple[Path, Track],
) -> None:
    clip, _ = shaken
    plain, shown = lumas(clip), lumas(clip.with_name("shaken.annotated.mp4"))
    centre, diameter_px = centres(clip)
    assert shown[0].shape[1] == plain[0].shape[1], "the clip is shown pixel by pixel"
    below = slice(HEADER_PX, HEADER_PX + plain[0].shape[0])
    off = [
        drawn_shift(np.abs(seen[below] - bare), tuple(place), diameter_px / 2)
        for seen, bare, place in zip(shown, plain, centre[::EVERY], strict=True)
    ]
    assert np.abs(off).max() <= OUTLINE_WITHIN_PX


def test_a_track_holds_how_its_camera_moved(shaken: tuple[Path, Track]) -> None:
    clip, track = shaken
    assert track.shift_px is not None
    assert track.shift_px.shape == (len(track.frame), 2)
    # What is left of the ball's truth once the measured shift is taken away is the line of motion.
    centre, _ = centres(clip)
    steady = centre[track.frame.astype(int)] - track.shift_px
    assert np.ptp(steady[:, 1]) < SHAKE_PX < np.ptp(centre[:, 1])
    along = track.ball.position_px - steady[:, 0]
    assert np.nanstd(along) < OUTLINE_WITHIN_PX / 2

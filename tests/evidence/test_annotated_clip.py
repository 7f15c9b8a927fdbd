from __future__ import annotations

import csv

import numpy as np
import pytest
from evidence_made import CLIP, Made, Truth
from outlines import OUTLINE_WITHIN_PX, drawn_shift

from coded import coding_of
from count_video.reports.clip import (
    BETWEEN_COLLISIONS_S,
    FORWARD_FPS,
    HEADER_PX,
    UNHURRIED_S,
    frame_times_s,
    layout_of,
)
from count_video.video.reader import open_footage


@pytest.fixture(scope="module")
def annotated(made: Made) -> list[np.ndarray]:
    """Brightness of every picture of the annotated clip."""
    with open_footage(made.file("annotated.mp4")) as footage:
        return [frame.luma.copy() for frame in footage.frames()]


def test_the_annotated_clip_has_a_picture_for_every_frame_of_the_track(made: Made) -> None:
    rows = list(csv.DictReader(made.file("track.csv").read_text("utf-8").splitlines()))
    with open_footage(made.file("annotated.mp4")) as footage:
        decoded = sum(1 for _ in footage.frames())
        promised = footage.info.frames_promised
        report = footage.report()
    assert decoded == promised == len(rows) == made.result.frames_decoded
    assert report.frames_missing == 0
    assert not any("could not be decoded" in warning for warning in report.warnings)


def test_the_annotated_clip_plays_in_browsers(made: Made) -> None:
    with open_footage(made.file("annotated.mp4")) as footage:
        info = footage.info
    assert coding_of(made.file("annotated.mp4")) == ("h264", "yuv420p")
    assert info.width_px % 2 == info.height_px % 2 == 0
    data = made.file("annotated.mp4").read_bytes()
    assert data.index(b"moov") < data.index(b"mdat"), "the index comes first: it starts at once"


@pytest.mark.parametrize("index", [5, 60, 120, 200])
def test_the_drawn_outline_lies_on_the_ball(
    annotated: list[np.ndarray], truth: Truth, index: int
) -> None:
    with open_footage(CLIP) as footage:
        plain = next(footage.frames(index)).luma.astype(float)
    height, width = plain.shape
    scale = annotated[index].shape[1] / width
    assert scale == 1.0, "the fixture is shown pixel by pixel"
    shown = annotated[index][HEADER_PX : HEADER_PX + height].astype(float)
    centre = (truth.ball_x_px[index], truth.ball_y_px[index])
    shift = drawn_shift(np.abs(shown - plain), centre, truth.diameter_px / 2)
    assert np.abs(shift).max() <= OUTLINE_WITHIN_PX


def test_the_drawn_face_lies_on_the_cylinder(made: Made, truth: Truth) -> None:
    rows = list(csv.DictReader(made.file("track.csv").read_text("utf-8").splitlines()))
    face = np.array([float(row["heavy_px"] or "nan") for row in rows])
    frame = np.array([int(row["frame"]) for row in rows])
    assert np.nanmax(np.abs(face - truth.face_x_px[frame])) <= OUTLINE_WITHIN_PX


def test_the_header_counts_up_to_the_result(made: Made, annotated: list[np.ndarray]) -> None:
    headers = [picture[:HEADER_PX, :160].astype(int) for picture in annotated]
    changes = [
        k
        for k in range(1, len(headers))
        if np.abs(headers[k][:, :80] - headers[k - 1][:, :80]).max() > 100
    ]
    assert len(changes) == made.result.count
    frames = [c.frame for c in made.result.collisions]
    # The count steps at the first frame whose exposure is not before the contact.
    assert np.abs(np.array(changes) - np.array(frames)).max() <= 0.5 + 1e-6


def test_large_footage_is_reduced_and_small_footage_enlarged() -> None:
    assert layout_of(3840, 2160).width_px == 1280
    assert layout_of(1080, 1920).footage_height_px == 1280
    assert layout_of(321, 121).width_px == 640
    assert layout_of(1280, 720).scale == 1.0
    for width, height in ((3840, 2160), (321, 121), (1281, 721), (100, 999)):
        layout = layout_of(width, height)
        assert [side % 2 for side in (layout.width_px, layout.footage_height_px)] == [0, 0]


def test_a_picture_point_keeps_its_place_when_footage_is_reduced() -> None:
    layout = layout_of(2560, 1440)
    # The corner between four pixels stays the corner between four pixels.
    assert layout.place((1.5, 3.5)) == (0.5, 1.5 + HEADER_PX)


def test_no_two_collisions_follow_each_other_faster_than_one_can_count() -> None:
    frame = np.arange(300.0)
    collisions = [50.0, 100.3, 110.2, 114.9, 118.0, 121.0, 200.0]
    shown = np.interp(collisions, frame, frame_times_s(frame, collisions, 30.0))
    assert np.diff(shown).min() >= 0.8 * BETWEEN_COLLISIONS_S


def test_a_clip_without_collisions_plays_at_its_own_rate() -> None:
    frame = np.arange(100.0)
    assert frame_times_s(frame, [], 25.0) == pytest.approx(frame / 25.0)
    assert frame_times_s(frame, [], 960.0) == pytest.approx(frame / 30.0)
    assert frame_times_s(frame, [], None) == pytest.approx(frame / 30.0)


def test_frame_times_only_go_up() -> None:
    rng = np.random.default_rng(7)
    for _ in range(20):
        frame = np.cumsum(rng.integers(1, 4, 120)).astype(float)
        collisions = np.sort(rng.uniform(frame[0], frame[-1], 30))
        assert np.diff(frame_times_s(frame, list(collisions), 30.0)).min() > 0


def test_long_stretches_without_a_collision_are_played_fast_in_their_middle() -> None:
    frame = np.arange(2000.0)
    collisions = [400.0, 420.0, 1900.0]
    lasts_s = np.diff(frame_times_s(frame, collisions, 30.0))
    assert lasts_s[1000] == pytest.approx(1 / FORWARD_FPS)
    for collision in collisions:
        near = np.abs(frame[:-1] - collision) < 30.0 * UNHURRIED_S
        assert lasts_s[near].min() >= 1 / 30.0 - 1e-12
    assert frame_times_s(frame, collisions, 30.0)[-1] < 0.35 * 2000 / 30.0

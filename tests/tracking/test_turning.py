"""A camera that rolls and zooms: its turns are measured, and taken back before bodies are found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drawn import Luma, paint_disc, scene, to_luma
from scipy import ndimage

import count_video
from count_video.records import CameraTurns
from count_video.tracking.background import agree_better
from count_video.tracking.corners import Trajectories
from count_video.tracking.turning import Turns, camera_turns, turned_back
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

FIXTURES = Path(__file__).parents[2] / "fixtures"
SHAPE = (240, 480)
SAMPLES = 40
CORNER_SIGMA_PX = 0.1
EDGE_PX = 0.3
"""Some thirty corners, found to 0.1 px and half as far from the middle as the edge in the mean,
give the turn to 0.04 px at the edge, and half of them, as the median of squares has it, to 0.06:
five standard deviations."""
LEVELS_RMS = 1.5
"""Two interpolations of a picture whose slopes are some levels a px, and rounding to whole ones."""
ROLL_DEG, ZOOM = 1.0, 0.01
TRIAL, TRIAL_COUNT, TRIAL_DIAMETER_PX = FIXTURES / "cluttered-1to16.mp4", 12, 62.3


def swaying(count: int, roll_deg: float = ROLL_DEG, zoom: float = ZOOM) -> Turns:
    """Turns of a hand that sways twice while its lens is focused once."""
    time = np.linspace(0.0, 2 * np.pi, count)
    return (1 + zoom * np.sin(time + 1.0)) * np.exp(1j * np.radians(roll_deg) * np.sin(2 * time))


def corners_seen(turns: Turns, bodies: int = 0, jitter_px: float = CORNER_SIGMA_PX) -> Trajectories:
    """Corners of a scenery that turns about the middle of the picture, and of bodies that move."""
    rng = np.random.default_rng(5)
    x, y = rng.uniform(0, SHAPE[1], 36) - SHAPE[1] / 2, rng.uniform(0, SHAPE[0], 36) - SHAPE[0] / 2
    place = (x + 1j * y)[:, None] * turns + (3.0 * np.sin(np.arange(len(turns)) / 5.0))
    place[:bodies] += 60.0 * np.sin(np.arange(len(turns)) / 9.0)
    both = np.stack([place.real + SHAPE[1] / 2, place.imag + SHAPE[0] / 2], axis=2)
    both += rng.normal(0.0, jitter_px, both.shape)
    return Trajectories(both.astype(np.float32), np.ones(len(both), np.bool_))


def relative(turns: Turns) -> Turns:
    """Turns from the usual one on."""
    return turns / complex(np.median(turns.real), np.median(turns.imag))


@pytest.mark.parametrize("bodies", [0, 12])
def test_roll_and_zoom_are_those_of_the_scenery(bodies: int) -> None:
    turns = swaying(SAMPLES)
    found = camera_turns(corners_seen(turns, bodies), SHAPE)
    assert found is not None
    apart_px = np.abs(found - relative(turns)) * np.hypot(*SHAPE) / 2
    assert apart_px.max() < EDGE_PX


def test_a_camera_that_is_only_shifted_turns_nothing() -> None:
    assert camera_turns(corners_seen(swaying(SAMPLES, 0.0, 0.0), 12), SHAPE) is None


def test_corners_that_keep_no_places_turn_nothing() -> None:
    assert camera_turns(corners_seen(swaying(SAMPLES), jitter_px=4.0), SHAPE) is None


def test_too_few_corners_turn_nothing() -> None:
    seen = corners_seen(swaying(SAMPLES))
    assert camera_turns(Trajectories(seen.places_px[:3], seen.anywhere[:3]), SHAPE) is None


def test_a_turn_between_samples_lies_between_theirs() -> None:
    samples = np.array([0, 10, 30])
    each = np.interp(np.arange(40), samples, np.array([1.0, 1.1 + 0.1j, 1.0 + 0j]))
    assert each[[0, 5, 10, 30, 39]] == pytest.approx([1, 1.05 + 0.05j, 1.1 + 0.1j, 1, 1])


def turned(luma: Luma, turn: complex) -> Luma:
    """Show a picture as a camera does that turned and zoomed about its middle."""
    middle = (np.array(luma.shape) - 1) / 2
    back = 1 / turn
    # By rows and columns: y' = im x + re y, x' = re x - im y.
    matrix = np.array([[back.real, back.imag], [-back.imag, back.real]])
    offset = middle - matrix @ middle
    shown = ndimage.affine_transform(
        luma.astype(np.float64), matrix, offset, order=3, mode="nearest"
    )
    return to_luma(shown)


def test_a_picture_turned_back_is_the_one_that_was_turned() -> None:
    luma = to_luma(ndimage.gaussian_filter(np.asarray(scene().frames()[0], np.float64), 1.0))
    turn = complex(1.01 * np.exp(0.02j))
    back = turned_back(turned(luma, turn), turn)
    inside = np.s_[8:-8, 8:-8]
    apart = back[inside].astype(float) - luma[inside]
    assert float(np.sqrt(np.mean(apart**2))) < LEVELS_RMS


def test_a_place_that_was_followed_is_shown_where_the_picture_has_it() -> None:
    turn, place = complex(1.02 * np.exp(0.03j)), (130.0, 70.0)
    canvas = np.full(SHAPE, 100.0)
    paint_disc(canvas, *place, 8.0, 220.0)
    shown = turned(to_luma(canvas), turn).astype(float) - 100.0
    middle = (SHAPE[1] - 1) / 2, (SHAPE[0] - 1) / 2
    y, x = ndimage.center_of_mass(np.clip(shown, 0.0, None))
    assert CameraTurns(np.array([[turn.real, turn.imag]]), middle).of(0, place) == pytest.approx(
        (x, y), abs=0.1
    )


@pytest.mark.parametrize("rolls", [True, False])
def test_pictures_are_turned_back_only_if_they_agree_better_then(rolls: bool) -> None:
    """Two bodies that near each other look as a zoom does, but for the rest of the picture."""
    frames = scene().frames()[::12]
    turns = swaying(len(frames), roll_deg=0.5).tolist()
    still = np.zeros((len(frames), 2))
    if rolls:
        frames = [turned(luma, turn) for luma, turn in zip(frames, turns, strict=True)]
    back = [turned_back(luma, turn) for luma, turn in zip(frames, turns, strict=True)]
    assert agree_better(frames, still, back, still) is rolls


def test_a_trial_is_counted_while_the_camera_rolls_and_zooms(tmp_path: Path) -> None:
    with open_footage(TRIAL) as footage:
        pictures = [frame.luma.copy() for frame in footage.frames()]
    turns = swaying(len(pictures), roll_deg=0.3, zoom=0.004)
    filmed = (turned_back(*one) for one in zip(pictures, (1 / turns).tolist(), strict=True))
    path = tmp_path / "trial.mp4"
    write_clip(path, filmed, WriteOptions(crf=18, preset="superfast"))
    result = count_video.count(path).to_dict()
    assert result["count"] == result["seen"] == TRIAL_COUNT
    assert result["ball_diameter_px"] == pytest.approx(TRIAL_DIAMETER_PX, abs=2.0)

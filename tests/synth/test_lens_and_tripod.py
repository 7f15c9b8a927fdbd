"""Perspective, distortion and a camera that moves: the pictures agree with the truth."""

from __future__ import annotations

import numpy as np
import pytest
from filming import BARE, NOISELESS, filmed, filmed_times, small_scene

from count_video.records import Floats
from synth_video.projection import Lens, projection_of, tripod_shift
from synth_video.scene import Scene, TripodSettings
from synth_video.schedule import Schedule
from synth_video.truth import Truth, truth_of

PLAIN = (
    *BARE,
    *NOISELESS,
    "background.kind=plaster",
    "background.texture=0",
    "threads.opacity=0",
    "wall.opacity=0",
    "wall.edge=0",
    "ball.color=[250, 250, 250]",
    "ball.shading=0",
    "ball.gloss=0",
    "ball.ring=false",
    'ball.mark=""',
    "cylinder.color=[20, 20, 20]",
    "view.width_m=0.6",
    "view.wall_m=0.15",
    "clip.start=release",
    "clip.frames=16",
)
"""A white disc before even grey, the cylinder far from it."""
ROUNDED_PX = 0.02
"""Values are rounded to whole grey levels, of some hundred between disc and background."""
BENT_PX = 0.05
"""The disc's image is bent besides, and OpenCV bends in steps of 1/32 px."""
GRID = np.meshgrid(np.linspace(-240, 240, 25), np.linspace(-100, 100, 11))
SCHEDULE = Schedule(np.arange(2000) / 2000.0, 1 / 4000.0)


def lens(turn_deg: float = 0.0, distortion: float = 0.0) -> Lens:
    return Lens(turn_deg, 800.0, distortion, 260.0)


@pytest.mark.parametrize("turn_deg", [-5.0, 0.0, 5.0])
@pytest.mark.parametrize("distortion", [-0.1, 0.0, 0.1])
def test_what_the_lens_does_can_be_undone(turn_deg: float, distortion: float) -> None:
    bent = lens(turn_deg, distortion)
    x, y = bent.flat(*bent.seen(*GRID))
    assert x == pytest.approx(GRID[0], abs=1e-6)
    assert y == pytest.approx(GRID[1], abs=1e-6)


def test_an_ideal_lens_changes_nothing() -> None:
    assert lens().ideal
    x, y = lens().seen(*GRID)
    assert np.array_equal(x, GRID[0])
    assert np.array_equal(y, GRID[1])


def test_perspective_keeps_lines_straight_and_shows_the_near_side_larger() -> None:
    along = np.linspace(-200, 200, 9)
    x, y = lens(turn_deg=5.0).seen(along, 30 + 0.1 * along)
    assert np.polyfit(x, y, 1, full=True)[1][0] == pytest.approx(0.0, abs=1e-18)
    steps = np.diff(x)
    assert np.all(np.diff(steps) < 0)


def test_a_barrel_draws_the_corner_in_by_its_share() -> None:
    x, y = lens(distortion=-0.08).seen(np.array([156.0]), np.array([208.0]))
    assert np.hypot(x, y) == pytest.approx([260 * 0.92])


def test_a_tripod_that_stands_still_moves_nothing() -> None:
    assert not tripod_shift(TripodSettings(), SCHEDULE, 1).any()


@pytest.mark.parametrize("seed", range(5))
def test_a_tremble_stays_within_its_size_and_its_band(seed: int) -> None:
    shift = tripod_shift(TripodSettings(shake_px=3.0), SCHEDULE, seed)
    assert np.abs(shift).max() <= 3.0
    power = np.abs(np.fft.rfft(shift * np.hanning(2000)[:, None], axis=0)) ** 2
    rate_hz = np.fft.rfftfreq(2000, 1 / 2000)
    band = (rate_hz >= 3) & (rate_hz <= 22)  # the window widens each line by two bins of 1 Hz
    assert power[band].sum() > 0.99 * power.sum()


@pytest.mark.parametrize("seed", range(5))
def test_a_knock_comes_once_and_swings_no_farther_than_its_size(seed: int) -> None:
    size = np.hypot(*tripod_shift(TripodSettings(knock_px=8.0), SCHEDULE, seed).T)
    assert size.max() == pytest.approx(8.0, rel=0.01)
    assert not size[: len(size) // 3].any()
    assert size[-1] < 1.0


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_shaken_picture_shows_the_ball_where_the_truth_has_it(side: str) -> None:
    scene = small_scene("paper", *PLAIN, "tripod.shake_px=3", f"wall.side={side}")
    truth, pictures = truth_and_pictures(scene)
    true = centres(truth)
    assert np.ptp(true[:, 0]) > 0.5
    seen = np.array([disc_centre(*pair) for pair in zip(pictures, true, strict=True)])
    assert seen == pytest.approx(true, abs=ROUNDED_PX)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(
    "setting", ["lens.turn_deg=5", "lens.turn_deg=-5", "lens.distortion=-0.08", "camera.tilt_deg=6"]
)
def test_a_bent_picture_shows_the_ball_where_the_truth_has_it(side: str, setting: str) -> None:
    scene = small_scene("paper", *PLAIN, setting, f"wall.side={side}", "tripod.shake_px=2")
    truth, pictures = truth_and_pictures(scene)
    true = centres(truth)
    seen = np.array([disc_centre(*pair) for pair in zip(pictures, true, strict=True)])
    assert seen == pytest.approx(true, abs=BENT_PX)


def test_collisions_have_their_place_in_the_picture() -> None:
    scene = small_scene("ratio16", "tripod.shake_px=3", "lens.turn_deg=3", "camera.tilt_deg=5")
    truth, _ = truth_and_pictures(scene, draw=False)
    # Between two frames the ball moves by less than a frame's travel from either.
    centre = centres(truth)[:, 0]
    travel = np.abs(np.diff(centre)).max()
    for event in truth.events:
        assert abs(event.ball_px - centre[round(event.frame)]) <= travel


def truth_and_pictures(scene: Scene, *, draw: bool = True) -> tuple[Truth, list[Floats]]:
    motion, schedule, pictures = filmed(scene, 3) if draw else (*filmed_times(scene, 3), [])
    truth = truth_of(scene, 3, motion, schedule, projection_of(scene))
    return truth, [picture[..., 0].astype(float) for picture in pictures]


def centres(truth: Truth) -> Floats:
    """True centre of the ball in each frame, shape (n, 2)."""
    return np.stack(
        [
            (truth.ball_near.x_px + truth.ball_far.x_px) / 2,
            (truth.ball_near.y_px + truth.ball_far.y_px) / 2,
        ],
        axis=-1,
    )


def disc_centre(picture: Floats, about: Floats) -> Floats:
    """Centre (x, y) of what is brighter than its surroundings near a point."""
    left, top = np.rint(about).astype(int) - 16
    part = picture[top : top + 33, left : left + 33]
    bright = np.clip(part - part[0, 0] - 10, 0, None)  # plaster is a few levels uneven
    rows, columns = np.indices(part.shape)
    return np.array(
        [left + (bright * columns).sum() / bright.sum(), top + (bright * rows).sum() / bright.sum()]
    )

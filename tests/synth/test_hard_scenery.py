"""Conditions that hide the bodies: what is behind them, how bright it is, how small they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filming import filmed_times, small_scene

from count_video.records import Floats
from synth_video.experiments.course import course_of_trial
from synth_video.film import Compositor, frames_of
from synth_video.paint_background import CONTRAST, HEIGHT_M, SHIFT_M, hang_boards
from synth_video.projection import projection_of
from synth_video.raster import raster_for
from synth_video.scene import Scene
from synth_video.schedule import exposures
from synth_video.stage import Stage, set_stage
from synth_video.suite.condition import STRENGTHS, Strength
from synth_video.suite.suites import conditions_of
from synth_video.truth import Truth, truth_of
from tiers import rest_slow

NUMBERS = range(3)
AS_BRIGHT = 5.0
"""Grey levels: the mottles behind a ball spread by up to 13, and some ten of them are behind it."""
DARK_LEVELS = 30

either_strength = pytest.mark.parametrize("strength", STRENGTHS)
each_number = pytest.mark.parametrize("number", rest_slow(NUMBERS))


def scene_and_seed(name: str, strength: Strength, number: int) -> tuple[Scene, int]:
    condition = conditions_of("all", [name])[0]
    return condition.scene(strength, number), condition.seed(number)


def grey(picture: Floats) -> Floats:
    """Brightness of an RGB picture, shape (h, w), as a file's luma weighs the colours."""
    return np.asarray(picture @ np.array([0.299, 0.587, 0.114]))


def staged(scene: Scene, seed: int) -> Stage:
    return set_stage(scene, projection_of(scene), np.random.default_rng(seed))


def first_light(scene: Scene, seed: int) -> tuple[Stage, Floats, tuple[float, float]]:
    """Stage and brightness of frame 0 before the sensor, and the ball's centre in it, in px."""
    motion, schedule = filmed_times(scene, seed)
    projection, stage = projection_of(scene), staged(scene, seed)
    path = next(exposures(course_of_trial(motion, rising=True), schedule, projection.px_per_m))
    x_px, y_px = projection.tilted(path.bodies[0].along_m, path.bodies[0].up_m)
    light = grey(Compositor(stage).compose(path).copy())
    return stage, light, (float(x_px.mean()), float(y_px.mean()))


def within(shape: tuple[int, int], centre: tuple[float, float], radius_px: float) -> Floats:
    """Distance of every pixel from a circle's outline, negative inside, shape (h, w)."""
    y, x = np.indices(shape)
    return np.asarray(np.hypot(x - centre[0], y - centre[1]) - radius_px)


def radius_of(scene: Scene) -> float:
    return scene.setup.ball_diameter_m / 2 * projection_of(scene).px_per_m


def drawn_truth(scene: Scene, seed: int) -> Truth:
    motion, schedule = filmed_times(scene, seed)
    return truth_of(scene, seed, motion, schedule, projection_of(scene))


@either_strength
@each_number
def test_a_camouflaged_ball_is_as_bright_as_what_is_behind_it(
    strength: Strength, number: int
) -> None:
    scene, seed = scene_and_seed("camouflage", strength, number)
    stage, light, centre = first_light(scene, seed)
    disc = within(light.shape, centre, radius_of(scene)) < -2
    behind = grey(stage.still)[disc]
    assert light[disc].mean() == pytest.approx(behind.mean(), abs=AS_BRIGHT)


@each_number
def test_a_camouflaged_balls_shading_shows_it_less_at_full_strength(number: int) -> None:
    spreads, mottles = [], []
    for strength in STRENGTHS:
        scene, seed = scene_and_seed("camouflage", strength, number)
        stage, light, centre = first_light(scene, seed)
        disc = within(light.shape, centre, radius_of(scene)) < -2
        spreads.append(light[disc].std())
        mottles.append(grey(stage.still)[disc].std())
    assert spreads[0] > spreads[1] > mottles[1] > mottles[0]


@either_strength
@each_number
def test_a_dark_picture_lies_within_thirty_grey_levels(strength: Strength, number: int) -> None:
    scene, seed = scene_and_seed("dark", strength, number)
    noiseless = replace(scene, camera=replace(scene.camera, read_noise=0.0, shot_noise=0.0))
    motion, schedule = filmed_times(noiseless, seed)
    pictures = frames_of(noiseless, seed, course_of_trial(motion, rising=True), schedule)
    luma = grey(next(pictures).astype(float))
    assert np.ptp(luma) <= DARK_LEVELS


def ring_ranges(scene: Scene, seed: int) -> Floats:
    """Range of the still picture's brightness along the ball's outline, at places 2 mm apart."""
    projection, still = projection_of(scene), grey(staged(scene, seed).still)
    reach_m = scene.setup.wall_gap_m + scene.setup.ball_diameter_m
    ranges = []
    for along_m in np.arange(scene.setup.ball_diameter_m / 2, reach_m, 0.002):
        x_px, y_px = projection.tilted(np.array(along_m), np.array(0.0))
        ring = np.abs(within(still.shape, (float(x_px), float(y_px)), radius_of(scene))) < 1
        ranges.append(np.ptp(still[ring]))
    return np.array(ranges)


@either_strength
@each_number
def test_edges_lie_across_the_outline_of_the_ball_wherever_it_is(
    strength: Strength, number: int
) -> None:
    scene, seed = scene_and_seed("behind", strength, number)
    plain = replace(scene, background=replace(scene.background, kind="plaster"))
    faintest = scene.background.texture * CONTRAST[0] * min(scene.background.color)
    assert ring_ranges(scene, seed).min() > ring_ranges(plain, seed).max() + faintest


def test_boards_hang_no_higher_and_no_lower_than_the_bodies_reach_and_leave_the_rest() -> None:
    scene = small_scene("suite", "background.kind=boards", "background.blur_m=0")
    raster = raster_for(projection_of(scene), np.random.default_rng(5))
    wall = raster.blank((120.0, 120.0, 120.0))
    hung = wall.copy()
    hang_boards(hung, 1.0, raster)
    changed = (hung != wall).any(axis=(1, 2))
    up_m = raster.up_m()[:, 0][changed]
    assert np.abs(up_m).max() <= SHIFT_M + max(HEIGHT_M) / 2 + 1 / raster.px_per_m
    assert np.ptp(up_m) > 2 * SHIFT_M
    assert hung.min() < (1 - CONTRAST[0]) * 120 < (1 + CONTRAST[0]) * 120 < hung.max()
    hang_boards(wall, 0.0, raster)
    assert np.array_equal(wall, raster.blank((120.0, 120.0, 120.0)))


@either_strength
@each_number
def test_the_bodies_of_a_wide_picture_are_small(strength: Strength, number: int) -> None:
    scene, seed = scene_and_seed("wide", strength, number)
    assert scene.camera.width_px == 1280
    assert drawn_truth(scene, seed).ball_diameter_px <= {"ordinary": 47, "full": 31}[strength]


@either_strength
@each_number
def test_the_cylinder_already_swings_in_the_first_frame_and_the_ball_hangs_still(
    strength: Strength, number: int
) -> None:
    scene, seed = scene_and_seed("first_frame", strength, number)
    truth = drawn_truth(scene, seed)
    first = truth.events[0].frame
    assert scene.clip.lead_frames - 1 <= first <= scene.clip.lead_frames
    still = np.diff(truth.ball_far.along_m[: int(first) + 1])
    swung = np.diff(truth.cylinder.along_m[: int(first) + 1])
    assert np.array_equal(still, np.zeros_like(still))
    assert (swung < 0).all()

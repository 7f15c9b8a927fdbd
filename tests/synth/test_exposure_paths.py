from __future__ import annotations

import numpy as np
import pytest
from filming import small_scene

from count_video.physics.simulator import simulate
from synth_video.experiments.course import course_of_trial, rise_m
from synth_video.projection import projection_of
from synth_video.schedule import exposures, schedule_of
from synth_video.stage import BALL, HEAVY

MEAN_PX = 0.004
"""Greatest error of the mean of a sampled path with a bounce in it; see exposure.py."""


def test_the_mean_of_each_sampled_path_is_the_mean_of_the_true_path() -> None:
    scene = small_scene("gap3-31", "camera.width_px=1280", "camera.shutter=1.0", "clip.frames=400")
    motion = simulate(scene.setup, seed=0)
    schedule = schedule_of(scene, motion, np.random.default_rng(3))
    scale = projection_of(scene).px_per_m
    sampled = [
        p.bodies[BALL].along_m.mean()
        for p in exposures(course_of_trial(motion, rising=False), schedule, scale)
    ]
    part = ((np.arange(2000) + 0.5) / 2000 - 0.5) * schedule.exposure_s
    fine = motion.sample((schedule.centre_s[:, None] + part).ravel()).ball_far_face_m
    true = fine.reshape(-1, 2000).mean(axis=1) + scene.setup.ball_diameter_m / 2
    assert np.array(sampled) * scale == pytest.approx(true * scale, abs=MEAN_PX)


def test_a_shutter_hardly_open_shows_the_place_at_the_centre_of_the_exposure() -> None:
    scene = small_scene("ratio16", "camera.shutter=0.001")
    motion = simulate(scene.setup, seed=0)
    schedule = schedule_of(scene, motion, np.random.default_rng(3))
    scale = projection_of(scene).px_per_m
    seen = [
        p.bodies[HEAVY].along_m.mean()
        for p in exposures(course_of_trial(motion, rising=False), schedule, scale)
    ]
    true = motion.sample(schedule.centre_s).heavy_face_m
    assert np.array(seen) * scale == pytest.approx(true * scale, abs=1e-3)


def test_a_hanging_body_rises_on_the_circle_of_its_thread() -> None:
    scene = small_scene()
    aside_m = np.linspace(-0.09, 0.09, 7)
    rise = rise_m(scene.setup, aside_m, 0.8)
    assert (0.8 - rise) ** 2 + aside_m**2 == pytest.approx(np.full(7, 0.64))


def test_the_clip_starts_the_stated_number_of_frames_before_the_first_collision() -> None:
    scene = small_scene("ratio16", "clip.lead_frames=30", "clip.tail_frames=20")
    motion = simulate(scene.setup, seed=0)
    schedule = schedule_of(scene, motion, np.random.default_rng(5))
    first = schedule.frame_coordinate(motion.burst[0].time_s)
    last = schedule.frame_coordinate(motion.burst[-1].time_s)
    assert 29 <= first <= 30
    assert 20 <= len(schedule.centre_s) - 1 - last < 21


def test_a_clip_from_the_release_shows_the_cylinder_held_still_at_first() -> None:
    scene = small_scene("ratio16", "clip.start=release", "clip.lead_frames=5", "clip.frames=8")
    motion = simulate(scene.setup, seed=0)
    schedule = schedule_of(scene, motion, np.random.default_rng(5))
    heavy_m = motion.sample(schedule.centre_s).heavy_face_m
    assert np.ptp(heavy_m[:5]) == 0
    assert np.all(np.diff(heavy_m[5:]) < 0)


def test_a_clip_to_the_turn_reaches_the_turn() -> None:
    scene = small_scene("ratio16", "clip.end=turn", "clip.tail_frames=3")
    motion = simulate(scene.setup, seed=0)
    schedule = schedule_of(scene, motion, np.random.default_rng(5))
    turn = schedule.frame_coordinate(motion.burst_end_s)
    assert 3 <= len(schedule.centre_s) - 1 - turn < 4

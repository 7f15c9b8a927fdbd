from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filming import small_scene

from count_video.errors import UsageError
from count_video.physics.simulator import simulate
from synth_video import variation
from synth_video.projection import projection_of
from synth_video.schedule import schedule_of
from synth_video.truth import Truth, truth_of
from synth_video.variation import FEWEST_COLLISIONS, MOST_COLLISIONS, varied

SEEDS = range(12)


def truth_of_varied(seed: int) -> Truth:
    scene = varied(small_scene("shelf"), seed)
    motion = simulate(scene.setup, seed=seed)
    schedule = schedule_of(scene, motion, np.random.default_rng(seed))
    return truth_of(scene, seed, motion, schedule, projection_of(scene))


def test_every_varied_trial_is_resolved_and_has_a_count_within_the_range() -> None:
    truths = [truth_of_varied(seed) for seed in SEEDS]
    assert all(truth.resolved for truth in truths)
    assert all(FEWEST_COLLISIONS <= truth.count <= MOST_COLLISIONS for truth in truths)


def test_varied_trials_differ_in_count_in_side_and_in_loss() -> None:
    scenes = [varied(small_scene(), seed) for seed in SEEDS]
    assert len({simulate(s.setup, seed=0).count for s in scenes}) > len(scenes) // 2
    assert {s.wall.side for s in scenes} == {"left", "right"}
    assert {s.setup.restitution_wall == 1 for s in scenes} == {True, False}


def test_the_same_seed_draws_the_same_trial() -> None:
    assert varied(small_scene(), 3) == varied(small_scene(), 3)


def test_all_but_the_trial_stays_as_the_scene_has_it() -> None:
    scene = small_scene("black-cloth")
    drawn = varied(scene, 1)
    back = replace(drawn, setup=scene.setup, camera=scene.camera, wall=scene.wall)
    assert back == scene


def test_a_scene_that_allows_no_trial_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(variation, "_TRIES", 20)
    # Damped so heavily, the cylinder creeps to its rest and never strikes the ball in time.
    scene = small_scene("paper", "setup.restitution_wall=0.9", "setup.heavy_damping_per_s=3.1")
    impossible = replace(scene, setup=replace(scene.setup, light_damping_per_s=3.1))
    with pytest.raises(UsageError, match="no trial found"):
        varied(impossible, 0)

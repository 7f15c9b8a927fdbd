from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from filming import small_scene

from count_video.errors import UsageError
from count_video.physics.simulator import Motion, simulate
from synth_video.projection import projection_of
from synth_video.scene import Scene
from synth_video.scene_file import load_scene, scene_names
from synth_video.schedule import schedule_of
from synth_video.truth import Truth, truth_of, truth_path, write_text

ROUNDED_PX = 1e-5
ROUNDED_M = 1e-9
TRIALS = [name for name in scene_names() if load_scene(name).experiment.kind == "pi"]


def truth_for(scene: Scene, seed: int = 0) -> tuple[Truth, Motion]:
    motion = simulate(scene.setup, seed=seed)
    schedule = schedule_of(scene, motion, np.random.default_rng(seed))
    return truth_of(scene, seed, motion, schedule, projection_of(scene)), motion


@pytest.mark.parametrize("name", TRIALS)
def test_the_truth_has_the_collisions_of_the_simulator_at_its_times(name: str) -> None:
    scene = small_scene(name)
    truth, motion = truth_for(scene)
    assert truth.count == motion.count
    assert [e.kind for e in truth.events] == [c.kind for c in motion.burst]
    times_s = np.array([c.time_s for c in motion.burst])
    frames = np.array([e.frame for e in truth.events])
    elapsed = (times_s - times_s[0]) * scene.camera.capture_fps
    assert frames - frames[0] == pytest.approx(elapsed, abs=1e-6)


@pytest.mark.parametrize("name", TRIALS)
def test_kinds_alternate_and_every_scene_is_resolved(name: str) -> None:
    truth, _ = truth_for(small_scene(name))
    assert all(a.kind != b.kind for a, b in pairwise(truth.events))
    assert truth.resolved


@pytest.mark.parametrize(("name", "count"), [("gap3-31", 31), ("gap5-29", 29), ("paper", 27)])
def test_the_gap_alone_decides_between_the_counts_of_equal_pendulums(name: str, count: int) -> None:
    assert truth_for(small_scene(name))[0].count == count


@pytest.mark.parametrize("tilt_deg", [0, 7])
@pytest.mark.parametrize("side", ["left", "right"])
def test_faces_are_where_the_simulator_has_them(side: str, tilt_deg: int) -> None:
    scene = small_scene("ratio16", f"wall.side={side}", f"camera.tilt_deg={tilt_deg}")
    truth, motion = truth_for(scene)
    scale, sign = truth.px_per_m, 1 if side == "left" else -1
    from_wall_px = np.hypot(
        truth.cylinder.x_px - truth.wall.x_px, truth.cylinder.y_px - truth.wall.y_px
    )
    rise = 1.0 - np.sqrt(1 - (truth.cylinder.along_m - motion.setup.heavy_rest_m) ** 2)
    assert from_wall_px == pytest.approx(scale * np.hypot(truth.cylinder.along_m, rise))
    along_x = sign * (truth.ball_near.x_px - truth.ball_far.x_px)
    cosine = np.cos(np.radians(tilt_deg))
    assert along_x == pytest.approx(truth.ball_diameter_px * cosine)
    slope = (truth.ball_near.y_px - truth.ball_far.y_px) / (
        truth.ball_near.x_px - truth.ball_far.x_px
    )
    assert slope == pytest.approx(np.tan(np.radians(tilt_deg)))


def test_bodies_touch_in_the_picture_at_every_collision() -> None:
    truth, _ = truth_for(small_scene("ratio16", "view.rising_path=false"))
    frame = np.arange(len(truth.wall.x_px))
    speed_px = np.abs(np.diff(truth.ball_near.x_px)).max()
    for event in truth.events:
        pair = (
            (truth.ball_near, truth.cylinder)
            if event.kind == "bodies"
            else (truth.ball_far, truth.wall)
        )
        left, right = (np.interp(event.frame, frame, face.x_px) for face in pair)
        # Between two frames the interpolated path cuts the corner by at most a frame's travel.
        assert abs(left - right) <= speed_px


def test_mirroring_the_scene_mirrors_the_truth() -> None:
    left, _ = truth_for(small_scene("ratio16", "camera.tilt_deg=4"))
    right, _ = truth_for(small_scene("ratio16", "camera.tilt_deg=-4", "wall.side=right"))
    width = left.scene.camera.width_px
    for one, other in zip(left.events, right.events, strict=True):
        assert (one.frame, one.kind) == (other.frame, other.kind)
        assert other.ball_px == pytest.approx(width - 1 - one.ball_px)
    for name in ("ball_near", "ball_far", "cylinder", "wall"):
        here, there = getattr(left, name), getattr(right, name)
        assert there.x_px == pytest.approx(width - 1 - here.x_px)
        assert there.y_px == pytest.approx(here.y_px)
        assert np.array_equal(there.along_m, here.along_m)


def test_collisions_after_the_turn_are_kept_apart() -> None:
    scene = small_scene(
        "equal-masses", "clip.end=all", "setup.wall_gap_m=0.01", "camera.capture_fps=120"
    )
    truth, motion = truth_for(scene)
    after = motion.collisions[motion.count :]
    assert after
    assert len(truth.events_after_burst) == len(after)
    assert truth.events_after_burst[0].frame > truth.events[-1].frame


def test_the_file_says_all_that_a_reader_needs() -> None:
    truth, _ = truth_for(small_scene("ratio16", "encoding.container_fps=25"), seed=4)
    found = json.loads(truth.text())
    assert found["seed"] == 4
    assert found["scene"]["name"] == "ratio16"
    assert found["scene"]["setup"]["wall_gap_m"] == truth.scene.setup.wall_gap_m
    assert (found["capture_fps"], found["container_fps"]) == (960.0, 25.0)
    assert found["count"] == len(found["events"])
    assert found["count_after_burst"] == len(found["events_after_burst"])
    assert found["mass_ratio"] == pytest.approx(16)
    assert found["ball_diameter_px"] == pytest.approx(0.040 * found["px_per_m"])
    assert found["wall_side"] == "left"
    assert found["resolved"] is True
    assert found["shortest_interval_frames"] == pytest.approx(
        min(b["frame"] - a["frame"] for a, b in pairwise(found["events"])), abs=2e-6
    )
    assert [row["frame"] for row in found["frames"]] == list(range(len(truth.wall.x_px)))
    row = found["frames"][7]
    assert row["cylinder_px"] == pytest.approx(truth.cylinder.x_px[7], abs=ROUNDED_PX)
    assert row["cylinder_point_px"] == [row["cylinder_px"], pytest.approx(truth.cylinder.y_px[7])]
    assert row["ball_near_m"] == pytest.approx(truth.ball_near.along_m[7], abs=ROUNDED_M)
    assert row["ball_near_m"] - row["ball_far_m"] == pytest.approx(0.040)
    assert row["wall_m"] == 0


def test_the_truth_is_called_after_its_clip() -> None:
    assert truth_path(Path("a/trial.mp4")) == Path("a/trial.truth.json")


def test_a_truth_that_cannot_be_written_leaves_nothing_behind(tmp_path: Path) -> None:
    truth, _ = truth_for(small_scene("equal-masses"))
    target = tmp_path / "t.truth.json"
    target.mkdir()
    with pytest.raises(UsageError, match="cannot write"):
        write_text(truth.text(), target)
    assert list(tmp_path.iterdir()) == [target]


def test_a_trial_without_collision_is_refused() -> None:
    scene = small_scene("paper", "setup.release_m=0")
    with pytest.raises(UsageError, match="never collide"):
        truth_for(scene)


def test_a_clip_that_would_be_endless_is_refused() -> None:
    with pytest.raises(UsageError, match="max_frames"):
        truth_for(small_scene("gap3-31", "camera.capture_fps=1000000"))

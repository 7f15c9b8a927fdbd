from __future__ import annotations

import numpy as np
import pytest
from filming import NOISELESS, filmed, small_scene

from count_video.physics.simulator import Motion, simulate
from count_video.records import Floats
from synth_video.projection import projection_of
from synth_video.scene import Scene
from synth_video.schedule import schedule_of
from synth_video.suite.condition import Condition
from synth_video.suite.scene_conditions import BODIES, THINGS
from synth_video.truth import Truth, truth_of
from synth_video.variation import varied

SHORT = ("clip.frames=3", "clip.lead_frames=1", "camera.vignette=0", *NOISELESS)
CHANGED = 2.0
"""Grey levels: a rounding of both pictures makes no more than one."""
SOFT_M = 0.004
"""Lens blur and defocus reach no farther than this beyond an outline, in the pictures used here."""


def pictures(*overrides: str) -> list[Floats]:
    """Brightness of a short clip's frames, shape (h, w) each."""
    _, _, frames = filmed(small_scene("ratio16", *SHORT, *overrides))
    return [frame.astype(float).mean(axis=2) for frame in frames]


def changed_place(*overrides: str, base: tuple[str, ...] = ()) -> tuple[Floats, Floats]:
    """Distance from the wall and height of every pixel that the things change, in frame 0."""
    plain, other = pictures(*base)[0], pictures(*base, *overrides)[0]
    y, x = np.nonzero(np.abs(plain - other) > CHANGED)
    assert len(x) > 0
    projection = projection_of(small_scene("ratio16", *SHORT, *base, *overrides))
    along_m = (x - projection.wall_x_px) / projection.px_per_m
    return along_m, (projection.line_y_px - y) / projection.px_per_m


def test_a_lying_ball_is_seen_where_it_lies_and_stays() -> None:
    ball = ("things.lying_ball=true", "things.lying_along_m=0.18", "things.lying_up_m=-0.05")
    away = ("cylinder.length_m=0.02", "light.shadow=0")
    along_m, up_m = changed_place(*ball, base=away)
    radius_m = 0.020 * 1.15  # its ring stands out
    assert np.hypot(along_m - 0.18, up_m + 0.05).max() <= radius_m + SOFT_M
    pairs = zip(pictures(*away), pictures(*away, *ball), strict=True)
    first, *_, last = [np.abs(plain - other) for plain, other in pairs]
    assert (first > CHANGED).sum() > 100
    assert np.array_equal(first, last)


@pytest.mark.parametrize(("side", "edge_m", "inward"), [("far", 0.206, -1), ("near", -0.054, 1)])
def test_a_person_stays_within_reach_of_the_edge_and_sways(
    side: str, edge_m: float, inward: int
) -> None:
    someone = ("things.person=0.25", f"things.person_side={side}", "things.person_m_s=2")
    along_m, _ = changed_place(*someone)
    depth_m = inward * (along_m - edge_m)
    assert depth_m.max() <= 0.25 * 0.26 + SOFT_M
    swayed = [np.abs(a - b) for a, b in zip(pictures(), pictures(*someone), strict=True)]
    assert np.abs(swayed[0] - swayed[-1]).max() > 10


def test_a_person_stands_behind_the_bodies() -> None:
    paths = ("things.person=0.6", "things.person_m_s=0.01", "light.shadow=0", "threads.opacity=0")
    plain, other = pictures(*paths[2:])[0], pictures(*paths)[0]
    scene = small_scene("ratio16", *SHORT)
    motion = simulate(scene.setup, seed=0)
    schedule = schedule_of(scene, motion, np.random.default_rng(0))
    along_m = float(motion.sample(schedule.centre_s[:1]).heavy_face_m[0]) + 0.02
    x, y = projection_of(scene).tilted(np.array(along_m), np.array(0.0))
    assert plain[round(float(y)), round(float(x))] == other[round(float(y)), round(float(x))]


def test_a_hand_covers_the_far_part_of_the_cylinder_until_it_lets_go() -> None:
    held = ("clip.start=release", "clip.lead_frames=1")
    scene = small_scene("ratio16", *SHORT)
    face_m = scene.setup.heavy_rest_m + scene.setup.release_m
    length_m = scene.cylinder.length_m
    along_m, up_m = changed_place("things.hand_s=0.3", base=held)
    assert along_m.min() > face_m + 0.1 * length_m
    on_axis = np.abs(up_m) < 0.01
    assert along_m[on_axis].min() < face_m + length_m


def test_a_hand_is_gone_long_after_it_let_go() -> None:
    late = ("setup.release_m=0.05",)
    plain, other = pictures(*late), pictures(*late, "things.hand_s=0.05")
    assert all(np.array_equal(a, b) for a, b in zip(plain, other, strict=True))


def test_cords_cross_the_picture_and_stay() -> None:
    plain, other = pictures(), pictures("things.cords=2")
    cords = [np.abs(a - b) > 8 for a, b in zip(plain, other, strict=True)]
    rows = cords[0].any(axis=1)
    assert rows[: len(rows) // 2].mean() > 0.9
    # Before what moves a cord's contrast may change; elsewhere it stays as it is.
    assert (cords[0] == cords[-1]).mean() > 0.99


def test_a_clamp_hides_all_that_is_behind_it() -> None:
    clamp = ("wall.clamp_m=0.012", "wall.clamp_up_m=0.002", "setup.wall_gap_m=0.0")
    along_m, up_m = changed_place(*clamp[:2], base=clamp[2:])
    assert along_m.max() <= 0.012 + SOFT_M
    assert up_m.max() <= 0.002 + SOFT_M
    orange, white = (
        pictures(*clamp, f"ball.color=[{color}]")[0] for color in ("226, 103, 28", "228, 228, 224")
    )
    projection = projection_of(small_scene("ratio16", *SHORT))
    x, y = projection.tilted(np.array(0.008), np.array(-0.004))
    assert orange[round(float(y)), round(float(x))] == white[round(float(y)), round(float(x))]


def test_a_mirror_shows_the_ball_as_far_behind_the_wall_as_it_is_before_it() -> None:
    near = ("setup.wall_gap_m=0.01",)
    mirror = ("wall.reflection=0.8", "wall.mirror_m=0.05")
    along_m, up_m = changed_place(*mirror, base=(*near, "wall.reflection=0"))
    assert along_m.mean() == pytest.approx(-0.030, abs=SOFT_M)
    assert up_m.mean() == pytest.approx(0.0, abs=SOFT_M)


def test_a_rim_hides_the_part_of_the_ball_that_touches_the_face() -> None:
    touching = ("clip.lead_frames=0", "clip.frames=1", "light.shadow=0")
    along_m, _ = changed_place("cylinder.rim_m=0.006", base=touching)
    scene = small_scene("ratio16", *SHORT)
    face_m = scene.setup.heavy_rest_m
    assert along_m.min() == pytest.approx(face_m - 0.006, abs=SOFT_M)
    assert along_m.max() <= face_m + SOFT_M


def drawn_truth(scene: Scene, seed: int) -> tuple[Truth, Motion]:
    motion = simulate(scene.setup, seed=seed)
    schedule = schedule_of(scene, motion, np.random.default_rng(seed))
    return truth_of(scene, seed, motion, schedule, projection_of(scene)), motion


@pytest.mark.parametrize("seed", range(4))
def test_a_cylinder_that_comes_in_is_outside_at_the_start(seed: int) -> None:
    scene = varied(small_scene("suite", "view.beyond_m=0.02"), seed)
    truth, _ = drawn_truth(scene, seed)
    width = scene.camera.width_px
    start_px = truth.cylinder.x_px[0]
    assert start_px < -0.5 if scene.wall.side == "right" else start_px > width - 0.5
    assert truth.countable


@pytest.mark.parametrize("condition", [*THINGS, *BODIES], ids=lambda condition: condition.name)
def test_every_collision_of_a_condition_happens_within_the_picture(condition: Condition) -> None:
    for number in range(3):
        scene, seed = condition.scene("full", number), condition.seed(number)
        _, motion = drawn_truth(scene, seed)
        hits_s = np.array([bounce.time_s for bounce in motion.burst])
        contact_m = motion.sample(hits_s).ball_near_face_m
        x_px, _ = projection_of(scene).image(contact_m, np.zeros_like(contact_m))
        assert ((x_px > 0) & (x_px < scene.camera.width_px - 1)).all()

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from count_video.errors import UsageError
from count_video.records import Floats
from synth_video.experiments.course import Course
from synth_video.experiments.happening import course_of, schedule_of_course
from synth_video.film import frames_of, render_clip
from synth_video.projection import projection_of
from synth_video.scene import NOTHING_TO_COUNT, Scene
from synth_video.scene_file import load_scene, scene_names
from synth_video.schedule import Schedule, exposures
from synth_video.suite.condition import STRENGTHS, Condition, Strength
from synth_video.suite.scene_conditions import EXPERIMENTS as EXPERIMENTS_OF_SUITE
from synth_video.truth import ExperimentTruth, truth_of_course, truth_path
from synth_video.variation import varied

EXPERIMENTS = [name for name in scene_names() if load_scene(name).experiment.kind != "pi"]
TOUCH_M = 1e-9
"""Rounding of a place and of a time of contact at speeds of metres per second."""


def run_of(scene: Scene) -> tuple[Course, Schedule, ExperimentTruth]:
    course = course_of(scene)
    schedule = schedule_of_course(scene, course, np.random.default_rng(0))
    return course, schedule, truth_of_course(scene, 0, course, schedule, projection_of(scene))


def gap_to_stop_m(scene: Scene, course: Course, times_s: Floats) -> Floats:
    """Least distance of the body, or of the two bodies, from what they can touch."""
    size_m, kind = scene.setup.ball_diameter_m, scene.experiment.kind
    along_m, up_m = course.places[0](times_s)
    if kind == "bounce":
        return up_m - size_m / 2
    if len(course.places) == 2:
        other_along_m, other_up_m = course.places[1](times_s)
        return np.hypot(other_along_m - along_m, other_up_m - up_m) - size_m
    left_m = along_m - size_m / 2
    span_m = scene.experiment.span_m
    return np.minimum(left_m, span_m - size_m - left_m) if span_m else left_m


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_what_has_something_to_count_shows_it_and_the_rest_shows_nothing(name: str) -> None:
    scene = load_scene(name)
    _, _, truth = run_of(scene)
    assert truth.resolved
    assert (truth.count == 0) == (scene.experiment.kind in NOTHING_TO_COUNT)
    assert (json.loads(truth.text())["expect"] == "counted") == (truth.count > 0)


@pytest.mark.parametrize("name", [n for n in EXPERIMENTS if "pendulum" not in n])
def test_bodies_touch_at_each_contact_and_only_there(name: str) -> None:
    scene = load_scene(name)
    course, schedule, _ = run_of(scene)
    if scene.experiment.kind in ("swing", "throw", "cradle"):
        assert course.contacts == ()
        return
    contacts_s = np.array([c.time_s for c in course.contacts])
    assert gap_to_stop_m(scene, course, contacts_s) == pytest.approx(0, abs=TOUCH_M)
    # Anything else than a contact leaves a gap; near one it may be as small as it likes.
    far = np.array([np.abs(contacts_s - t).min(initial=1.0) > 0.01 for t in schedule.centre_s])
    assert (gap_to_stop_m(scene, course, schedule.centre_s[far]) > 0).all()


@pytest.mark.parametrize("name", ["pendulum-wall", "pendulums"])
def test_hanging_bodies_touch_along_the_line_at_each_contact(name: str) -> None:
    scene = load_scene(name)
    course, _, _ = run_of(scene)
    times_s = np.array([c.time_s for c in course.contacts])
    along_m = [place(times_s)[0] for place in course.places]
    gap_m = along_m[-1] - (along_m[0] if len(along_m) == 2 else 0)
    reach_m = scene.setup.ball_diameter_m / (1 if len(along_m) == 2 else 2)
    assert gap_m == pytest.approx(np.full(len(times_s), reach_m), abs=TOUCH_M)


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_bodies_go_on_without_jumps(name: str) -> None:
    scene = load_scene(name)
    course, schedule, _ = run_of(scene)
    start_s, end_s = schedule.centre_s[0], schedule.centre_s[-1]
    for place in course.places:
        coarse, fine = (np.stack(place(np.linspace(start_s, end_s, n))) for n in (4001, 8001))
        steps = [np.hypot(*np.diff(points)).max() for points in (coarse, fine)]
        # The largest step halves with the time from one to the next; a jump would stay.
        assert steps[1] == pytest.approx(steps[0] / 2, rel=0.02)


def test_five_balls_in_a_row_never_overlap_and_keep_the_energy() -> None:
    scene = load_scene("cradle")
    course, schedule, _ = run_of(scene)
    along_m = np.array([place(schedule.centre_s)[0] for place in course.places])
    assert np.diff(along_m, axis=0).min() >= scene.setup.ball_diameter_m - TOUCH_M
    up_m = np.array([place(schedule.centre_s)[1] for place in course.places])
    thread_m, start_m = scene.setup.light_thread_m, scene.experiment.start_m
    assert up_m.sum(axis=0).max() <= thread_m - np.sqrt(thread_m**2 - start_m**2) + TOUCH_M


def test_the_paths_during_the_exposures_are_about_the_places_at_their_centres() -> None:
    scene = load_scene("throw")
    course, schedule, _ = run_of(scene)
    scale = projection_of(scene).px_per_m
    paths = list(exposures(course, schedule, scale))
    assert len(paths) == len(schedule.centre_s)
    along_m = np.array([path.bodies[0].along_m.mean() for path in paths])
    assert along_m == pytest.approx(course.places[0](schedule.centre_s)[0], abs=1e-12)


@pytest.mark.parametrize("name", ["bounce", "two-stops", "pucks", "cradle"])
def test_a_body_is_seen_where_the_truth_has_it(name: str) -> None:
    quiet = ("camera.read_noise=0", "camera.shot_noise=0", "camera.shutter=0.01", "light.shadow=0")
    plain = ("ball.spin_hz=0", "background.texture=0", "background.color=[120, 120, 120]")
    scene = load_scene(name, [*quiet, *plain, "clip.frames=5", "camera.capture_fps=20"])
    course, schedule, truth = run_of(scene)
    frames = list(frames_of(scene, 0, course, schedule))
    first, last = (frame.astype(float).mean(axis=2) for frame in (frames[0], frames[-1]))
    body = truth.bodies[-1] if name == "cradle" else truth.bodies[0]
    changed = np.abs(first - last) > 12
    x, y = np.round(body.x_px).astype(int), np.round(body.y_px).astype(int)
    moved_px = np.hypot(body.x_px[0] - body.x_px[-1], body.y_px[0] - body.y_px[-1])
    assert moved_px > 5
    reach = round(0.4 * scene.setup.ball_diameter_m * truth.px_per_m)
    for k in (0, -1):
        around = changed[max(y[k] - reach, 0) : y[k] + reach, max(x[k] - reach, 0) : x[k] + reach]
        assert around.mean() > 0.5


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_drawn_runs_differ_and_can_be_counted(name: str) -> None:
    scene = load_scene(name)
    drawn = [varied(scene, seed) for seed in range(3)]
    assert len({repr(scene) for scene in drawn}) == 3
    for one in drawn:
        _, _, truth = run_of(one)
        assert truth.resolved
        assert truth.frames <= 500


@pytest.mark.parametrize("strength", STRENGTHS)
@pytest.mark.parametrize("condition", EXPERIMENTS_OF_SUITE, ids=lambda condition: condition.name)
def test_every_clip_of_the_suite_can_be_counted_or_shows_nothing_to_count(
    condition: Condition, strength: Strength
) -> None:
    for number in range(2):
        _, _, truth = run_of(condition.scene(strength, number))
        assert truth.resolved
        assert truth.countable == (truth.count > 0)


def test_copies_and_lost_pictures_are_in_the_times_of_an_experiment_too() -> None:
    plain, copied, lost = (
        run_of(load_scene("bounce", settings))
        for settings in (
            [],
            ["encoding.repeat_every=5"],
            ["encoding.repeat_every=5", "encoding.repeat_lost=true"],
        )
    )
    assert lost[1].copies.sum() == copied[1].copies.sum() == len(plain[1].centre_s) // 5
    assert copied[2].frames == plain[2].frames + len(plain[1].centre_s) // 5
    assert [hit.frame for hit in lost[2].events] == [hit.frame for hit in plain[2].events]
    assert all(a.frame >= b.frame for a, b in zip(copied[2].events, plain[2].events, strict=True))


def test_a_shaken_camera_shakes_the_places_of_the_bodies() -> None:
    still, shaken = (
        run_of(load_scene("two-stops", settings))[2].bodies[0]
        for settings in ([], ["tripod.shake_px=3"])
    )
    assert np.abs(shaken.y_px - still.y_px).max() > 0.5
    assert np.hypot(shaken.x_px - still.x_px, shaken.y_px - still.y_px).max() <= 3 * np.sqrt(2)


def test_the_same_seed_draws_the_same_run() -> None:
    scene = load_scene("bounce")
    assert varied(scene, 5) == varied(scene, 5)


def test_hops_too_low_to_see_are_distinguished() -> None:
    scene = load_scene(
        "bounce", ["experiment.impacts=0", "experiment.duration_s=4", "setup.restitution_wall=0.6"]
    )
    _, _, truth = run_of(scene)
    assert 0 < truth.sure < truth.count
    assert json.loads(truth.text())["accept"] == [*range(truth.sure, truth.count + 1)]
    assert not truth.resolved


def test_an_impact_right_before_the_end_may_be_missed() -> None:
    scene = load_scene("bounce")
    _, schedule, whole = run_of(scene)
    end = int(whole.events[-1].frame) + 2
    assert end < len(schedule.centre_s)
    _, _, cut = run_of(load_scene("bounce", [f"clip.frames={end}"]))
    assert (whole.sure, whole.count) == (6, 6)
    assert (cut.sure, cut.count) == (5, 6)


def test_equal_bodies_that_exchange_their_velocities_are_seen_to_collide() -> None:
    _, _, truth = run_of(load_scene("carts", ["setup.restitution_bodies=1.0"]))
    assert (truth.sure, truth.count) == (1, 1)


def test_a_clip_has_its_truth_beside_it(tmp_path: Path) -> None:
    clip = tmp_path / "swing.mp4"
    truth = render_clip(load_scene("free-swing", ["clip.frames=5"]), 3, clip)
    found = json.loads(truth_path(clip).read_text(encoding="utf-8"))
    assert truth.frames == 5
    assert [row["frame"] for row in found["frames"]] == [0, 1, 2, 3, 4]
    assert (found["count"], found["expect"], found["seed"]) == (0, "not_counted", 3)


def test_what_cannot_be_shown_is_refused() -> None:
    with pytest.raises(UsageError, match="impacts"):
        run_of(load_scene("bounce", ["experiment.duration_s=0.5"]))
    with pytest.raises(UsageError, match="frames"):
        run_of(load_scene("free-swing", ["experiment.duration_s=1000"]))
    with pytest.raises(UsageError, match="trial"):
        course_of(load_scene("paper"))

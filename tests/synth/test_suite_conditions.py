"""The conditions by name, and the scenes that they make."""

from __future__ import annotations

import numpy as np
import pytest

from count_video.errors import UsageError
from count_video.physics.simulator import simulate
from synth_video.projection import projection_of
from synth_video.schedule import schedule_of
from synth_video.suite.camera_conditions import PART
from synth_video.suite.condition import STRENGTHS, Condition, Strength, choice
from synth_video.suite.suites import SUITES, Label, Take, conditions_of, label_of
from synth_video.truth import Truth, truth_of
from tiers import rest_slow

NUMBERS = rest_slow(range(3))
NOT_TO_BE_COUNTED = {"late", "early", "nothing"}
ALL = SUITES["all"]
TRIALS = [condition for condition in ALL if condition not in SUITES["experiments"]]


def truth(condition: Condition, strength: Strength, number: int) -> Truth:
    scene, seed = condition.scene(strength, number), condition.seed(number)
    motion = simulate(scene.setup, seed=seed)
    schedule = schedule_of(scene, motion, np.random.default_rng(seed))
    return truth_of(scene, seed, motion, schedule, projection_of(scene))


def test_conditions_have_names_of_their_own_without_a_dash_and_a_sentence() -> None:
    names = [condition.name for condition in ALL]
    assert len(set(names)) == len(names)
    assert [name for name in names if "-" in name] == []
    assert all(condition.sentence for condition in ALL)


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("strength", STRENGTHS)
@pytest.mark.parametrize("condition", TRIALS, ids=lambda condition: condition.name)
def test_clips_are_resolved_and_whole_unless_that_is_the_condition(
    condition: Condition, strength: Strength, number: int
) -> None:
    shown = truth(condition, strength, number)
    assert shown.countable == (condition.name not in NOT_TO_BE_COUNTED)
    assert shown.resolved or not shown.countable
    assert shown.scene.purpose == condition.sentence


@pytest.mark.parametrize("condition", ALL, ids=lambda condition: condition.name)
def test_the_strengths_differ(condition: Condition) -> None:
    assert condition.scene("ordinary", 0) != condition.scene("full", 0)


def test_each_condition_has_trials_of_its_own() -> None:
    setups = [condition.scene("full", 0).setup for condition in ALL]
    assert len(set(setups)) > 0.9 * len(setups)


def test_the_clips_take_values_in_turn() -> None:
    flags = [choice("encoding.rotation_deg=90 | 180 | 270", number) for number in range(4)]
    assert [flag.partition("=")[2] for flag in flags] == ["90", "180", "270", "90"]
    assert choice("camera.read_noise=5", 7) == "camera.read_noise=5"


def test_a_suite_can_be_narrowed_to_some_conditions() -> None:
    assert conditions_of("part") == PART
    assert [c.name for c in conditions_of("all", ["knock", "noise"])] == ["knock", "noise"]


@pytest.mark.parametrize(("suite", "wanted"), [("none", []), ("part", ["noise"])])
def test_an_unknown_suite_or_condition_is_refused(suite: str, wanted: list[str]) -> None:
    with pytest.raises(UsageError, match="there are"):
        conditions_of(suite, wanted)


def test_a_clip_is_named_by_condition_strength_and_number_and_says_them() -> None:
    take = Take(PART[0], "full", 7)
    assert take.name == f"{PART[0].name}-full-007.mp4"
    assert label_of(take.name.removesuffix(".mp4")) == Label(PART[0].name, "full")


def test_a_clip_of_no_suite_stands_for_itself() -> None:
    assert label_of("ratio100-count31") == Label("ratio100-count31", "")

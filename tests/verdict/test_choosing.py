from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from count_video.records import (
    BodyTrack,
    Collision,
    CollisionKind,
    FootageInfo,
    MotionLine,
    Track,
    TrialResult,
    Velocities,
)
from count_video.verdict.answers import unread_result
from count_video.verdict.choosing import Trial, is_better, only_counted

FRAMES = 40


def body() -> BodyTrack:
    return BodyTrack(np.arange(FRAMES, dtype=float), np.full(FRAMES, 0.1), -10.0, 10.0)


def track(*, wall_seen: bool) -> Track:
    line = MotionLine(0.0, 0.0, 0.0, upright=False)
    frame = np.arange(FRAMES, dtype=float)
    return Track(frame, body(), body(), "left", 20.0, line, (), wall_seen=wall_seen)


def collision(number: int, kind: CollisionKind) -> Collision:
    still = Velocities(0.0, 0.0)
    return Collision(number, kind, 5.0 * number, 0.5, None, True, 0.0, still, still)


def refused_at_a_wall() -> TrialResult:
    kinds: list[CollisionKind] = ["bodies", "wall", "bodies", "wall"]
    found = tuple(collision(number, kind) for number, kind in enumerate(kinds, 1))
    return replace(unread_result("clip", "refused"), collisions=found)


def two_that_met() -> TrialResult:
    return replace(unread_result("clip", ""), status="counted", count=1)


INFO = FootageInfo(
    *(Path("clip"), "h264", "yuv420p", 640, 240, 0),
    *(FRAMES, 30.0, None, "unknown"),
)


def refused_pair(*, path_shows: bool) -> Trial:
    """A trial at a wall that is not counted; its heavy body's path fits its collisions or not."""
    found: Any = SimpleNamespace(
        path_fits=path_shows, swing=SimpleNamespace(mass_ratio_relative_sigma=0.01)
    )
    return Trial(refused_at_a_wall(), INFO, track(wall_seen=True), found)


@pytest.mark.parametrize("path_shows", [True, False])
def test_a_wall_stands_before_two_free_bodies_only_if_the_path_shows_it(path_shows: bool) -> None:
    free = Trial(two_that_met(), INFO, track(wall_seen=False), None)

    assert is_better(free, refused_pair(path_shows=path_shows), 2) is not path_shows


@pytest.mark.parametrize("path_shows", [True, False])
def test_one_body_alone_does_not_come_before_a_trial_that_its_path_shows(path_shows: bool) -> None:
    bounces = replace(two_that_met(), count=9)
    alone = Trial(bounces, INFO, replace(track(wall_seen=False), heavy=None), None)

    assert is_better(alone, refused_pair(path_shows=path_shows), 2) is not path_shows


@pytest.mark.parametrize("counts", [[5], [None, 5], [5, None, None], [None, None]])
def test_of_bodies_taken_alone_the_one_that_is_counted_gives_the_answer(
    counts: list[int | None],
) -> None:
    chosen = only_counted([alone(count) for count in counts])

    assert chosen.result.count == next((count for count in counts if count), None)


def test_of_several_bodies_that_bounce_none_is_counted() -> None:
    chosen = only_counted([alone(None), alone(5), alone(5)]).result

    assert (chosen.status, chosen.count, chosen.probability) == ("not_counted", None, {})
    assert "2 bodies each bounce" in (chosen.reason or "")


def test_few_impacts_of_one_of_several_bodies_may_be_those_of_a_trial() -> None:
    chosen = only_counted([alone(2), alone(None)]).result

    assert (chosen.status, chosen.count, chosen.probability) == ("not_counted", None, {})
    assert "ball of a trial" in (chosen.reason or "")
    assert only_counted([alone(2)]).result.count == 2


def alone(count: int | None) -> Trial:
    found = unread_result("clip", "no impact is seen")
    if count is not None:
        found = replace(found, status="counted", reason=None, count=count, probability={count: 0.9})
    return Trial(found, INFO, replace(track(wall_seen=False), heavy=None), None)


def test_a_body_comes_before_a_pair_of_it_and_what_goes_with_it() -> None:
    assert is_better(alone(9), refused_pair(path_shows=True), 1)

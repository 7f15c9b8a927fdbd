from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from count_video.records import (
    BodyTrack,
    Collision,
    CollisionKind,
    MotionLine,
    Track,
    TrialResult,
    Velocities,
)
from count_video.verdict import is_better
from count_video.verdict.answers import unread_result

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


@pytest.mark.parametrize("borne_out", [True, False])
def test_a_wall_stands_before_two_free_bodies_only_if_it_is_borne_out(borne_out: bool) -> None:
    free, pair = track(wall_seen=False), track(wall_seen=True)

    better = is_better(two_that_met(), free, refused_at_a_wall(), pair, borne_out=borne_out)

    assert better is not borne_out


@pytest.mark.parametrize("borne_out", [True, False])
def test_one_body_alone_does_not_come_before_a_trial_that_is_borne_out(borne_out: bool) -> None:
    alone = replace(track(wall_seen=False), heavy=None)
    bounces = replace(two_that_met(), count=9)
    pair = track(wall_seen=True)

    better = is_better(bounces, alone, refused_at_a_wall(), pair, borne_out=borne_out)

    assert better is not borne_out

"""Two bodies that meet once, without a wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from count_video.explanations import without_a_wall
from count_video.reasons import Cause
from count_video.records import BodyTrack, FootageReport, MotionLine, Track

FRAMES, SIZE_PX, MEETS = 80, 20.0, 40.3
REPORT = FootageReport(FRAMES, FRAMES, ())


def track() -> Track:
    """The first body strikes the second, which is like it and rests; both show to the end."""
    rng = np.random.default_rng(2)
    frame = np.arange(float(FRAMES))
    ball = 200.0 + 3.0 * np.minimum(frame - MEETS, 0.0)
    heavy = 200.0 + SIZE_PX / 2 + 3.0 * np.maximum(frame - MEETS, 0.0)
    noise, sigma = rng.normal(0.0, 0.05, (2, FRAMES)), np.full(FRAMES, 0.05)
    return Track(
        frame=frame,
        ball=BodyTrack(ball + noise[0], sigma, -SIZE_PX / 2, SIZE_PX / 2),
        heavy=BodyTrack(heavy + noise[1], sigma, 0.0, SIZE_PX),
        wall_side="left",
        ball_diameter_px=SIZE_PX,
        line=MotionLine(0.0, 0.0, 0.0, upright=False),
        warnings=(),
        wall_seen=False,
    )


def test_the_collision_is_counted() -> None:
    explained = without_a_wall(track(), REPORT, lambda _: (False, False))

    assert (explained.counts, explained.count) == (True, 1)


@pytest.mark.parametrize(
    ("beyond", "cause"), [((True, False), Cause.WALL_BEHIND), ((False, True), Cause.WALL_AHEAD)]
)
def test_what_stands_beyond_an_end_of_the_clip_may_be_a_wall(
    beyond: tuple[bool, bool], cause: Cause
) -> None:
    explained = without_a_wall(track(), REPORT, lambda _: beyond)

    assert not explained.counts
    assert [reason.cause for reason in explained.against] == [cause]


def test_a_body_that_is_lost_may_collide_again() -> None:
    lost = replace(track(), lost_beyond=(60.0,))

    explained = without_a_wall(lost, REPORT, lambda _: (False, False))

    assert not explained.counts
    assert [(one.cause, one.figures) for one in explained.against] == [(Cause.LOST, (60.0,))]

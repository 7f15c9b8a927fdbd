"""Two bodies that meet once, without a wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from count_video.motion.fitted import NOTHING_KNOWN
from count_video.reasons import Cause
from count_video.records import BodyTrack, MotionLine, Track
from count_video.scenes import without_a_wall

FRAMES, SIZE_PX, MEETS = 80, 20.0, 40.3
AT_CORNER_PX = 1.0
"""A place between two pictures about a corner of 3 px a frame is wrong by a quarter of that."""


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
    explained = without_a_wall(track(), NOTHING_KNOWN, lambda _: (False, False))

    assert (explained.counts, explained.count) == (True, 1)


@pytest.mark.parametrize(
    ("beyond", "cause"), [((True, False), Cause.WALL_BEHIND), ((False, True), Cause.WALL_AHEAD)]
)
def test_what_stands_beyond_an_end_of_the_clip_may_be_a_wall(
    beyond: tuple[bool, bool], cause: Cause
) -> None:
    explained = without_a_wall(track(), NOTHING_KNOWN, lambda _: beyond)

    assert not explained.counts
    assert [reason.cause for reason in explained.against] == [cause]


def meets_again() -> Track:
    """Two bodies that swing to and fro between each other, as a cradle of two."""
    frame = np.arange(160.0)
    swing = 80.0 * np.sin(2 * np.pi / 28.0 * (frame - 7.3))
    noise, sigma = np.random.default_rng(1).normal(0.0, 0.05, (2, 160)), np.full(160, 0.05)
    left = BodyTrack(300.0 + np.minimum(swing, 0.0) + noise[0], sigma, -SIZE_PX, SIZE_PX)
    right = BodyTrack(300.0 + SIZE_PX + np.maximum(swing, 0.0) + noise[1], sigma, 0.0, 2 * SIZE_PX)
    return replace(track(), frame=frame, ball=left, heavy=right, ball_diameter_px=2 * SIZE_PX)


@pytest.mark.parametrize("beyond", [(True, False), (False, True)])
def test_bodies_that_meet_again_have_no_wall_between_two_meetings(
    beyond: tuple[bool, bool],
) -> None:
    explained = without_a_wall(meets_again(), NOTHING_KNOWN, lambda _: beyond)

    assert (explained.counts, explained.count) == (True, 11)


def test_a_body_that_is_lost_may_collide_again() -> None:
    lost = replace(track(), lost_beyond=(60.0,))

    explained = without_a_wall(lost, NOTHING_KNOWN, lambda _: (False, False))

    assert not explained.counts
    assert [(one.cause, one.figures) for one in explained.against] == [(Cause.LOST, (60.0,))]


def test_two_bodies_that_meet_are_counted_between_copies() -> None:
    """One picture in six is a copy, as from 25 to 30 a second."""
    shown = meets_again()
    copied = replace(shown, frame=shown.frame + shown.frame // 5)
    true, found = (
        without_a_wall(one, NOTHING_KNOWN, lambda _: (False, False)) for one in (shown, copied)
    )
    assert (true.counts, true.count) == (found.counts, found.count) == (True, 11)
    times = np.array([one.frame for one in true.collisions])
    # After picture k, the frame after the copies before it.
    expected = times + times // 5
    np.testing.assert_allclose([one.frame for one in found.collisions], expected, atol=1.0)


def test_bodies_are_named_alike_in_track_and_collisions_whatever_wall_is_given() -> None:
    shown = track()
    assert shown.heavy is not None
    turned = replace(
        shown,
        wall_side="right",
        ball=BodyTrack(
            shown.heavy.position_px + SIZE_PX / 2, shown.ball.sigma_px, -SIZE_PX / 2, SIZE_PX / 2
        ),
        heavy=BodyTrack(shown.ball.position_px + SIZE_PX / 2, shown.ball.sigma_px, -SIZE_PX, 0.0),
    )
    explained = without_a_wall(turned, NOTHING_KNOWN, lambda _: (False, False))
    (one,) = explained.collisions
    place = np.interp(one.frame, explained.track.frame, explained.track.ball.position_px)
    assert place == pytest.approx(one.position_px, abs=AT_CORNER_PX)
    touches = place + explained.track.ball.high_edge_px
    assert touches == pytest.approx(200.0 + SIZE_PX / 2, abs=AT_CORNER_PX)

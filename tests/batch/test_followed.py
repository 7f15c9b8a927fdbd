"""What was followed is kept as text, and comes back as it was."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from count_video.answers import Followed
from count_video.batch.results import packed, unpacked
from count_video.records import (
    BodyTrack,
    CameraTurns,
    Collision,
    MotionLine,
    Track,
    TrialResult,
    Velocities,
)

NAN, INF = float("nan"), float("inf")


def followed_once() -> Followed:
    """Two bodies, one of them seen in part, and a collision of which little is known."""
    frame = np.arange(4.0)
    ball = BodyTrack(np.array([1.5, NAN, 2.5, NAN]), np.full(4, 0.1), -20.0, 20.0)
    heavy = BodyTrack(np.array([9.0, 8.0, NAN, INF]), np.full(4, 0.2), NAN, 40.0)
    line, turned = (
        MotionLine(0.0, 0.0, 0.0, upright=False),
        CameraTurns(np.ones((4, 2)), (9.5, 7.0)),
    )
    track = Track(frame, ball, heavy, "left", NAN, line, (), np.zeros((4, 2)), turned)
    unknown = Velocities(NAN, -INF)
    collision = Collision(
        number=1,
        kind="wall",
        frame=2.5,
        frame_sigma=NAN,
        seen=True,
        position_px=80.0,
        velocity_before=unknown,
        velocity_after=unknown,
    )
    return Followed(
        replace(TrialResult("clip.mp4", "not_counted", "nothing moves"), collisions=(collision,)),
        track,
    )


def test_numbers_without_a_value_come_back_as_they_were() -> None:
    kept = followed_once()
    back = unpacked(Followed, packed(kept))

    assert back.track is not None
    assert kept.track is not None
    assert back.track.heavy is not None
    assert kept.track.heavy is not None
    for one, other in ((back.track.ball, kept.track.ball), (back.track.heavy, kept.track.heavy)):
        np.testing.assert_array_equal(one.position_px, other.position_px)
    assert np.isnan(back.track.heavy.low_edge_px)
    found = back.result.collisions[0]
    assert np.isnan(found.frame_sigma)
    assert found.velocity_after.heavy_px_frame == -INF
    assert found.time_s is None
    assert back.track.turned is not None
    assert back.track.turned.of(1, (10.5, 7.0)) == (10.5, 8.0)
    assert packed(back) == packed(kept)


@pytest.mark.parametrize("word", ["wide", "", "[]"])
def test_a_word_in_place_of_a_number_is_refused(word: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        unpacked(Followed, packed(followed_once()).replace("NaN", json.dumps(word), 1))

"""The answer for one body alone: a count only where it is as probable as all others together."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest

from count_video import answers, explanations
from count_video.motion.meeting import seen_impacts
from count_video.motion.parameters import Knowledge
from count_video.motion.priors import PARTNER_UNSEEN, STANDS_STILL
from count_video.reasons import Cause
from count_video.records import (
    BodyTrack,
    FootageInfo,
    FootageReport,
    MotionLine,
    Track,
    TrialResult,
)
from count_video.scenes import at_a_stop
from count_video.settings import TrialSettings

FRAMES, SPEED_PX, WIDTH_PX = 200, 3.0, 150.0
PULL_PX = 0.4
"""Acceleration in px a frame squared."""
FIRST, LAST = 20, 152
"""The clip begins and ends while the body is in the air."""
STRAY_PX = 40.0
"""Half of what the body rises: far more than a share of it that lenses or the air make."""
INFO = FootageInfo(*(Path("clip"), 640, 240, 0), *(FRAMES, 30.0, None, "unknown"))
REPORT = FootageReport(FRAMES, FRAMES, ())


def track() -> Track:
    """A body that goes to and fro between two stops."""
    way = SPEED_PX * np.arange(float(FRAMES)) + WIDTH_PX / 3
    place = WIDTH_PX - np.abs(way % (2 * WIDTH_PX) - WIDTH_PX)
    body = BodyTrack(place, np.full(FRAMES, 0.1), -20.0, 20.0)
    line = MotionLine(0.0, 0.0, 0.0, upright=False)
    return Track(np.arange(float(FRAMES)), body, None, "left", 40.0, line, ())


def answer(
    shares: dict[int, float],
    impacts: int | None = None,
    *,
    moves: bool = False,
    path: Track | None = None,
) -> TrialResult:
    path = path or track()
    shown = seen_impacts(path)
    found = replace(shown, probability=shares, collisions=shown.collisions[:impacts])
    with patch.object(explanations, "seen_impacts", return_value=found):
        explained = at_a_stop(path, Knowledge(), lambda _: moves)
        return answers.answer(explained, INFO, REPORT, TrialSettings())


def test_a_count_is_given_where_it_is_probable() -> None:
    result = answer({3: 0.4, 4: 0.6})

    assert (result.status, result.count) == ("counted", 4)
    assert [one.number for one in result.collisions] == [1, 2, 3, 4]


@pytest.mark.parametrize("others", [{3: 0.26, 5: 0.26}, {5: 0.52}])
def test_none_is_given_where_others_are_together_more_probable(others: dict[int, float]) -> None:
    result = answer({4: 0.48, **others})

    assert (result.status, result.count, result.seen) == ("not_counted", None, 4)
    assert result.reason is not None
    assert "(4)" in result.reason
    assert "48%" in result.reason


def test_one_impact_may_be_the_burst_of_a_ball_that_was_not_found() -> None:
    still, moving = (answer({1: 0.9, 2: 0.1}, 1, moves=moves) for moves in (False, True))
    hidden = PARTNER_UNSEEN * STANDS_STILL[1]
    hidden /= hidden + (1 - PARTNER_UNSEEN) * STANDS_STILL[0]

    assert (still.status, still.count) == ("counted", 1)
    assert still.probability == pytest.approx({1: 0.9 * (1 - hidden), 2: 0.1 * (1 - hidden)})
    assert still.reason is not None
    assert f"{hidden:.0%}" in still.reason
    assert (moving.status, moving.count) == ("not_counted", None)


@pytest.mark.parametrize("moves", [True, False])
def test_between_two_stops_nothing_else_moves(moves: bool) -> None:
    """The ball of a trial turns round at the wall and at its cylinder, any number of times."""
    result = answer({4: 1.0}, moves=moves)

    assert result.count == (None if moves else 4)
    assert result.count_after_burst is not None
    assert ("moves where the body turns" in (result.reason or "")) is moves


def bounces() -> Track:
    """A body that bounces at one stop under a constant pull, ever less."""
    place, clock = [], np.arange(200.0)
    begins, speed = 0.0, 8.0
    for _ in range(6):
        lasts = 2 * speed / PULL_PX
        inside = clock[(clock >= begins) & (clock < begins + lasts)] - begins
        place.extend(speed * inside - PULL_PX * inside**2 / 2)
        begins, speed = begins + lasts, 0.9 * speed
    shown = np.array(place)[FIRST:LAST]
    body = BodyTrack(shown, np.full(len(shown), 0.1), -20.0, 20.0)
    line = MotionLine(0.0, 0.0, 0.0, upright=False)
    return Track(np.arange(float(len(shown))), body, None, "left", 40.0, line, ())


def test_many_impacts_at_one_stop_are_those_of_a_body_that_bounces() -> None:
    assert answer({4: 1.0}, moves=True, path=bounces()).count == 4


def test_a_path_of_no_free_flights_is_no_motion_of_one_body() -> None:
    """As where a clip shows a trial once more, or what is followed changes from body to body."""
    free, mixed = bounces(), bounces()
    part = slice(40, 100)
    path = mixed.ball.position_px.copy()
    path[part] = path[part][::-1] + STRAY_PX * np.sin(np.arange(60) / 4.0)
    mixed = replace(mixed, ball=replace(mixed.ball, position_px=path))
    causes = [{reason.cause for reason in seen_impacts(one).shortcomings} for one in (free, mixed)]

    assert Cause.MODEL_STRAYS not in causes[0]
    assert Cause.MODEL_STRAYS in causes[1]

"""A bouncing ball that pictures do not show for some of its flights."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from free_paths import alone, bouncing, noisy

from count_video.motion.beginnings import before_first
from count_video.motion.fitted import NOTHING_KNOWN
from count_video.motion.flight import motion_of
from count_video.motion.impacts import find_impacts
from count_video.motion.meeting import seen_impacts
from count_video.motion.parameters import Knowledge
from count_video.reasons import Cause
from count_video.records import SURE, Floats
from count_video.scenes import of_one

NOISE_PX = 0.3
HELD = 20
"""Pictures for which a hand holds a ball."""
FLIGHT, PULL = 16.0, 14.0
"""Frames of the first flight, and px per frame squared."""
TIMES_WITHIN = 0.2
"""Frames by which a time may be wrong: several times what its flights leave open here."""


def dropped(number: int, kept: float = 0.93) -> tuple[Floats, list[float]]:
    """A ball dropped on a floor, and its impacts; each flight lasts a share of the one before."""
    return bouncing((FLIGHT * kept ** np.arange(number)).tolist(), PULL, FLIGHT / 2)


@pytest.mark.parametrize("kept", [0.8, 0.87, 0.93])
@pytest.mark.parametrize("missed", [2, 3])
def test_a_ball_that_came_back_unseen_leaves_the_count_open(missed: int, kept: float) -> None:
    place, impacts = dropped(6, kept)
    middle = round(impacts[missed])
    place[middle - 4 : middle + 5] = np.nan

    found = seen_impacts(alone(noisy(place, NOISE_PX)))

    number = len(found.collisions)
    assert number == len(impacts) or found.probability.get(number, 0.0) < SURE


@pytest.mark.parametrize("hidden", [3, 5])
def test_a_ball_that_a_hand_holds_and_lets_go_bounced_not_before(hidden: int) -> None:
    """The hand hides it before it lets it go, and for some pictures afterwards."""
    place, impacts = dropped(6)
    held = np.concatenate([np.full(HELD, place[0]), place])
    held = noisy(held, NOISE_PX)
    held[HELD - int(FLIGHT) // 2 - 2 : HELD + hidden] = np.nan

    found = seen_impacts(alone(held))

    assert [one.frame for one in found.collisions] == pytest.approx(
        [HELD + impact for impact in impacts], abs=TIMES_WITHIN
    )
    assert found.probability[len(impacts)] > SURE


def test_that_more_impacts_were_hidden_is_no_likelier_than_that_one_was() -> None:
    """None comes before one that did not happen."""
    place = noisy(dropped(6)[0], NOISE_PX)
    many = np.concatenate([np.full(4 * int(FLIGHT), np.nan), place])
    few = np.concatenate([np.full(int(FLIGHT) + 2, np.nan), place])
    chances = []
    for one in (few, many):
        motion = motion_of(np.arange(float(len(one))), one)
        found, _ = find_impacts(motion)
        chances.append([unseen.chance for unseen in before_first(motion, found)])
    assert len(chances[1]) > len(chances[0]) > 0
    assert all(later <= sooner for sooner, later in pairwise(chances[1]))
    assert chances[1][1] < chances[1][0]


def lost_before_its_last_impact(seed: int, left: int) -> tuple[Floats, list[float]]:
    """A ball that is seen for the last time just before an impact, with so many pictures after."""
    place, impacts = dropped(6)
    last = int(impacts[-1])
    seen = np.full(last + 1 + left, np.nan)
    seen[: last + 1] = noisy(place[: last + 1], NOISE_PX, seed)
    # Two pictures show how fast the flight before the last one begins, and badly.
    begins = int(impacts[-3])
    seen[begins + 3 : int(impacts[-2]) - 1] = np.nan
    seen[begins + 2] -= 16.0
    return seen, impacts


def test_a_mirror_image_gives_the_same_answer() -> None:
    place, _ = lost_before_its_last_impact(0, 3)
    one, other = (
        of_one(alone(path), NOTHING_KNOWN, lambda _: True) for path in (place, 400.0 - place)
    )
    assert (one.count, one.counts, one.against) == (other.count, other.counts, other.against)
    assert one.counts


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("left", [3, 5])
def test_an_impact_that_no_picture_shows_before_the_clip_ends_is_inferred(
    left: int, seed: int
) -> None:
    place, impacts = lost_before_its_last_impact(seed, left)

    found = seen_impacts(alone(place))

    last = found.collisions[-1]
    assert len(found.collisions) == len(impacts)
    assert last.seen is False
    assert last.frame == pytest.approx(impacts[-1], abs=last.frame_sigma)
    assert 0.5 < found.probability[len(impacts)] < SURE
    assert Cause.LAST_UNSEEN in [doubt.cause for doubt in found.doubts]


@pytest.mark.parametrize("left", [12, 16, 20])
def test_where_more_than_one_may_follow_unseen_the_count_is_open(left: int) -> None:
    place, impacts = lost_before_its_last_impact(0, left)

    found = seen_impacts(alone(place))

    number = len(found.collisions)
    assert number == len(impacts) - 1
    assert found.probability.get(number, 0.0) < 0.5
    assert Cause.TOO_FREQUENT in [doubt.cause for doubt in found.doubts]


@pytest.mark.parametrize("missed", [2, 3, 4])
def test_a_ball_that_is_not_seen_while_it_is_high_bounced_no_more(missed: int) -> None:
    place, impacts = dropped(7)
    top = round((impacts[missed] + impacts[missed + 1]) / 2)
    place[top - 2 : top + 3] = np.nan

    found = seen_impacts(alone(noisy(place, NOISE_PX)))

    assert len(found.collisions) == len(impacts)
    assert Cause.TOO_FREQUENT not in [doubt.cause for doubt in found.doubts]


def test_places_before_an_unseen_impact_do_not_mislead_the_first_one_seen() -> None:
    place, impacts = dropped(6)
    first = round(impacts[0])
    place[: first - 2] = np.nan
    place[first - 1 : first + 1] = np.nan

    found = seen_impacts(alone(noisy(place, NOISE_PX)))

    times = [one.frame for one in found.collisions if one.seen]
    assert found.collisions[0].seen is False
    assert times == pytest.approx(impacts[1:], abs=TIMES_WITHIN)


def test_what_no_picture_shows_is_not_counted_where_only_seen_impacts_are_asked_for() -> None:
    place, impacts = lost_before_its_last_impact(0, 3)
    counted, asked = (
        of_one(alone(place), Knowledge(seen_only=only), lambda _: False) for only in (False, True)
    )
    assert (counted.counts, counted.count) == (True, len(impacts))
    assert not all(one.seen for one in counted.collisions)
    assert all(one.seen for one in asked.collisions)
    assert not asked.counts  # that these are all is not probable


@pytest.mark.parametrize("after", [0.5, 1.5, 2.5, 3.5])
def test_an_impact_where_pictures_are_rare_lies_in_whichever_step_it_does(after: float) -> None:
    every = 4.0
    frame = every * np.arange(-12, 13)
    closing = np.abs(frame - after) + noisy(np.zeros(len(frame)), 0.05)

    impacts, _ = find_impacts(motion_of(frame, closing))

    assert [one.likely for one in impacts] == [True]
    assert impacts[0].frame == pytest.approx(after, abs=TIMES_WITHIN)

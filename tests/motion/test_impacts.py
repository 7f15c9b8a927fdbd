from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from free_paths import SIZE_PX, alone, between_stops, bouncing, noisy, pair, rolling
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import log_ndtr

from count_video.motion.beginnings import before_first
from count_video.motion.corners import _log_normal
from count_video.motion.flight import friction_of, motion_of, usual_acceleration
from count_video.motion.impacts import find_impacts
from count_video.motion.meeting import seen_impacts
from count_video.motion.priors import CHANCE_UNSEEN
from count_video.motion.seen import SeenCollisions
from count_video.motion.weighing import chances_of_sum, weighed
from count_video.reasons import Cause
from count_video.records import Floats

NOISE_PX, SHARP_PX = 0.2, 0.03
TIME_FRAMES = 0.1
"""Bounces at several px a frame, seen with that noise, are placed far better than this."""
FOUR_SIGMAS = 4.0
LITTLE = 0.15
"""One of them may be less clear than ten standard uncertainties."""
DYING = [24.0, 20.4, 17.3, 14.7, 12.5]
PULL = 0.8


def frames(found: SeenCollisions) -> list[float]:
    return [collision.frame for collision in found.collisions]


def counts(found: SeenCollisions) -> bool:
    return not found.shortcomings


def assert_found(found: SeenCollisions, impacts: list[float]) -> None:
    assert counts(found), found.shortcomings
    assert frames(found) == pytest.approx(impacts, abs=TIME_FRAMES)
    assert max(found.probability, key=lambda n: found.probability[n]) == len(impacts)


@pytest.mark.parametrize("sign", [1, -1])
def test_every_bounce_of_a_dropped_ball_is_an_impact_whichever_side_is_down(sign: int) -> None:
    place, impacts = bouncing(DYING, PULL, drop=20.3)

    found = seen_impacts(alone(sign * noisy(place, NOISE_PX)))

    assert_found(found, impacts)
    assert {collision.kind for collision in found.collisions} == {"wall"}
    assert found.probability[len(impacts)] > 0.9


def test_bounces_between_two_stops_count_at_both() -> None:
    place, impacts = between_stops(speed=6.5, width=210.0, frames=160)

    assert_found(seen_impacts(alone(noisy(place, NOISE_PX))), impacts)


@pytest.mark.parametrize(("sigmas", "least", "most"), [(9, 0.9, 1), (0, 0.9, 1), (-4, 0, 0.1)])
def test_velocities_that_do_not_turn_round_say_that_impacts_were_missed(
    sigmas: float, least: float, most: float
) -> None:
    """As surely as they are known: one that is as good as 0 says nothing."""
    place, impacts = bouncing(DYING, PULL, drop=20.3)
    motion = motion_of(np.arange(len(place), dtype=np.float64), noisy(place, SHARP_PX))
    turns, contact = find_impacts(motion)
    *others, last = seen_impacts(alone(noisy(place, SHARP_PX))).collisions
    sigma = last.velocity_after.ball_sigma_px_frame
    after = replace(last.velocity_after, ball_px_frame=-sigmas * sigma)  # downward is positive

    earlier = before_first(motion, [turn for turn in turns if turn.likely])
    collisions = [*others, replace(last, velocity_after=after)]

    found = weighed(motion, turns, earlier, contact, 1.0, collisions)

    assert sum(found.probability.values()) == pytest.approx(1.0)
    assert least <= found.probability.get(len(impacts), 0.0) <= most
    assert (Cause.NOT_TURNED in {doubt.cause for doubt in found.doubts}) is (sigmas < 0)


def test_impacts_are_the_same_in_frames_where_every_picture_comes_twice() -> None:
    place, impacts = bouncing(DYING, PULL, drop=20.3)

    found = seen_impacts(alone(noisy(place, NOISE_PX), pace=2.0))

    assert frames(found) == pytest.approx([2 * i for i in impacts], abs=2 * TIME_FRAMES)


@given(st.floats(30.0, 140.0), st.floats(0.0, 6.28), st.floats(20.0, 200.0), st.integers(0, 9))
@settings(max_examples=25)
def test_a_swing_has_no_impacts(period: float, phase: float, reach: float, seed: int) -> None:
    swing = reach * np.cos(2 * np.pi * np.arange(200) / period + phase)

    assert not counts(seen_impacts(alone(noisy(swing, NOISE_PX, seed))))


@given(st.floats(0.2, 2.0), st.floats(10.0, 40.0), st.integers(0, 9))
@settings(max_examples=15)
def test_a_throw_has_no_impacts(pull: float, half: float, seed: int) -> None:
    frame = np.arange(int(2 * half))

    assert not counts(seen_impacts(alone(noisy(pull / 2 * (frame - half) ** 2, NOISE_PX, seed))))


def test_a_body_at_rest_has_no_impacts() -> None:
    assert not counts(seen_impacts(alone(noisy(np.full(90, 50.0), NOISE_PX))))


def test_pictures_without_the_body_within_a_flight_hide_nothing() -> None:
    place, impacts = bouncing(DYING, PULL, drop=20.3)
    place = noisy(place, NOISE_PX)
    place[28:36] = np.nan

    assert_found(seen_impacts(alone(place)), impacts)


@pytest.mark.parametrize("hidden", [4, 8, 12])
def test_an_impact_that_no_picture_shows_is_where_the_flights_meet(hidden: int) -> None:
    place, impacts = bouncing(DYING, PULL, drop=20.3)
    place = noisy(place, NOISE_PX)
    first = int(impacts[1]) - hidden // 2
    place[first : first + hidden] = np.nan

    found = seen_impacts(alone(place))

    assert counts(found)
    errors = [collision.frame_sigma for collision in found.collisions]
    assert len(errors) == len(impacts)
    strays = np.abs(np.array(frames(found)) - impacts) / np.maximum(errors, TIME_FRAMES)
    assert strays.max() < FOUR_SIGMAS


@pytest.mark.parametrize("around", [1, 3])
def test_two_impacts_that_no_picture_shows_are_not_taken_for_one(around: int) -> None:
    place, impacts = bouncing([16.0, 14.4, 13.0, 11.7, 10.5], PULL, drop=14.0)
    place[int(impacts[1]) - around : int(impacts[2]) + around] = np.nan

    found = seen_impacts(alone(noisy(place, NOISE_PX)))

    fewer = sum(share for number, share in found.probability.items() if number < len(impacts) - 1)
    assert fewer < 0.5


def test_a_last_impact_that_is_due_when_no_picture_shows_the_body_leaves_a_doubt() -> None:
    place, impacts = bouncing([16.0, 14.4, 13.0, 11.7], PULL, drop=14.0)
    place = place[: int(impacts[-1]) + 4]
    place[-6:] = np.nan

    found = seen_impacts(alone(noisy(place, NOISE_PX)))

    assert len(found.collisions) == len(impacts) - 1
    assert found.probability[len(impacts) - 1] < 0.5


def test_one_misplaced_picture_is_no_impact() -> None:
    place, impacts = bouncing(DYING, PULL, drop=20.3)
    place = noisy(place, NOISE_PX)
    place[int(impacts[1]) + 4] += 12.0

    assert frames(seen_impacts(alone(place))) == pytest.approx(impacts, abs=TIME_FRAMES)


def test_a_body_that_turns_against_its_weight_bounced_however_few_pictures_show_it() -> None:
    flights = [20.0, 14.0, 9.8, 6.9, 4.8, 3.4]
    place, impacts = bouncing(flights, PULL, drop=14.3)

    found = seen_impacts(alone(noisy(place, NOISE_PX)))

    assert len(found.collisions) == len(impacts)
    # Below what the pictures show more may follow, but none of those seen is in doubt.
    fewer = sum(share for number, share in found.probability.items() if number < len(impacts))
    assert fewer < LITTLE


def test_a_ball_that_falls_back_unseen_leaves_a_doubt() -> None:
    place, impacts = bouncing([*DYING, 40.0], PULL, drop=20.3)
    place[int(impacts[-1]) + 8 :] = np.nan
    place = np.append(noisy(place, NOISE_PX), np.full(30, np.nan))

    found = seen_impacts(alone(place))

    assert found.doubts
    assert found.probability[len(impacts)] < 0.9


@pytest.mark.parametrize("hidden", range(0, 62, 3))
def test_a_hidden_beginning_never_makes_a_smaller_count_a_sure_one(hidden: int) -> None:
    place, impacts = bouncing(DYING, PULL, drop=20.3)
    place = noisy(place, NOISE_PX)
    place[:hidden] = np.nan

    found = seen_impacts(alone(place))

    if len(found.collisions) < len(impacts):
        assert not counts(found) or found.probability[len(found.collisions)] < 0.9


@pytest.mark.parametrize("seen", [1, 3])
@pytest.mark.parametrize("hidden", range(2, 12, 3))
def test_an_impact_between_a_few_sightings_and_the_rest_is_inferred(hidden: int, seen: int) -> None:
    place, impacts = bouncing(DYING, PULL, drop=20.3)
    place = noisy(place, NOISE_PX)
    first = int(impacts[0])
    place[: first - seen] = np.nan
    place[first : first + hidden] = np.nan

    found = seen_impacts(alone(place))

    assert counts(found)
    assert max(found.probability, key=lambda n: found.probability[n]) == len(impacts)
    assert len(found.collisions) == len(impacts)
    inferred = found.collisions[0]
    assert inferred.seen or inferred.frame_sigma <= (hidden + 1) / 2
    assert abs(inferred.frame - impacts[0]) < max(TIME_FRAMES, 2 * inferred.frame_sigma)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_first_impact_that_no_picture_shows_is_as_likely_as_stated(sign: int) -> None:
    place, impacts = bouncing(DYING, PULL, drop=20.3)
    place = sign * noisy(place, NOISE_PX)
    place[: int(impacts[0]) + 5] = np.nan

    found = seen_impacts(alone(place))

    assert [one.seen for one in found.collisions] == [False, *[True] * (len(impacts) - 1)]
    assert found.collisions[0].frame == pytest.approx(impacts[0], abs=1.0)
    assert [doubt.cause for doubt in found.doubts] == [Cause.FIRST_UNSEEN]
    assert found.probability[len(impacts)] == pytest.approx(1 - CHANCE_UNSEEN, abs=0.05)


@pytest.mark.parametrize(("before", "after"), [(0.0, 0.0), (3.0, 0.0), (3.0, 6.0), (-3.0, 3.0)])
def test_velocities_that_are_none_of_an_impact_say_little_of_what_came_before(
    before: float, after: float
) -> None:
    place, _ = bouncing(DYING, PULL, drop=20.3)
    place[:25] = np.nan
    motion = motion_of(np.arange(len(place), dtype=float), noisy(place, NOISE_PX))
    first = replace(find_impacts(motion)[0][0], before=-before, after=-after)

    earlier = before_first(motion, [first])

    assert len(earlier) <= 1
    assert all(0 <= one.frame < first.frame for one in earlier)


def test_bounces_too_frequent_for_the_pictures_are_said_to_be_so() -> None:
    flights = [24 * 0.75**n for n in range(12)]
    place, _ = bouncing([*flights, 30.0], PULL, drop=24.0)
    place[int(24 + sum(flights)) :] = 300.0

    found = seen_impacts(alone(noisy(place, 0.05)))

    assert found.doubts
    assert max(found.probability.values()) < 0.9


def test_a_pendulum_that_strikes_ever_more_gently_has_no_tail_of_unseen_impacts() -> None:
    # Half a swing takes as long however wide it is: no flight is too short for the pictures.
    half, count = 29.3, 9
    frame = 10.0 + np.arange(int(count * half) + 6)
    flight = np.floor(frame / half)
    place = 110.0 * 0.75**flight * np.abs(np.sin(np.pi * frame / half))

    found = seen_impacts(alone(noisy(place, 0.05)))

    assert len(found.collisions) == count
    assert not found.doubts


def two_that_meet(frames_before: int, frames_after: int) -> tuple[Floats, Floats, float]:
    """Two equal bodies that exchange their velocities, 3 and -1 px per frame, at contact."""
    time = np.arange(-frames_before, frames_after) + 0.4
    left = np.where(time < 0, 3.0, -1.0) * time
    right = np.where(time < 0, -1.0, 3.0) * time + SIZE_PX
    return left, right, frames_before - 0.4


def test_two_bodies_that_meet_and_part_collide_once() -> None:
    left, right, contact = two_that_meet(30, 30)

    found = seen_impacts(pair(noisy(left, NOISE_PX), noisy(right, NOISE_PX, 1)))

    assert_found(found, [contact])
    (collision,) = found.collisions
    assert collision.kind == "bodies"
    assert collision.velocity_before.ball_px_frame == pytest.approx(3.0, abs=0.1)
    assert collision.velocity_after.heavy_px_frame == pytest.approx(3.0, abs=0.1)


def test_bodies_that_turn_without_touching_do_not_collide() -> None:
    swing = 30 * np.cos(2 * np.pi * np.arange(160) / 50)

    assert not counts(seen_impacts(pair(swing - 45, 45 - swing)))


@pytest.mark.parametrize(("before", "after"), [(40, 8), (8, 40)])
def test_a_clip_may_begin_or_end_next_to_the_only_contact(before: int, after: int) -> None:
    left, right, contact = two_that_meet(before, after)

    found = seen_impacts(pair(noisy(left, NOISE_PX), noisy(right, NOISE_PX, 1)))

    assert counts(found)
    (collision,) = found.collisions
    assert collision.frame == pytest.approx(contact, abs=4 * collision.frame_sigma)


@pytest.mark.parametrize(("step", "cause"), [(1, "STARTS_TOGETHER"), (-1, "ENDS_TOGETHER")])
def test_bodies_that_part_as_the_clip_begins_have_met_before(step: int, cause: str) -> None:
    # Two swings meet every 50 frames: 2 frames before the clip begins, and once in it.
    gap = 80.0 * np.abs(np.sin(np.pi * np.arange(2, 78) / 50))[::step]

    found = seen_impacts(pair(noisy(-gap / 2, NOISE_PX), noisy(SIZE_PX + gap / 2, NOISE_PX, 1)))

    assert [reason.cause.name for reason in found.shortcomings] == [cause]


def test_two_bodies_of_which_one_bounces_off_a_wall_are_not_counted() -> None:
    left, right, _ = two_that_meet(40, 60)
    left = np.where(left < -30, -60 - left, left)

    found = seen_impacts(pair(noisy(left, NOISE_PX), noisy(right, NOISE_PX, 1)))

    assert any(reason.cause is Cause.MEETS_OTHERS for reason in found.shortcomings)


def test_the_usual_acceleration_is_that_of_the_flights() -> None:
    place, _ = bouncing(DYING, PULL, drop=20.3)

    usual, spread = usual_acceleration(np.arange(len(place), dtype=float), place)

    assert usual == pytest.approx(PULL)
    assert spread == pytest.approx(0.0, abs=1e-9 * PULL)


FRICTION = 0.0075
"""Slows a body of 7.5 px a picture, by as many px per picture squared, within a thousand."""
FRICTION_WITHIN = 0.1
"""Share to which places with noise show it; twice as much as rounding of their steps makes."""


def test_friction_turns_round_with_the_body_and_nothing_else_does() -> None:
    frame = np.arange(400.0)
    place, _ = rolling(7.5, 600.0, FRICTION, 0.88)
    fall, _ = bouncing(DYING, PULL, drop=20.3)
    swing = 100.0 * np.cos(frame / 20.0)
    swung_px = 100.0 / 20.0**2
    """Its largest acceleration."""

    shown = friction_of(np.arange(float(len(place))), noisy(place, SHARP_PX))
    of_fall, of_swing = friction_of(frame[: len(fall)], fall), friction_of(frame, swing)

    assert shown == pytest.approx(2 * FRICTION, rel=FRICTION_WITHIN)
    assert of_fall < FRICTION_WITHIN * PULL
    assert of_swing < FRICTION_WITHIN * swung_px


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("friction", [0.003, FRICTION])
def test_a_body_that_friction_slows_down_is_counted_at_both_stops(
    friction: float, sign: int
) -> None:
    place, impacts = rolling(7.5, 600.0, friction, 0.88)

    found = seen_impacts(alone(sign * noisy(place, SHARP_PX)))

    assert_found(found, impacts)
    assert found.probability[len(impacts)] > 0.9


def test_the_sum_of_certain_events_is_their_number() -> None:
    assert chances_of_sum([1.0, 1.0, 1.0]) == {3: 1.0}


def test_the_sum_of_two_even_chances_is_binomial() -> None:
    assert chances_of_sum([0.5, 0.5]) == pytest.approx({0: 0.25, 1: 0.5, 2: 0.25})


BLOW, REST = 20.3, 40.0
"""Frame at which a ball at rest is struck, and its place in px."""


def struck(over_frames: float) -> Floats:
    """Places of a body at rest that gets 6 px a frame within so many, between two stops."""
    since = np.arange(180.0) - BLOW
    led = np.clip(since, 0.0, over_frames) ** 2 / (2 * max(over_frames, 1e-9))
    way = REST + 6.0 * (led + np.maximum(since - over_frames, 0.0))
    return np.asarray(210.0 - np.abs(way % 420.0 - 210.0))


def test_a_body_that_something_strikes_at_rest_is_not_counted_alone() -> None:
    found = seen_impacts(alone(noisy(struck(0.0), NOISE_PX)))

    assert [reason.cause for reason in found.shortcomings] == [Cause.STRUCK]
    assert found.shortcomings[0].figures == (pytest.approx(BLOW, abs=0.5),)


@pytest.mark.parametrize(("kept", "counted"), [(0.95, True), (1.3, False)])
def test_what_gives_a_body_speed_is_no_stop_at_rest(kept: float, counted: bool) -> None:
    place, velocity, path = 100.0, -2.0, []
    for step in range(160 * 50):
        if step % 50 == 0:
            path.append(place)
        place += velocity / 50
        if place < 0.0 or place > 150.0:
            place = min(max(place, 0.0), 150.0)
            velocity *= -0.95 if place == 0.0 else -kept
    found = seen_impacts(alone(noisy(np.array(path), NOISE_PX)))

    assert [reason.cause for reason in found.shortcomings] == (
        [] if counted else [Cause.STRUCK_MOVING]
    )


@pytest.mark.parametrize("over_frames", [12.0, 24.0])
def test_a_body_that_a_hand_pushes_off_is_counted(over_frames: float) -> None:
    assert counts(seen_impacts(alone(noisy(struck(over_frames), NOISE_PX))))


@pytest.mark.parametrize("held", [30.37, 30.5, 30.63, 30.87])
def test_a_ball_that_is_let_go_between_two_frames_is_not_struck(held: float) -> None:
    # At PULL a start that is wrong by an eighth of a frame looks like a blow of 0.1 px a frame.
    flights, drop = np.array(DYING), 20.3
    impacts = held + np.cumsum([drop, *flights])
    frame = np.arange(int(impacts[-1]), dtype=float)
    height = PULL / 2 * (drop**2 - np.maximum(frame - held, 0.0) ** 2)
    for begin, flight in zip(impacts, flights, strict=False):
        since = frame - begin
        inside = (since >= 0) & (since < flight)
        height[inside] = PULL / 2 * since[inside] * (flight - since[inside])

    assert counts(seen_impacts(alone(noisy(300.0 - height, SHARP_PX))))


def test_the_logarithm_of_the_normal_distribution_is_that_of_scipy_far_out_too() -> None:
    x = np.array([-1e3, -50.0, -36.1, -35.9, -5.0, 0.0, 3.0, 40.0])

    assert _log_normal(x) == pytest.approx(log_ndtr(x), abs=1e-3)


@pytest.mark.parametrize(("share", "bounces"), [(0.1, False), (0.5, True)])
def test_what_moves_by_little_of_its_size_does_not_bounce(share: float, bounces: bool) -> None:
    place, impacts = between_stops(0.05 * share * SIZE_PX, share * SIZE_PX, 200)
    found = seen_impacts(alone(noisy(place, 0.002 * SIZE_PX * share)))
    assert found.burst == len(impacts)
    assert [reason.cause for reason in found.shortcomings] == ([] if bounces else [Cause.SWAYS])

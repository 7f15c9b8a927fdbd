"""Smooth motions are never counted; impacts of the same speeds and sampling are."""

from __future__ import annotations

import numpy as np
import pytest
from free_paths import SIZE_PX, alone, between_stops, bouncing, noisy, pair
from hypothesis import given, settings
from hypothesis import strategies as st

from count_video.motion.corners import weigh
from count_video.motion.errors_of_places import HALF_EXPOSURE
from count_video.motion.flight import motion_of
from count_video.motion.impacts import find_turns
from count_video.motion.meeting import seen_impacts
from count_video.reasons import Cause
from count_video.records import Floats

NOISE_PX = 0.2
PICTURES = 160
SURE = 0.9
SURE_LOG_ODDS = 7.0
"""A probability of 0.999."""
FLIGHT = 4.2
"""Pictures from one corner to the next, amid a long rest."""
TIME_WITHIN = 0.1
"""Pictures, of a body that moves by 3 px in each, the place of which is known to 0.1 px."""

REST = 4000
"""Pictures of rest before a motion: seconds at a high rate."""
SPEED_WITHIN = 0.1
"""Share of a measured speed: the slowest pictures of a motion are taken for rest, or not."""

PERIOD = 60.0
"""Pictures, of two balls on threads."""

seeds = st.integers(0, 999)
phases = st.floats(0.0, 6.28)
reaches = st.floats(10.0, 200.0)
any_sampling = st.floats(7.0, 140.0)
"""Pictures a period: from hardly resolved to far more than a side's window holds."""


def swing(period: float, phase: float, reach: float, damping: float = 0.0) -> Floats:
    frame = np.arange(PICTURES)
    return reach * np.exp(-damping * frame) * np.cos(2 * np.pi * frame / period + phase)


def counted(place: Floats) -> bool:
    return not seen_impacts(alone(place)).shortcomings


@given(any_sampling, phases, reaches, seeds)
@settings(max_examples=40)
def test_a_swing_is_never_counted_however_few_pictures_show_it(
    period: float, phase: float, reach: float, seed: int
) -> None:
    assert not counted(noisy(swing(period, phase, reach), NOISE_PX, seed))


@given(any_sampling, phases, reaches, st.floats(0.0, 0.01), seeds)
@settings(max_examples=30)
def test_a_damped_swing_is_never_counted(
    period: float, phase: float, reach: float, damping: float, seed: int
) -> None:
    assert not counted(noisy(swing(period, phase, reach, damping), NOISE_PX, seed))


@given(any_sampling, phases, reaches, st.sampled_from([0.5, 1.0]))
@settings(max_examples=30)
def test_a_swing_in_whole_px_is_never_counted(
    period: float, phase: float, reach: float, grain: float
) -> None:
    assert not counted(np.round(swing(period, phase, reach) / grain) * grain)


@given(st.floats(0.2, 1.5), st.floats(12.0, 140.0), reaches, seeds)
@settings(max_examples=20)
def test_a_metronome_is_never_counted(angle: float, period: float, reach: float, seed: int) -> None:
    arm = reach * np.sin(angle * np.cos(2 * np.pi * np.arange(PICTURES) / period))

    assert not counted(noisy(arm, NOISE_PX, seed))


@given(st.floats(8.0, 40.0), st.floats(60.0, 300.0), seeds)
@settings(max_examples=25)
def test_bounces_between_stops_are_counted_at_the_sampling_of_swings(
    flight: float, width: float, seed: int
) -> None:
    place, impacts = between_stops(width / flight, width, int(6.5 * flight))
    found = seen_impacts(alone(noisy(place, NOISE_PX, seed)))

    # An impact in the clip's last pictures shows no turn: it may be missed, with its doubt.
    number = len(found.collisions)
    assert not found.shortcomings
    assert number == len(impacts) or found.probability[number] < SURE


@pytest.mark.parametrize("kept", [0.6, 0.75, 0.9])
def test_bounces_that_lose_much_are_impacts(kept: float) -> None:
    flights = [36.0, 36.0 * kept, 36.0 * kept**2, 36.0 * kept**3]
    place, impacts = bouncing(flights, 0.6, drop=18.0 / kept)

    found = seen_impacts(alone(noisy(place, NOISE_PX)))

    assert not found.shortcomings
    assert len(found.collisions) == len(impacts)


@given(st.floats(0.3, 1.0), st.floats(19.6, 20.4))
def test_a_corner_of_straight_flights_is_an_impact_at_its_time(kept: float, time: float) -> None:
    frame = np.arange(41, dtype=np.float64)
    place = np.where(frame < time, 3.0, -3.0 * kept) * (time - frame)
    motion = motion_of(frame, place)
    (turn,) = find_turns(motion)

    corner = weigh(motion, turn, (-np.inf, np.inf), 20.0, HALF_EXPOSURE)

    assert corner.log_odds > SURE_LOG_ODDS
    assert corner.frame == pytest.approx(time, abs=TIME_WITHIN)


@given(st.floats(-0.5, 0.5), st.floats(1.5, 6.0), seeds)
@settings(max_examples=20)
def test_a_corner_amid_a_long_rest_is_an_impact(phase: float, speed: float, seed: int) -> None:
    """A ball between a wall and a body like it: it moves in a few pictures of the clip alone."""
    time = np.arange(-100.0, 101.0) + phase
    place = noisy(speed * np.minimum(np.abs(time), FLIGHT), 0.02, seed)
    motion = motion_of(time, place, 0.05)
    (turn,) = find_turns(motion)

    corner = weigh(motion, turn, (-FLIGHT, FLIGHT), 2 * FLIGHT, HALF_EXPOSURE)

    assert corner.likely
    assert corner.frame == pytest.approx(0.0, abs=TIME_WITHIN)


@given(st.floats(20.0, 80.0), seeds)
@settings(max_examples=20)
def test_rest_before_a_motion_changes_no_speed(period: float, seed: int) -> None:
    path = swing(period, 0.0, 60.0)
    place = noisy(np.append(np.full(REST, path[0]), path), 0.1, seed)
    frame = np.arange(len(place), dtype=np.float64)

    rests, moves = motion_of(frame, place), motion_of(frame[REST:], place[REST:])

    assert rests.speed == pytest.approx(moves.speed, rel=SPEED_WITHIN)


def test_two_bodies_that_are_not_of_a_kind_lack_their_wall() -> None:
    time = np.arange(-30, 30) + 0.4
    ball = np.where(time < 0, 0.0, 3.0) * time
    heavy = np.where(time < 0, 1.6, 1.45) * time - 40.0

    found = seen_impacts(pair(noisy(heavy, 0.05), noisy(ball, 0.05, 1)))

    assert any(reason.cause is Cause.UNLIKE for reason in found.shortcomings)


@given(st.floats(1.7, 4.0), st.floats(0.6, 0.95), st.integers(2, 4), seeds)
@settings(max_examples=10)
def test_bodies_of_unlike_masses_that_meet_again_and_again_lack_no_wall(
    ratio: float, restitution: float, meetings: int, seed: int
) -> None:
    """Two balls on threads meet where they hang; the first comes from the left."""
    rate, time = 2 * np.pi / PERIOD, np.arange(-PERIOD / 4, (meetings - 0.75) * PERIOD / 2) + 0.3
    velocity = np.array([6.0, 0.0])
    paths = velocity[:, None] / rate * np.sin(rate * time)
    for meeting in range(meetings):
        common = (ratio * velocity[0] + velocity[1]) / (1 + ratio)
        impulse = restitution * (velocity[0] - velocity[1]) / (1 + ratio)
        velocity = np.array([common - impulse, common + ratio * impulse])
        since = time - meeting * PERIOD / 2
        swung = velocity[:, None] / rate * np.sin(rate * since)
        paths = np.where(since >= 0, swung, paths)
        velocity = -velocity  # half a swing later
    left, right = paths + np.array([[0.0], [SIZE_PX]])
    found = seen_impacts(pair(noisy(left, 0.05, seed), noisy(right, 0.05, seed + 1)))
    assert not found.shortcomings
    assert found.burst == meetings


def test_a_clip_that_is_cut_off_at_the_stop_leaves_a_doubt() -> None:
    place, impacts = between_stops(6.0, 180.0, 200)
    cut = int(impacts[-1]) + 2

    found = seen_impacts(alone(noisy(place[:cut], NOISE_PX)))

    number = len(found.collisions)
    assert number == len(impacts) or found.probability[number] < SURE

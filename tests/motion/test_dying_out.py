"""Bounces get lower and lower: those that pictures show are counted, the endless tail is not."""

from dataclasses import replace

import numpy as np
import pytest
from free_paths import alone, bouncing, noisy

from count_video.motion.corners import Impact
from count_video.motion.flight import HYSTERESIS_SIGMAS, Motion
from count_video.motion.meeting import seen_impacts
from count_video.motion.weighing import TAIL_PICTURES, dies_out
from count_video.reasons import Cause

FALLING = Motion(np.arange(2.0), np.zeros(2), 0.5, 0.01, 0.01)
"""A body that falls, seen with hardly any noise."""


def _impacts(frames: np.ndarray) -> list[Impact]:
    """Impacts on one stop at these frames."""
    return [
        Impact(1, 50.0, np.zeros(1), float(frame), 0.0, 5.0, -4.0, 4, chance=0.99)
        for frame in frames
    ]


def _series(first: float, share: float, number: int) -> np.ndarray:
    """Frames of impacts whose flights form a geometric series."""
    return np.concatenate([[0.0], np.cumsum(first * share ** np.arange(number - 1))])


def test_a_geometric_series_down_to_few_pictures_dies_out() -> None:
    assert dies_out(FALLING, _impacts(_series(20.0, 0.8, 9)))


def test_flights_that_are_still_long_do_not() -> None:
    """Of a body that is lost while it bounces high, impacts are missing."""
    assert not dies_out(FALLING, _impacts(_series(20.0, 0.8, 4)))


def test_with_noise_bounces_are_lost_that_are_lower() -> None:
    loud = replace(FALLING, sigma_px=1.0)  # turns show from flights of 10 pictures on
    assert dies_out(loud, _impacts(_series(20.0, 0.8, 5)))
    assert not dies_out(replace(loud, acceleration_spread=1.0), _impacts(_series(20.0, 0.8, 5)))


def test_nor_do_equal_flights() -> None:
    assert not dies_out(FALLING, _impacts(3.0 * np.arange(8)))


def test_a_last_impact_at_a_wrong_time_does_not_make_a_series_die_out() -> None:
    frames = _series(40.0, 0.8, 6)
    frames[-1] -= 13.0
    assert not dies_out(FALLING, _impacts(frames))


REST_FRAMES = 30
SHORTEST = 1.0
"""Shorter flights, in pictures, are within one exposure."""


@pytest.mark.parametrize("noise_px", [0.1, 0.5])
@pytest.mark.parametrize("share", [0.76, 0.8, 0.84])
@pytest.mark.parametrize("first", [24.0, 50.0])
def test_a_ball_that_bounces_until_it_rests_is_counted_down_to_what_pictures_show(
    first: float, share: float, noise_px: float
) -> None:
    flights = first * share ** np.arange(60)
    pull = 1600.0 / first**2  # the first flight rises by 200 px
    place, _ = bouncing(flights.tolist(), pull, first / 2)
    place = np.concatenate([place, np.full(REST_FRAMES, 300.0)])

    found = seen_impacts(alone(noisy(place, noise_px)))

    assert not found.shortcomings
    assert Cause.DIES_OUT in [doubt.cause for doubt in found.doubts]
    # The last flights are lower than turns must be deep in the noise.
    lost = np.sqrt(8 * 2 * HYSTERESIS_SIGMAS * noise_px / pull)
    certain = 1 + sum(flights > max(TAIL_PICTURES, lost))
    assert certain - 1 <= len(found.collisions) <= 1 + sum(flights > SHORTEST)

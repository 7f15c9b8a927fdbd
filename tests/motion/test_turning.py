from __future__ import annotations

import numpy as np
import pytest
from made_collisions import collision

from count_video.motion.burst import find_burst
from count_video.motion.gaps import Gaps
from count_video.motion.swing import Swing
from count_video.motion.turning import Turning, first_turn
from count_video.records import Floats

FLIGHT = (20.0, 70.0)
DECELERATION = 0.02
"""px per frame squared: a pendulum's, slow beside a camera."""
NOISE_PX = 0.02
"""A bent fit over 50 frames, and errors that last, leave 0.015 px per frame open at its end."""
RATE = 0.02
"""Radians per frame; the swing's centre then lies 50 px nearer than its turn."""
RATE_SIGMA = 0.01
"""Of the rate squared, as a share."""


def told(frames: float, seed: int = 0) -> Turning:
    """What is said of a heavy body that turns so many frames before the ball strikes it."""
    frame = np.arange(100.0)
    reach = DECELERATION / RATE**2
    heavy = 150.0 + reach * np.cos(RATE * (frame - FLIGHT[1] + frames))
    heavy = np.where(frame > FLIGHT[1], 200.0 + 0.5 * (frame - FLIGHT[1]), heavy)
    heavy += np.random.default_rng(seed).normal(0.0, NOISE_PX, len(frame))
    swing = Swing(100.0, 0.01, RATE**2, RATE_SIGMA * RATE**2, 150.0)
    hits = [collision("bodies", at) for at in FLIGHT]
    return first_turn(hits, gaps_of(frame, heavy), swing)


def gaps_of(frame: Floats, heavy: Floats) -> Gaps:
    sigma = np.full(len(frame), NOISE_PX)
    return Gaps(frame, heavy - 50.0, heavy, np.full(len(frame), 30.0), sigma, sigma, 1)


@pytest.mark.parametrize("seed", range(5))
def test_a_turn_before_the_contact_ends_the_burst_there(seed: int) -> None:
    assert told(8.0, seed) == Turning(FLIGHT[1], np.inf, 1.0)


@pytest.mark.parametrize("seed", range(5))
def test_a_turn_at_the_very_contact_is_open(seed: int) -> None:
    turning = told(0.0, seed)

    assert (turning.before, turning.open_before) == (np.inf, FLIGHT[1])
    assert 0.02 < turning.chance < 0.98


@pytest.mark.parametrize(("frames", "likely"), [(2.5, False), (-2.5, True)])
def test_the_velocity_at_the_contact_tells_the_likelier_of_both(
    frames: float, likely: bool
) -> None:
    """A velocity of 0.05 px per frame: three standard uncertainties."""
    turning = told(frames)

    assert turning.open_before == FLIGHT[1]
    assert (turning.chance > 0.9) if likely else (turning.chance < 0.1)


@pytest.mark.parametrize("seed", range(5))
def test_a_body_that_still_moves_away_has_not_turned(seed: int) -> None:
    assert told(-15.0, seed) == Turning(np.inf, np.inf, 1.0)


def test_flights_too_short_to_show_a_bend_tell_no_turn() -> None:
    frame = np.arange(40.0)
    heavy = 200.0 + 0.3 * np.abs(frame - 20.0)
    hits = [collision("wall", at) for at in (16.0, 23.0)]

    assert first_turn(hits, gaps_of(frame, heavy), None) == Turning(np.inf, np.inf, 1.0)


def test_a_burst_without_an_open_turn_has_no_rival() -> None:
    frame = np.arange(60.0)
    heavy = np.where(frame < 20, 90.0 - frame, 70.0 + 0.8 * (frame - 20))
    ball = np.where(frame < 20, 40.0, np.maximum(40.0 - (frame - 20), 20.0 + 0.0 * frame))
    sigma = np.full(60, NOISE_PX)
    gaps = Gaps(frame, heavy - ball, heavy, ball, sigma, sigma, 1)

    burst = find_burst([collision("bodies", 20.0)], gaps, None)

    assert burst.rival is None

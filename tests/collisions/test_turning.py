from __future__ import annotations

import numpy as np
import pytest

from count_video.collisions.candidates import Candidate
from count_video.collisions.gaps import Gaps
from count_video.collisions.turning import first_turn

FLIGHT = (20.0, 70.0)
DECELERATION = 0.02
"""px per frame squared: a pendulum's, slow beside a camera."""
NOISE_PX = 0.02
"""A bent fit over 24 frames knows the velocity at its end to 0.012 px per frame then."""


def turned_before_contact(frames: float, seed: int = 0) -> tuple[float, float]:
    """What is said of a heavy body that turns so many frames before the ball strikes it."""
    frame = np.arange(100.0)
    top = FLIGHT[1] - frames
    heavy = 200.0 - DECELERATION / 2 * (frame - top) ** 2
    heavy = np.where(frame > FLIGHT[1], 200.0 + 0.5 * (frame - FLIGHT[1]), heavy)
    heavy += np.random.default_rng(seed).normal(0.0, NOISE_PX, len(frame))
    sigma = np.full(len(frame), NOISE_PX)
    gaps = Gaps(frame, heavy - 50.0, heavy, np.full(len(frame), 30.0), sigma, sigma, 1)
    hits = [Candidate("bodies", at, at, 0.1, None) for at in FLIGHT]
    return first_turn(hits, gaps)


@pytest.mark.parametrize("seed", range(5))
def test_a_turn_before_the_contact_ends_the_burst_there(seed: int) -> None:
    assert turned_before_contact(8.0, seed) == (FLIGHT[1], np.inf)


@pytest.mark.parametrize("seed", range(5))
def test_a_turn_at_the_very_contact_is_open(seed: int) -> None:
    turned, doubtful = turned_before_contact(0.0, seed)

    assert (turned, doubtful) == (np.inf, FLIGHT[1])


@pytest.mark.parametrize("seed", range(5))
def test_a_body_that_still_moves_away_has_not_turned(seed: int) -> None:
    assert turned_before_contact(-15.0, seed) == (np.inf, np.inf)


def test_flights_too_short_to_show_a_bend_tell_no_turn() -> None:
    frame = np.arange(40.0)
    sigma = np.full(40, NOISE_PX)
    heavy = 200.0 + 0.3 * np.abs(frame - 20.0)
    gaps = Gaps(frame, heavy - 50.0, heavy, np.full(40, 30.0), sigma, sigma, 1)
    hits = [Candidate("wall", at, at, 0.1, None) for at in (16.0, 23.0)]

    assert first_turn(hits, gaps) == (np.inf, np.inf)

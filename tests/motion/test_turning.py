from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_collisions import collision

from count_video.motion.batches import fit_contacts
from count_video.motion.burst import Turning, find_burst, first_turn
from count_video.motion.gaps import Gaps
from count_video.motion.joint import Contacts, Motion
from count_video.motion.model import Paths
from count_video.records import Floats

FLIGHT = (20.0, 70.0)
DECELERATION = 0.02
"""px per frame squared: a pendulum's, slow beside a camera."""
NOISE_PX = 0.02
"""A bent fit over 50 frames, and errors that last, leave 0.015 px per frame open at its end."""
CONTACT_PX = 50.0
TIME_FRAMES = 0.3
"""The ball comes and goes by 1 px per frame: five standard uncertainties of a contact."""
RATE = 0.02
"""Radians per frame; the swing's centre then lies 50 px nearer than its turn."""


def stated(frames: float, seed: int = 0) -> Turning:
    """What is said of a heavy body that turns so many frames before the ball strikes it."""
    frame = np.arange(100.0)
    since, until = np.minimum(frame - FLIGHT[0], 0.0), np.maximum(frame - FLIGHT[1], 0.0)
    phase = RATE * (np.clip(frame, *FLIGHT) - FLIGHT[1] + frames)
    heavy = 150.0 + DECELERATION / RATE**2 * np.cos(phase) - 0.5 * since + 0.5 * until
    heavy += np.random.default_rng(seed).normal(0.0, NOISE_PX, len(frame))
    return first_turn(fitted(frame, heavy))


def fitted(frame: Floats, heavy: Floats) -> Contacts:
    """Fit contacts at both ends of the flight, of a ball that comes near and goes away."""
    away = np.abs((frame - FLIGHT[0]) * (frame - FLIGHT[1])) / np.ptp(FLIGHT)
    ball = heavy - CONTACT_PX - away
    return fit_contacts(Paths(frame, ball, heavy), ["bodies"] * 2, FLIGHT)


@pytest.mark.parametrize("seed", range(5))
def test_a_turn_before_the_contact_ends_the_burst_there(seed: int) -> None:
    turning = stated(12.0, seed)

    assert turning.before == pytest.approx(FLIGHT[1], abs=TIME_FRAMES)
    assert (turning.open_before, turning.chance) == (np.inf, 1.0)


@pytest.mark.parametrize("seed", range(5))
def test_a_turn_at_the_very_contact_is_open(seed: int) -> None:
    turning = stated(0.0, seed)

    assert turning.before == np.inf
    assert turning.open_before == pytest.approx(FLIGHT[1], abs=TIME_FRAMES)
    assert 0.02 < turning.chance < 0.98


@pytest.mark.parametrize(("frames", "likely"), [(5.0, False), (-5.0, True)])
def test_the_velocity_at_the_contact_shows_the_likelier_of_both(
    frames: float, likely: bool
) -> None:
    """A velocity of 0.1 px per frame: two standard uncertainties of one flight alone."""
    turning = stated(frames)

    assert turning.open_before == pytest.approx(FLIGHT[1], abs=TIME_FRAMES)
    assert (turning.chance > 0.9) if likely else (turning.chance < 0.1)


@pytest.mark.parametrize("seed", range(5))
def test_a_body_that_still_moves_away_has_not_turned(seed: int) -> None:
    assert stated(-15.0, seed) == Turning(np.inf, np.inf, 1.0)


def test_a_velocity_that_is_not_shown_gives_no_turn() -> None:
    nothing = np.full((2, 2), np.nan)
    unseen = Motion(nothing, nothing, np.full(2, np.nan), np.zeros((2, 2)))
    contacts = fitted(np.arange(100.0), 200.0 + np.zeros(100))

    assert first_turn(replace(contacts, bodies=(unseen, unseen))) == Turning(np.inf, np.inf, 1.0)


def test_a_burst_without_an_open_turn_has_no_rival() -> None:
    frame = np.arange(60.0)
    heavy = np.where(frame < 20, 90.0 - frame, 70.0 + 0.8 * (frame - 20))
    ball = np.where(frame < 20, 40.0, np.maximum(40.0 - (frame - 20), 20.0 + 0.0 * frame))
    sigma = np.full(60, NOISE_PX)
    gaps = Gaps(frame, heavy - ball, heavy, ball, sigma, sigma, 1)
    contacts = fit_contacts(Paths(frame, ball, heavy), ["bodies"], [20.0])

    burst = find_burst([collision("bodies", 20.0)], contacts, gaps, None)

    assert burst.rival is None

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from count_video.motion.burst import turned_before
from count_video.motion.contacts import Contacts, Paths, fit_contacts
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


def stated(frames: float, seed: int = 0) -> float:
    """When a heavy body that turns so many frames before the ball strikes it is said to turn."""
    frame = np.arange(100.0)
    since, until = np.minimum(frame - FLIGHT[0], 0.0), np.maximum(frame - FLIGHT[1], 0.0)
    phase = RATE * (np.clip(frame, *FLIGHT) - FLIGHT[1] + frames)
    heavy = 150.0 + DECELERATION / RATE**2 * np.cos(phase) - 0.5 * since + 0.5 * until
    heavy += np.random.default_rng(seed).normal(0.0, NOISE_PX, len(frame))
    return turned_before(fitted(frame, heavy))


def fitted(frame: Floats, heavy: Floats) -> Contacts:
    """Fit contacts at both ends of the flight, of a ball that comes near and goes away."""
    away = np.abs((frame - FLIGHT[0]) * (frame - FLIGHT[1])) / np.ptp(FLIGHT)
    ball = heavy - CONTACT_PX - away
    return fit_contacts(Paths(frame, ball, heavy), ["bodies"] * 2, FLIGHT)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("frames", [12.0, 5.0])
def test_a_turn_before_the_contact_ends_the_burst_there(frames: float, seed: int) -> None:
    assert stated(frames, seed) == pytest.approx(FLIGHT[1], abs=TIME_FRAMES)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("frames", [-15.0, -5.0])
def test_a_body_that_still_moves_away_has_not_turned(frames: float, seed: int) -> None:
    assert stated(frames, seed) == np.inf


def test_a_velocity_that_is_not_shown_gives_no_turn() -> None:
    unseen = np.full((2, 2, 2), np.nan)
    contacts = fitted(np.arange(100.0), 200.0 + np.zeros(100))

    assert turned_before(replace(contacts, rate=unseen, rate_sigma=unseen)) == np.inf

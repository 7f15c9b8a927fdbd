from __future__ import annotations

import numpy as np
import pytest

from count_video.motion.contacts import Contacts, fit_contacts
from count_video.records import Floats

FRAMES = 241
EVERY = 24.0
"""Frames between bounces; the first is at frame 12.3."""
FIRST = 12.3
BOUNCES = FIRST + EVERY * np.arange(10)
SPEED = 1.0
ERROR_PX = 0.1
TRIALS = 12
TRUTHFUL = (0.75, 1.35)
"""RMS of normalised errors: 120 bounces know it to 7 %, and how long errors last is known to a
factor of two, which is worth a quarter."""
MOST_SIGMAS = 5.0
"""No error in a million is larger."""


def bouncing() -> Floats:
    """Places of a ball that bounces at a wall at 50 px under a steady pull."""
    phase = (np.arange(float(FRAMES)) - FIRST) % EVERY
    return 50.0 + 2 * SPEED / EVERY * phase * (EVERY - phase)


def errors(seed: int, lasts: float) -> Floats:
    rng = np.random.default_rng(seed)
    kept = np.exp(-1.0 / lasts) if lasts else 0.0
    error = np.empty(FRAMES)
    error[0] = rng.normal()
    for row in range(1, FRAMES):
        error[row] = kept * error[row - 1] + np.sqrt(1 - kept**2) * rng.normal()
    return ERROR_PX * error


def fitted(ball: Floats) -> Contacts:
    frame = np.arange(float(len(ball)))
    return fit_contacts(frame, [ball], [(at, "wall") for at in BOUNCES.round().tolist()])


def times(found: Contacts) -> Floats:
    """Frame coordinates and their uncertainties, shape (2, contacts)."""
    return np.transpose([(one.frame, one.frame_sigma) for one in found.collisions])


def velocities(found: Contacts) -> Floats:
    """Velocities before and after and their uncertainties, shape (2, contacts, 2)."""
    pairs = [(one.velocity_before, one.velocity_after) for one in found.collisions]
    names = "ball_px_frame", "ball_sigma_px_frame"
    return np.array([[[getattr(one, name) for one in pair] for pair in pairs] for name in names])


def rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("lasts", [0.0, 3.0, 6.0])
def test_times_err_as_much_as_is_said_however_long_errors_last(lasts: float) -> None:
    found = [times(fitted(bouncing() + errors(seed, lasts))) for seed in range(TRIALS)]

    standardised = np.array([(frame - BOUNCES) / sigma for frame, sigma in found])
    assert TRUTHFUL[0] <= rms(standardised) <= TRUTHFUL[1]


def test_velocities_err_as_much_as_is_said() -> None:
    true = np.tile([-2 * SPEED, 2 * SPEED], (len(BOUNCES), 1))
    found = [velocities(fitted(bouncing() + errors(seed, 0.0))) for seed in range(TRIALS)]

    standardised = np.array([(rate - true) / sigma for rate, sigma in found])
    assert TRUTHFUL[0] <= rms(standardised) <= TRUTHFUL[1]


def test_contacts_share_a_place_which_is_known_better_than_any_frame() -> None:
    found = fitted(bouncing() + errors(1, 0.0))

    place_px = np.array([one.position_px for one in found.collisions])
    assert np.ptp(place_px) < ERROR_PX
    assert np.abs(place_px - 50.0).max() < ERROR_PX


def test_frames_that_mislead_the_tracker_do_not_bend_the_fit() -> None:
    ball = bouncing() + errors(2, 0.0)
    ball[[60, 100, 150]] += 30.0

    frame, sigma = times(fitted(ball))

    assert np.all(np.abs(frame - BOUNCES) < MOST_SIGMAS * sigma)


def test_a_contact_in_frames_that_show_nothing_is_known_from_the_others() -> None:
    ball = bouncing() + errors(3, 0.0)
    hidden = np.abs(np.arange(FRAMES) - BOUNCES[4]) < 4
    ball[hidden] = np.nan

    frame, sigma = times(fitted(ball))

    assert sigma[4] > sigma[3]
    assert np.all(np.abs(frame - BOUNCES) < MOST_SIGMAS * sigma)


def test_without_contacts_nothing_is_found() -> None:
    found = fit_contacts(np.arange(float(FRAMES)), [bouncing()], [])

    assert not found.collisions

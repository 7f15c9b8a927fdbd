"""Times of contacts that are not those of a ball between a heavy body and a wall."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple

import numpy as np
import pytest

from count_video.motion.contacts import Contacts, Kind, fit_contacts
from count_video.records import Floats

NOISE_PX = 0.1
TRIALS = 40
TRUTHFUL = (0.75, 1.35)
"""RMS of normalised errors: 80 times and more know it to a tenth, the noise to another."""
FRAME = np.arange(120.0)


def rms(errors: Floats) -> float:
    return float(np.sqrt(np.mean(errors**2)))


def noise(seed: int) -> Floats:
    return np.random.default_rng(seed).normal(0.0, NOISE_PX, len(FRAME))


def between_two_stops(seed: int) -> tuple[Contacts, Floats]:
    """A cart that runs to and fro at an even speed, with the true times of its stops."""
    true = np.array([20.4, 50.4, 80.4, 110.4])
    place = np.interp(FRAME, [-9.6, *true, 140.4], [100.0, 0.0, 100.0, 0.0, 100.0, 0.0])
    kinds: list[Kind] = ["wall", "far", "wall", "far"]
    rough = list(zip(true.round().tolist(), kinds, strict=True))
    return fit_contacts(FRAME, [place + noise(seed)], rough), true


def meeting_once(seed: int) -> tuple[Contacts, Floats]:
    """Two like bodies of which one hits the other at rest."""
    left = np.where(FRAME < 60.3, FRAME, 60.3)
    right = np.where(FRAME < 60.3, 80.0, 80.0 + FRAME - 60.3)
    places = left + noise(seed), right + noise(seed + TRIALS)
    return fit_contacts(FRAME, places, [(60.0, "bodies")]), np.array([60.3])


@pytest.mark.parametrize("scene", [between_two_stops, meeting_once])
def test_times_err_as_much_as_is_said(
    scene: Callable[[int], tuple[Contacts, Floats]],
) -> None:
    errors = []
    for seed in range(TRIALS):
        found, true = scene(seed)
        frame, sigma = np.transpose([(one.frame, one.frame_sigma) for one in found.collisions])
        errors.append((frame - true) / sigma)

    assert TRUTHFUL[0] <= rms(np.concatenate(errors)) <= TRUTHFUL[1]


def test_the_distance_at_the_contact_of_two_bodies_is_measured() -> None:
    found, _ = meeting_once(3)

    assert found.distance_px == pytest.approx(80.0 - 60.3, abs=5 * NOISE_PX)


def test_what_one_body_loses_at_a_contact_the_other_gains() -> None:
    found, _ = meeting_once(5)

    before, after = found.collisions[0].velocity_before, found.collisions[0].velocity_after
    *jumps, _, _ = np.subtract(astuple(after), astuple(before))
    unsure = np.linalg.norm([astuple(one)[2:] for one in (before, after)])
    assert np.abs(jumps[0] + jumps[1]) < 5 * unsure


def test_frames_that_show_a_soft_contact_take_no_part() -> None:
    """A bumper that is pressed for six frames: times are those of the flights' crossing."""
    sharp = 50.0 - np.abs(FRAME - 60.2)
    soft = np.where(np.abs(FRAME - 60.2) < 3, 47.0 + (9 - (FRAME - 60.2) ** 2) / 6, sharp)

    found = fit_contacts(FRAME, [soft + noise(7)], [(60.0, "far")], touching=3.5)

    (contact,) = found.collisions
    assert contact.frame == pytest.approx(60.2, abs=5 * contact.frame_sigma)
    assert contact.position_px == pytest.approx(50.0, abs=5 * NOISE_PX)

from __future__ import annotations

import numpy as np
import pytest

from count_video.motion.errors_of_places import LASTS_FRAMES, Errors, Flight, errors_of
from count_video.records import Floats

SIGMA_PX = 0.05
FLIGHTS = 12
FRAMES = 40
TRIALS = 8
KNOWN_TO = 0.15
"""Errors that last for 8 frames are independent after twice that: twelve flights hold 30 of them,
eight trials 240, which know a standard deviation to 5 %. How long they last is not known."""


def errors(rng: np.random.Generator, lasts: float, white: float) -> Floats:
    """White errors and such that last, in one flight."""
    kept = np.exp(-1.0 / lasts)
    lasting = np.empty(FRAMES)
    lasting[0] = rng.normal()
    for frame in range(1, FRAMES):
        lasting[frame] = kept * lasting[frame - 1] + np.sqrt(1 - kept**2) * rng.normal()
    both = np.sqrt(white) * rng.normal(size=FRAMES) + np.sqrt(1 - white) * lasting
    return np.asarray(SIGMA_PX * both)


def error_sigma(flights: list[Flight]) -> float:
    errors = errors_of(flights)
    assert errors is not None
    return errors.sigma_px


def flight(error: Floats, start_px: float, speed: float) -> Flight:
    """A parabola with the same acceleration in all flights."""
    clock = np.arange(float(len(error)))
    own = np.column_stack([np.ones_like(clock), clock])
    place = start_px + speed * clock + 0.01 * clock**2 + error
    return Flight(clock, own, np.column_stack([clock**2]), place)


def trial(seed: int, lasts: float, white: float) -> list[Flight]:
    rng = np.random.default_rng(seed)
    return [flight(errors(rng, lasts, white), *rng.uniform(-5, 5, size=2)) for _ in range(FLIGHTS)]


@pytest.mark.parametrize("lasts", [1.0, 3.0, 8.0])
@pytest.mark.parametrize("white", [0.0, 0.3, 1.0])
def test_errors_are_measured_whole_however_long_they_last(lasts: float, white: float) -> None:
    found = [error_sigma(trial(seed, lasts, white)) for seed in range(TRIALS)]

    assert np.mean(found) == pytest.approx(SIGMA_PX, rel=KNOWN_TO)


def test_a_law_that_flights_share_twice_is_taken_once() -> None:
    once = trial(0, 2.0, 0.5)
    twice = [Flight(f.clock, f.own, np.hstack([f.shared, 3 * f.shared]), f.place_px) for f in once]

    assert error_sigma(twice) == pytest.approx(error_sigma(once), rel=1e-6)


def test_too_little_freedom_gives_no_errors() -> None:
    assert errors_of([]) is None
    assert errors_of([flight(np.zeros(6), 0.0, 1.0)]) is None


def test_errors_vary_together_by_what_lasts_of_them() -> None:
    errors = Errors(0.5, np.array([2.0, 0.0, 0.0, 0.0]))
    half = np.exp(-1.0 / LASTS_FRAMES[0])

    covariance = errors.covariance_of(np.array([0.0, 1.0]))

    assert errors.sigma_px == pytest.approx(np.sqrt(2.5))
    assert covariance == pytest.approx(np.array([[2.5, 2.0 * half], [2.0 * half, 2.5]]))

from __future__ import annotations

import numpy as np
import pytest

from count_video.collisions.candidates import find_candidates, sharpen
from count_video.collisions.gaps import Gaps
from count_video.collisions.timing import with_true_sigmas
from count_video.records import Floats

FRAMES = 241
EVERY = 24.0
"""Frames between bounces; the first is at frame 12.3."""
FIRST = 12.3
SPEED = 1.0
ERROR_PX = 0.1
TRIALS = 12
TRUTHFUL = (0.75, 1.35)
"""RMS of normalised errors: 120 bounces know it to 7 %, and how long errors last is known to a
factor of two, which is worth a quarter."""


def bouncing(error: Floats) -> Gaps:
    """A ball that bounces at a wall under a steady pull, a body out of its reach."""
    frame = np.arange(float(FRAMES))
    phase = (frame - FIRST) % EVERY
    ball = 50.0 + 2 * SPEED / EVERY * phase * (EVERY - phase) + error
    heavy = np.full(FRAMES, 300.0)
    sigma = np.full(FRAMES, ERROR_PX)
    return Gaps(frame, ball, heavy, heavy - ball - 20.0, sigma, sigma, 1)


def errors(seed: int, lasts: float) -> Floats:
    rng = np.random.default_rng(seed)
    kept = np.exp(-1.0 / lasts) if lasts else 0.0
    error = np.empty(FRAMES)
    error[0] = rng.normal()
    for row in range(1, FRAMES):
        error[row] = kept * error[row - 1] + np.sqrt(1 - kept**2) * rng.normal()
    return ERROR_PX * error


def normalised(lasts: float) -> tuple[Floats, Floats]:
    """Errors of all times over their uncertainties, as the fits have them and as stated."""
    by_fits, stated = [], []
    for seed in range(TRIALS):
        gaps = bouncing(errors(seed, lasts))
        found = sharpen([c for c in find_candidates(gaps) if c.kind == "wall"], gaps)
        for before, after in zip(found, with_true_sigmas(found, gaps), strict=True):
            error = (before.frame - FIRST + EVERY / 2) % EVERY - EVERY / 2
            by_fits.append(error / before.frame_sigma)
            stated.append(error / after.frame_sigma)
    return np.array(by_fits), np.array(stated)


def rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("lasts", [0.0, 3.0, 6.0])
def test_stated_times_err_as_much_as_is_said_however_long_errors_last(lasts: float) -> None:
    by_fits, stated = normalised(lasts)

    assert TRUTHFUL[0] <= rms(stated) <= TRUTHFUL[1]
    assert rms(stated) <= rms(by_fits)


def test_fits_alone_are_too_sure_of_times_where_errors_last() -> None:
    by_fits, _ = normalised(6.0)

    assert rms(by_fits) > TRUTHFUL[1]


def test_times_without_flights_to_judge_by_stay_as_they_are() -> None:
    frame = np.arange(8.0)
    ball, heavy = 50.0 + np.abs(frame - 4.0), np.full(8, 300.0)
    gaps = Gaps(frame, ball, heavy, heavy - ball, np.ones(8), np.ones(8), 1)
    found = sharpen([c for c in find_candidates(gaps) if c.kind == "wall"], gaps)

    assert with_true_sigmas(found, gaps) == found

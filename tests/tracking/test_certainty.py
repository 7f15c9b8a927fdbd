from __future__ import annotations

import numpy as np
import pytest

from count_video.records import Floats
from count_video.tracking.certainty import stated_sigma

FRAMES = 400
NOISE_PX = 0.06
AGREEMENT = 0.25
"""Every bounce spoils three of 40 third differences, which raises their median by a tenth; they
share frames, so that 400 of them know it to 0.07, of which this leaves two."""


def bouncing(noise_px: float, seed: int) -> Floats:
    """A body that bounces every 40 frames, with white noise."""
    time = np.arange(float(FRAMES))
    zigzag = 2.0 * np.abs((time % 80.0) - 40.0)
    return zigzag + np.random.default_rng(seed).normal(0.0, noise_px, FRAMES)


@pytest.mark.parametrize("seed", range(4))
def test_understated_uncertainties_grow_to_the_noise_of_the_track(seed: int) -> None:
    stated = stated_sigma(bouncing(NOISE_PX, seed), np.full(FRAMES, NOISE_PX / 4))

    assert stated == pytest.approx(np.full(FRAMES, NOISE_PX), rel=AGREEMENT)


def test_frames_keep_their_share_of_the_uncertainty() -> None:
    stated = np.where(np.arange(FRAMES) % 2 == 0, 0.01, 0.02)

    grown = stated_sigma(bouncing(NOISE_PX, 0), stated)

    assert grown[1::2] == pytest.approx(2 * grown[::2])


def test_uncertainties_that_cover_the_noise_stay() -> None:
    cautious = np.full(FRAMES, 2 * NOISE_PX)

    assert stated_sigma(bouncing(NOISE_PX, 0), cautious).tolist() == cautious.tolist()


def test_what_was_not_seen_stays_unknown() -> None:
    position, sigma = bouncing(NOISE_PX, 0), np.full(FRAMES, NOISE_PX / 4)
    position[50:60] = sigma[50:60] = np.nan

    stated = stated_sigma(position, sigma)

    assert np.flatnonzero(np.isnan(stated)).tolist() == list(range(50, 60))
    assert np.isnan(stated_sigma(np.full(5, np.nan), np.full(5, np.nan))).all()

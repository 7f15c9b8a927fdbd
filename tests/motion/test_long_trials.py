"""A trial of many contacts, each fitted on its own: sure times, in memory by its length."""

from __future__ import annotations

import tracemalloc

import numpy as np

from count_video.motion.contacts import Contacts, fit_contacts
from count_video.records import Floats

EVERY = 24.0
"""Frames between bounces; the first is at frame 12.3."""
FIRST = 12.3
SPEED = 1.0
ERROR_PX = 0.1
LASTS_FRAMES = 4.0
MANY = 200
SIGMA_SHARE = 0.15
"""Three times what 200 contacts leave open of a standard deviation, a twentieth."""
FLOAT_BYTES = 8


def bouncing(bounces: int, every: float = EVERY) -> Floats:
    """Places of a ball that bounces at a wall at 50 px, measured with errors half of which last."""
    rng = np.random.default_rng(bounces)
    frame = np.arange(every * bounces)
    phase = (frame - FIRST) % every
    error, kept = rng.normal(0.0, ERROR_PX, len(frame)), np.exp(-1.0 / LASTS_FRAMES)
    lasting = rng.normal(0.0, ERROR_PX)
    for row in range(len(frame)):
        lasting = kept * lasting + np.sqrt(1 - kept**2) * rng.normal(0.0, ERROR_PX)
        error[row] += lasting
    return 50.0 + 2 * SPEED / every * phase * (every - phase) + error


def fitted(ball: Floats) -> Contacts:
    frame = np.arange(float(len(ball)))
    rough = np.round(FIRST + EVERY * np.arange(len(ball) / EVERY))
    return fit_contacts(frame, [ball], [(at, "wall") for at in rough.tolist()])


def test_memory_does_not_grow_with_the_square_of_the_frames() -> None:
    ball = bouncing(MANY)
    tracemalloc.start()
    try:
        found = fitted(ball)
        most_bytes = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(found.collisions) == MANY
    assert most_bytes < FLOAT_BYTES * len(ball) ** 2 / 2


def test_times_of_many_contacts_err_as_little_as_is_said() -> None:
    found = fitted(bouncing(MANY)).collisions
    true = FIRST + EVERY * np.arange(MANY)

    frame, sigma = np.transpose([(one.frame, one.frame_sigma) for one in found])
    assert float(np.std(frame - true)) < (1 + SIGMA_SHARE) * float(sigma.mean())
    assert all(np.isfinite(one.velocity_after.ball_px_frame) for one in found)
    assert all(np.isnan(one.velocity_after.heavy_px_frame) for one in found)

"""A trial of many contacts is fitted part by part: the same figures, in memory by its length."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from count_video.motion import model
from count_video.motion.joint import Contacts, fit_contacts
from count_video.motion.model import Paths
from count_video.records import Floats

EVERY = 24.0
"""Frames between bounces; the first is at frame 12.3."""
FIRST = 12.3
SPEED = 1.0
ERROR_PX = 0.1
LASTS_FRAMES = 4.0
ROUNDING = 1e-9
MANY = 300
FLOAT_BYTES = 8


def bouncing(bounces: int) -> Floats:
    """Places of a ball that bounces at a wall at 50 px, measured with errors half of which last."""
    rng = np.random.default_rng(bounces)
    frame = np.arange(EVERY * bounces)
    phase = (frame - FIRST) % EVERY
    error, kept = rng.normal(0.0, ERROR_PX, len(frame)), np.exp(-1.0 / LASTS_FRAMES)
    lasting = rng.normal(0.0, ERROR_PX)
    for row in range(len(frame)):
        lasting = kept * lasting + np.sqrt(1 - kept**2) * rng.normal(0.0, ERROR_PX)
        error[row] += lasting
    return 50.0 + 2 * SPEED / EVERY * phase * (EVERY - phase) + error


def fitted(ball: Floats) -> Contacts:
    frame = np.arange(float(len(ball)))
    rough = np.round(FIRST + EVERY * np.arange(len(ball) / EVERY))
    return fit_contacts(Paths(frame, ball, None), ["wall"] * len(rough), rough.tolist())


@pytest.mark.parametrize("rows_at_a_time", [1, 7, 100])
def test_parts_say_what_the_whole_says(
    rows_at_a_time: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    ball = bouncing(12)
    whole = fitted(ball)
    assert whole.errors[0] is not None
    assert whole.errors[0].lasting_px2.sum() > 0, "else the parts have nothing in common"

    monkeypatch.setattr(model, "ROWS_AT_A_TIME", rows_at_a_time)
    parts = fitted(ball)

    assert parts.frame == pytest.approx(whole.frame, rel=ROUNDING)
    assert parts.frame_sigma == pytest.approx(whole.frame_sigma, rel=ROUNDING)


def test_memory_does_not_grow_with_the_square_of_the_frames() -> None:
    ball = bouncing(MANY)
    tracemalloc.start()
    try:
        found = fitted(ball)
        most_bytes = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(found.frame) == MANY
    assert most_bytes < FLOAT_BYTES * len(ball) ** 2 / 2

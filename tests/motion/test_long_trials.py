"""A trial of many contacts is fitted piece by piece: the same figures, in memory by its length."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from count_video.motion.batches import BATCH_CONTACTS, fit_contacts
from count_video.motion.joint import Contacts, fit_together
from count_video.motion.model import Kind, Model, Paths
from count_video.records import Floats
from count_video.signals import Errors

EVERY = 24.0
"""Frames between bounces; the first is at frame 12.3."""
FIRST = 12.3
SPEED = 1.0
ERROR_PX = 0.1
LASTS_FRAMES = 4.0
ROUNDING = 1e-12
KINDS: tuple[Kind, ...] = ("bodies", "wall") * 5
MANY = 200
SIGMA_SHARE = 0.15
"""Batches know the place of the wall, and the errors of some 1600 places, a little less well."""
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
    return fit_contacts(Paths(frame, ball, None), ["wall"] * len(rough), rough.tolist())


def written_out(of: Model, jacobian: Floats, body: int) -> Floats:
    """The same covariance with a matrix of all rows of the body."""
    rows = np.flatnonzero(of.body[of.piece_of] == body)
    spread = np.zeros((len(rows), of.columns + 1))
    np.add.at(spread, (np.arange(len(rows))[:, None], of.slots[of.piece_of[rows]]), jacobian[rows])
    errors, spread = of.errors[body], spread[:, :-1]
    if errors is None:
        return spread.T @ spread
    return spread.T @ errors.covariance_of(of.frame[rows]) @ spread / of.sigma[body] ** 2


@pytest.mark.parametrize("lasting_px2", [None, (0.0, 0.0, 0.0, 0.0), (0.3, 0.0, 0.1, 0.2)])
@pytest.mark.parametrize("every", [12.0, 24.0, 400.0], ids=["short", "usual", "apart"])
def test_piece_by_piece_is_what_one_matrix_of_all_rows_gives(
    every: float, lasting_px2: tuple[float, ...] | None
) -> None:
    ball = bouncing(10, every)
    frame = np.arange(float(len(ball)))
    times = FIRST + every * np.arange(10)
    made = Model(Paths(frame, ball, ball + 100.0), (KINDS, times), 1.0, 0.5)
    if lasting_px2 is not None:
        made.use_errors((Errors(0.4, np.array(lasting_px2)), Errors(0.1, np.array(lasting_px2))))
    jacobian = np.random.default_rng(1).normal(size=(len(made.frame), made.slots.shape[1]))

    for body in (0, 1):
        whole = written_out(made, jacobian, body)
        pieces, errors = np.flatnonzero(made.body == body), made.errors[body]
        summed = made.sums.covariance(jacobian, pieces, errors, float(made.sigma[body]))
        assert summed == pytest.approx(whole, abs=ROUNDING * whole.max())


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


def test_batches_find_what_a_fit_of_all_contacts_at_once_finds() -> None:
    ball = bouncing(MANY)
    rough = np.round(FIRST + EVERY * np.arange(MANY)).tolist()
    paths = Paths(np.arange(float(len(ball))), ball, None)

    batches = fit_contacts(paths, ["wall"] * MANY, rough)
    at_once = fit_together(paths, ["wall"] * MANY, rough)

    assert MANY > 2 * BATCH_CONTACTS
    true = FIRST + EVERY * np.arange(MANY)
    off, off_at_once = (float(np.std(one.frame - true)) for one in (batches, at_once))
    assert off < (1 + SIGMA_SHARE) * off_at_once
    assert off < (1 + SIGMA_SHARE) * float(batches.frame_sigma.mean())
    assert batches.frame_sigma == pytest.approx(at_once.frame_sigma, rel=SIGMA_SHARE)
    assert np.median(batches.stray_px) == pytest.approx(0.0, abs=ERROR_PX)
    assert batches.bodies[0].rate.shape == (MANY, 2)

"""Which pictures a template is learnt from, and how steadily bodies move."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.tracking.paths import PICTURES, PLACE_BIN_PX, choose, unsteadiness

FAR_PX = 10 * PLACE_BIN_PX


@given(st.integers(0, PICTURES // 2), st.integers(PICTURES, 300))
def test_as_many_pictures_are_chosen_as_are_asked_for_however_rare_some_are(
    moving: int, resting: int
) -> None:
    places = [0.0] * resting + [FAR_PX * (1 + k) for k in range(moving)]
    path = np.array([(x, 0.0) for x in places])

    chosen = choose(path, [])

    assert len(chosen) == min(PICTURES, len(path))
    assert set(range(resting, resting + moving)) <= set(chosen.tolist())


@pytest.mark.parametrize("rests_for", [PICTURES, 10 * PICTURES])
def test_rest_takes_no_more_pictures_than_are_left_over(rests_for: int) -> None:
    moving = 3 * PICTURES
    places = [0.0] * rests_for + [FAR_PX * (1 + k) for k in range(moving)]
    path = np.array([(x, 0.0) for x in places])

    of_rest = [frame for frame in choose(path, []) if frame < rests_for]

    # All of its pictures weigh together as much as one that shows a place of its own.
    assert len(of_rest) <= 1


@pytest.mark.parametrize("camera_moves", [True, False])
def test_bodies_move_steadily_but_for_the_camera(camera_moves: bool) -> None:
    """What was measured of a camera is its motion if bodies move more steadily without it."""
    rng = np.random.default_rng(5)
    frames = np.sort(rng.choice(400, 60, replace=False))
    shake = rng.normal(0, 1.5, (60, 2))
    flights = [
        np.column_stack([60.0 * np.abs((frames / 90 + start) % 2 - 1), 0.0 * frames])
        for start in (0.0, 0.7)
    ]
    noisy = [path + rng.normal(0, 0.1, (60, 2)) for path in flights]
    paths = [path + shake for path in noisy] if camera_moves else noisy
    paths[0][7] = np.nan

    freed = unsteadiness([path - shake for path in paths], frames)

    assert (freed < unsteadiness(paths, frames)) is camera_moves


@pytest.mark.parametrize("camera_moves", [True, False])
def test_a_slow_drift_counts_more_than_the_noise_by_which_it_is_measured(
    *, camera_moves: bool
) -> None:
    """It shows between distant frames: from one to the next, what is measured adds its noise."""
    frames, rng = np.arange(240), np.random.default_rng(5)
    drift = np.column_stack([5.0 * np.sin(frames / 15), 3.0 * np.cos(frames / 19)])
    measured = drift + rng.normal(0, 0.05, drift.shape)
    flight = np.column_stack([60.0 * np.abs(frames / 90 % 2 - 1), 0.0 * frames])
    flight = flight + rng.normal(0, 0.05, flight.shape)
    path = flight + drift if camera_moves else flight

    assert (unsteadiness([path - measured], frames) < unsteadiness([path], frames)) is camera_moves

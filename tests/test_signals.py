from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.signals import (
    NOISE_AT_LEAST_PX,
    interpolated,
    low_points,
    noise_px,
    sigma_of,
)

NAN = float("nan")
ESTIMATE_SHARE = 0.15
"""A median of 2000 correlated third differences scatters by about 4 %; this is over thrice that."""


@pytest.mark.parametrize(
    ("signal", "places"),
    [
        pytest.param([3, 2, 1, 0, 1, 2, 3], [3], id="an exact zero"),
        pytest.param([3, 1, -1, -2, 0, 2], [3], id="below zero"),
        pytest.param([3, 2, 1, 1, 1, 2, 3], [3], id="a plateau's middle"),
        pytest.param([3, 1, 1, 3], [1], id="an even plateau's earlier middle"),
        pytest.param([3, 2, 1, 0], [], id="still falling at its end"),
        pytest.param([0, 1, 2, 3], [], id="rising from its start"),
        pytest.param([3, 0, 0, 0], [], id="a plateau up to the end"),
        pytest.param([0, 0, 0, 3], [], id="a plateau from the start"),
        pytest.param([3, 0, 3, 0, 3], [1, 3], id="two"),
        pytest.param([0, 3, 0, 3, 0], [2], id="ends low on both sides"),
        pytest.param([3, 0, 0.5, 0, 3], [2], id="a bump below the hysteresis"),
        pytest.param([3, 0, NAN, 3], [1], id="not seen after the lowest"),
        pytest.param([3, NAN, NAN, 0, 3], [3], id="not seen before the lowest"),
        pytest.param([NAN, 3, 0, 3, NAN], [2], id="not seen at the ends"),
        pytest.param([3, 2.5, 3, 2.5, 3], [], id="only noise"),
        pytest.param([1, 0, 1], [], id="as deep as the hysteresis is not deeper"),
        pytest.param([1.5, 0, 1.5], [1], id="just deeper than the hysteresis"),
        pytest.param([2, 0, 0.9, 5], [1], id="steep on one side, in steps on the other"),
        pytest.param([NAN, NAN], [], id="never seen"),
        pytest.param([], [], id="empty"),
        pytest.param([1], [], id="one value"),
    ],
)
def test_low_points_of_signals_that_one_can_check_by_eye(
    signal: list[float], places: list[int]
) -> None:
    found = low_points(np.array(signal, dtype=np.float64), hysteresis=1.0)

    assert found.tolist() == places


signals = st.lists(st.integers(-20, 20), min_size=0, max_size=60).map(
    lambda values: np.array(values, dtype=np.float64)
)


@given(signals, st.integers(1, 10))
def test_a_low_point_is_deeper_than_the_hysteresis_on_both_sides(
    signal: np.ndarray, hysteresis: int
) -> None:
    places = low_points(signal, hysteresis)
    edges = [0, *places, len(signal) - 1]

    for number, place in enumerate(places, start=1):
        before = signal[edges[number - 1] : place + 1]
        after = signal[place : edges[number + 1] + 1]
        lowest = min(before.min(), after.min())
        assert before.max() - lowest > hysteresis
        assert after.max() - lowest > hysteresis


@given(signals, st.integers(1, 10), st.integers(-50, 50), st.integers(1, 8))
def test_low_points_do_not_move_with_offset_or_scale(
    signal: np.ndarray, hysteresis: int, offset: int, scale: int
) -> None:
    moved = low_points(scale * signal + offset, scale * hysteresis)

    assert moved.tolist() == low_points(signal, hysteresis).tolist()


@given(st.lists(st.integers(-20, 20), max_size=40, unique=True), st.integers(1, 10))
def test_low_points_of_a_signal_without_plateaus_are_the_same_backwards(
    values: list[int], hysteresis: int
) -> None:
    signal = np.array(values, dtype=np.float64)

    backwards = len(signal) - 1 - low_points(signal[::-1], hysteresis)[::-1]

    assert backwards.tolist() == low_points(signal, hysteresis).tolist()


@given(signals, st.integers(1, 10), st.data())
def test_frames_in_which_nothing_is_seen_change_nothing(
    signal: np.ndarray, hysteresis: int, data: st.DataObject
) -> None:
    unseen = data.draw(st.lists(st.integers(0, len(signal)), max_size=5))
    holed = np.insert(signal, unseen, NAN)
    seen = np.flatnonzero(np.isfinite(holed))

    found = low_points(holed, hysteresis)

    assert len(found) == len(low_points(signal, hysteresis))
    unique = [p for p in low_points(signal, hysteresis) if np.sum(signal == signal[p]) == 1]
    assert set(seen[unique]) <= set(found)


@pytest.mark.parametrize("sigma", [0.02, 0.1, 3.0])
@pytest.mark.parametrize("seed", range(5))
def test_the_noise_of_white_noise_is_its_standard_deviation(sigma: float, seed: int) -> None:
    noise = np.random.default_rng(seed).normal(0.0, sigma, 2000)

    assert noise_px(noise) == pytest.approx(sigma, rel=ESTIMATE_SHARE)


@pytest.mark.parametrize("bend", [0.0, 0.01, -0.3])
def test_noise_is_distinguished_from_motion_that_is_quadratic_in_time(bend: float) -> None:
    frame = np.arange(2000.0) - 1000.0
    noise = np.random.default_rng(1).normal(0.0, 0.05, 2000)

    assert noise_px(50.0 - 3.0 * frame + bend * frame**2 + noise) == pytest.approx(
        0.05, rel=ESTIMATE_SHARE
    )


def test_a_quadratic_motion_without_noise_has_none() -> None:
    frame = np.arange(100.0)

    assert noise_px(7.0 - 2.0 * frame + 0.25 * frame**2) == 0.0


def test_corners_are_no_noise() -> None:
    frame = np.arange(2000.0)
    zigzag = 4.0 * np.abs(frame % 20.0 - 10.0)
    noise = np.random.default_rng(2).normal(0.0, 0.05, 2000)

    # Three of ten third differences hold a corner; the median of the others is somewhat higher.
    assert 0.05 * (1 - ESTIMATE_SHARE) < noise_px(zigzag + noise) < 2 * 0.05


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_fewer_than_four_values_show_no_noise(count: int) -> None:
    assert noise_px(np.arange(float(count)) ** 3) == 0.0


def test_frames_not_seen_at_the_ends_do_not_count_as_noise() -> None:
    noise = np.random.default_rng(3).normal(0.0, 0.05, 500)

    assert noise_px(np.concatenate([[NAN, NAN], noise, [NAN]])) == noise_px(noise)


def test_no_track_is_taken_to_be_better_than_compression_allows() -> None:
    assert sigma_of(np.arange(50.0)) == NOISE_AT_LEAST_PX


def test_a_noisy_track_keeps_its_noise() -> None:
    noise = np.random.default_rng(4).normal(0.0, 1.0, 500)

    assert sigma_of(noise) == noise_px(noise)


def test_what_was_not_seen_lies_on_the_line_between_its_neighbours_and_ends_go_on() -> None:
    signal = np.array([np.nan, 1.0, np.nan, np.nan, 4.0, 5.0, np.nan])
    assert np.array_equal(interpolated(signal), [1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0])

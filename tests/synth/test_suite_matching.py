"""Pairs of true and found collisions, on sequences that one can check by eye."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from synth_video.suite.scoring import LEAST_WINDOW_FRAMES, MOST_WINDOW_FRAMES, match, windows

FRAMES = st.lists(st.floats(0, 100), max_size=12).map(sorted)


def test_nothing_found_matches_nothing() -> None:
    assert match([10.0, 20.0], []) == []


def test_nothing_true_matches_nothing() -> None:
    assert match([], [10.0, 20.0]) == []


def test_nothing_at_all_matches_nothing() -> None:
    assert match([], []) == []


def test_of_two_found_for_one_true_the_nearer_is_taken() -> None:
    assert match([10.0], [9.5, 10.2]) == [(0, 1)]


def test_of_two_true_for_one_found_the_nearer_is_taken() -> None:
    assert match([10.0, 12.0], [10.9]) == [(0, 0)]


def test_more_pairs_go_before_nearer_ones() -> None:
    # 11.0 is nearer to the second, but then the first, too far from 11.9, would have nobody.
    assert match([10.0, 11.4], [11.0, 11.9]) == [(0, 0), (1, 1)]


def test_a_single_collision_has_the_widest_window_and_its_border_belongs_to_it() -> None:
    assert windows([50.0]).tolist() == [MOST_WINDOW_FRAMES]
    assert match([50.0], [50.0 + MOST_WINDOW_FRAMES]) == [(0, 0)]
    assert match([50.0], [50.0 + MOST_WINDOW_FRAMES + 1e-6]) == []


def test_dense_collisions_keep_the_least_window() -> None:
    assert windows([10.0, 11.0, 12.0]).tolist() == [LEAST_WINDOW_FRAMES] * 3


def test_a_window_ends_half_way_to_the_nearest_neighbour() -> None:
    assert windows([10.0, 14.0, 20.0]).tolist() == [2.0, 2.0, 3.0]
    assert match([10.0, 14.0, 20.0], [12.5, 14.0]) == [(1, 1)]


def test_a_missed_one_in_the_middle_shifts_no_other() -> None:
    assert match([10.0, 13.0, 16.0, 19.0], [10.1, 16.2, 18.9]) == [(0, 0), (2, 1), (3, 2)]


def test_an_invented_one_in_the_middle_shifts_no_other() -> None:
    assert match([10.0, 13.0, 16.0], [10.1, 11.5, 13.1, 16.0]) == [(0, 0), (1, 2), (2, 3)]


@given(FRAMES, FRAMES)
def test_pairs_are_in_order_one_to_one_and_within_their_windows(
    true: list[float], found: list[float]
) -> None:
    pairs = match(true, found)
    reach = windows(true)
    assert [i for i, _ in pairs] == sorted({i for i, _ in pairs})
    assert len({j for _, j in pairs}) == len(pairs)
    assert all(abs(true[i] - found[j]) <= reach[i] for i, j in pairs)


@given(FRAMES)
def test_the_truth_matches_itself_completely(true: list[float]) -> None:
    pairs = match(true, true)
    assert len(pairs) == len(true)
    assert [true[i] for i, _ in pairs] == pytest.approx([true[j] for _, j in pairs])

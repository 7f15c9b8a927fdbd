"""Bounces get lower and lower: those that pictures show are counted, the endless tail is not."""

import numpy as np
import pytest

from count_video.motion.impacts import Impact
from count_video.motion.missing import dies_out, in_series


def _impacts(frames: np.ndarray) -> list[Impact]:
    """Impacts on one stop at these frames."""
    return [Impact(float(frame), 0.05, 1, 0.0, 5.0, -4.0, 50.0, 4) for frame in frames]


def _series(first: float, share: float, number: int) -> np.ndarray:
    """Frames of impacts whose flights form a geometric series."""
    return np.concatenate([[0.0], np.cumsum(first * share ** np.arange(number - 1))])


def test_a_geometric_series_down_to_few_pictures_dies_out() -> None:
    assert dies_out(_impacts(_series(20.0, 0.8, 9)))


def test_flights_that_are_still_long_do_not() -> None:
    """Of a body that is lost while it bounces high, impacts are missing."""
    assert not dies_out(_impacts(_series(20.0, 0.8, 4)))


def test_nor_do_equal_flights() -> None:
    assert not dies_out(_impacts(3.0 * np.arange(8)))


def test_a_last_impact_at_a_wrong_time_does_not_make_a_series_die_out() -> None:
    frames = _series(40.0, 0.8, 6)
    frames[-1] -= 13.0
    assert not dies_out(_impacts(frames))


@pytest.mark.parametrize("share", [0.6, 0.75, 0.9])
def test_each_impact_of_a_series_is_in_it(share: float) -> None:
    assert all(in_series(_impacts(_series(50.0, share, 8))))


def test_a_missed_impact_and_one_too_many_are_not_in_the_series() -> None:
    frames = _series(50.0, 0.85, 10)
    missed = in_series(_impacts(np.delete(frames, 5)))
    assert [number for number, known in enumerate(missed) if not known] == [5, 6]
    more = in_series(_impacts(np.insert(frames, 5, frames[4:6].mean())))
    assert not more[5]

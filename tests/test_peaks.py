from __future__ import annotations

import numpy as np
import pytest

from count_video.signals import beyond, peak_of


@pytest.mark.parametrize("top", [2.6, 3.0, 3.2, 3.4])
def test_the_top_of_a_parabola_is_found_exactly(top: float) -> None:
    values = (5.0 - (np.arange(7) - top) ** 2).astype(np.float32)

    assert peak_of(values, 3) == pytest.approx(top, abs=1e-5)


def test_a_plateau_stays_where_it_is() -> None:
    assert peak_of(np.ones(5, dtype=np.float32), 2) == 2.0


@pytest.mark.parametrize("place", [0, 4])
def test_a_peak_at_an_end_is_there(place: int) -> None:
    assert peak_of(np.arange(5, dtype=np.float32), place) == place


def test_many_peaks_are_refined_at_once() -> None:
    low, top, high = (np.array(part, dtype=np.float32) for part in ((0, 1), (2, 2), (0, 2)))

    assert beyond(low, top, high).tolist() == [0.0, 0.5]

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shutter_study import SHUTTERS, TimeErrors, table, time_errors

from tiers import rest_slow

NUMBERS = (3, 6)
"""Trials of 5 and 7 collisions: short clips."""
MEDIAN_FRAMES, NEARLY_ALL_FRAMES = 0.1, 0.4
BIAS_SIGMAS = 3.0
"""A mean error strays further from zero than this in one case of 370."""


@pytest.mark.parametrize("shutter", rest_slow([SHUTTERS[-1], SHUTTERS[0]]))
def test_times_are_those_of_the_exposures_centre(shutter: float, tmp_path: Path) -> None:
    errors = time_errors(NUMBERS, shutter, tmp_path)

    assert errors.missed == 0
    assert abs(errors.mean) < BIAS_SIGMAS * errors.mean_sigma
    assert np.median(np.abs(errors.signed)) < MEDIAN_FRAMES
    assert np.quantile(np.abs(errors.signed), 0.95) < NEARLY_ALL_FRAMES


def test_the_table_gives_bias_and_spread() -> None:
    errors = TimeErrors(np.array([0.1, -0.1, 0.2, 0.2]), missed=1)

    cells = table([(0.5, errors)]).splitlines()[-1].split(" | ")
    assert cells == ["| 50%", "4", "1", "+0.1000 ± 0.0707", "0.150", "0.200 |"]

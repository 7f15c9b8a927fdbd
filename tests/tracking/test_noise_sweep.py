from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from noise_sweep import Point, figure_of, points, quiet_scene, table
from pixel_bound import bounds_px

from tiers import rest_slow

TIMES_THE_BOUND = 2.0
TRUTHFUL = (0.8, 1.3)
"""RMS of errors over stated uncertainties."""
FRAMES = 120
"""An RMS over so many frames is known to 7 %."""
WHOLE_TRIAL = 0
"""Frames of a scene that are rendered to the trial's end."""


@pytest.mark.parametrize(
    ("noise", "frames"), rest_slow([(8.0, FRAMES), (1.0, FRAMES), (4.0, WHOLE_TRIAL)])
)
def test_places_are_within_twice_the_bound_and_state_their_uncertainty(
    noise: float, frames: int, tmp_path: Path
) -> None:
    for point in points(quiet_scene(noise, f"clip.frames={frames}"), [7], tmp_path):
        assert point.ratio <= TIMES_THE_BOUND
        assert TRUTHFUL[0] <= point.normalised <= TRUTHFUL[1]


def test_twice_the_contrast_halves_the_bound() -> None:
    plain, faint = (
        quiet_scene(1.0, f"light.brightness={light}", "clip.frames=1") for light in (0.8, 0.4)
    )

    assert bounds_px(faint, 0) == pytest.approx(2 * np.array(bounds_px(plain, 0)), rel=1e-3)


def test_the_table_and_the_picture_show_every_point() -> None:
    rows = [(Point(1.0, 3, 0.002, 0.003, 1.0), Point(1.0, 3, 0.002, 0.004, 1.1))]

    assert table(rows).splitlines()[2].split(" | ")[1:5] == ["3", "0.0020", "0.0030", "1.50"]
    assert len(figure_of(rows).axes) == 2

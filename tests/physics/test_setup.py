from __future__ import annotations

from typing import Any

import pytest

from count_video.errors import UsageError
from count_video.physics.setup import Setup

FREE = {"mounting": "free", "heavy_velocity_m_s": -1.0}


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"heavy_mass_kg": 0.0}, "heavy_mass_kg is 0"),
        ({"light_thread_m": -1.0}, "light_thread_m is -1"),
        ({"wall_gap_m": -0.1}, "wall_gap_m is -0.1"),
        ({"restitution_wall": 1.01}, "between 0 and 1"),
        ({"restitution_bodies_sd": -0.01}, "not be negative"),
        ({"bodies_gap_m": -0.1}, "inside the ball"),
        ({"mounting": "free"}, "toward the wall"),
        ({"mounting": "free", "heavy_velocity_m_s": 0.5}, "toward the wall"),
        ({"gravity_m_s2": 0.0}, "needs weight"),
        ({"heavy_damping_per_s": 4.0}, "heavy_damping_per_s is 4"),
        ({"light_thread_m": 100.0, "light_damping_per_s": 0.4}, "less than 0.313"),
    ],
)
def test_an_impossible_setup_is_refused_in_one_line(values: dict[str, Any], said: str) -> None:
    with pytest.raises(UsageError, match=said) as caught:
        Setup(**values)
    assert "\n" not in str(caught.value)


def test_what_does_not_apply_to_a_mounting_is_not_held_against_it() -> None:
    free = Setup(**FREE, gravity_m_s2=0.0, heavy_damping_per_s=50.0)
    assert free.heavy_rest_m == pytest.approx(0.07 + 0.04)

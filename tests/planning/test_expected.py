"""The counts that a result's own physics leads to."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_comparison import PLANNED, found

from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate, simulate_many
from count_video.planning.comparison import expected_counts
from count_video.records import Estimate
from count_video.reports.text import result_text

SETUP = PLANNED.setup()
"""1:100 with threads of 1 m, the ball 3 cm from the wall: 31, for free bodies as well."""
LIGHT_KG = SETUP.light_mass_kg
WIDE = replace(SETUP, wall_gap_m=0.07)
"""The same with the ball 7 cm from the wall: 27."""


def notes(text: str) -> dict[str, str]:
    """Return the sentences of a text by their labels, each in one line."""
    labels: dict[str, str] = {}
    label = ""
    for line in text.splitlines()[2:]:
        label = line[2:15].strip() or label
        labels[label] = f"{labels.get(label, '')} {line[15:].strip()}".strip()
    return labels


@given(
    gap_m=st.floats(0.01, 0.08),
    release_m=st.floats(0.07, 0.12),
    heavy_thread_m=st.floats(0.5, 1.5),
    light_thread_m=st.floats(0.5, 1.5),
    ratio=st.floats(1.01, 120),
    restitution=st.floats(0.95, 1),
)
def test_a_fit_without_errors_leads_to_the_simulated_counts(
    gap_m: float,
    release_m: float,
    heavy_thread_m: float,
    light_thread_m: float,
    ratio: float,
    restitution: float,
) -> None:
    lossy = replace(
        SETUP,
        heavy_mass_kg=ratio,
        wall_gap_m=gap_m,
        release_m=release_m,
        heavy_thread_m=heavy_thread_m,
        light_thread_m=light_thread_m,
        restitution_bodies=restitution,
        restitution_wall=restitution,
    )
    expected = expected_counts(found(lossy))
    assert expected is not None
    # Lengths in px and times in frames are other units: roundings decide where a count is about to
    # change, so the simulated count of a neighbour is right as well.
    lossless = replace(lossy, restitution_bodies=1.0, restitution_wall=1.0)
    shares = (-1e-9, 0.0, 1e-9)
    near = simulate_many([_longer(one, share) for one in (lossy, lossless) for share in shares])
    assert expected.with_losses in near.count[:3]
    assert expected.hanging in near.count[3:]


def _longer(setup: Setup, share: float) -> Setup:
    return replace(setup, wall_gap_m=setup.wall_gap_m * (1 + share))


def test_threads_that_lower_the_count_are_named() -> None:
    result = found(WIDE)
    assert result.count == 27
    said = notes(result_text(result))["Expected"]
    assert said.startswith("31 for free bodies without losses, 27 on these threads")
    assert said.endswith("the threads drive the cylinder back sooner, and make it 27")


def test_losses_that_have_no_end_lead_to_no_count() -> None:
    # Half of the speed is lost at each bounce: the ball comes to rest between cylinder and wall.
    rattling = replace(SETUP, heavy_mass_kg=10_000, restitution_bodies=0.5, restitution_wall=0.5)
    result = replace(
        found(SETUP),
        mass_ratio=1e4,
        restitution_bodies=Estimate(0.5, 0.01),
        restitution_wall=Estimate(0.5, 0.01),
    )
    assert simulate(rattling, most=1000).endless
    expected = expected_counts(result)
    assert expected is not None
    assert (expected.free, expected.with_losses) == ((314, 314), None)


def test_where_nothing_differs_nothing_is_explained() -> None:
    said = notes(result_text(found(SETUP)))["Expected"]
    assert said == "31, for free bodies without losses and on these threads with these gaps alike"


def test_a_count_that_nothing_explains_is_said_to_be_so() -> None:
    said = notes(result_text(found(WIDE, count=25)))["Expected"]
    assert said.endswith("neither explains the 25 counted")


def test_where_all_agree_on_another_count_none_explains_it() -> None:
    said = notes(result_text(found(SETUP, count=25)))["Expected"]
    assert said.endswith("on these threads with these gaps alike; neither explains the 25 counted")


def test_masses_beyond_any_plan_are_not_simulated() -> None:
    expected = expected_counts(found(SETUP, mass_ratio=1e30))
    assert expected is not None
    assert (expected.hanging, expected.with_losses) == (None, None)
    assert expected.free[0] > 1e15


@pytest.mark.parametrize(("sigma", "free"), [(0.004, (3, 4)), (None, (4, 4)), (0.0001, (4, 4))])
def test_an_uncertain_mass_ratio_leads_to_every_count_within_it(
    sigma: float | None, free: tuple[int, int]
) -> None:
    equal = replace(SETUP, heavy_mass_kg=1.001)
    expected = expected_counts(found(equal, mass_ratio=1.001, mass_ratio_sigma=sigma))
    assert expected is not None
    assert expected.free == free


def test_pi_within_the_uncertainty_of_the_mass_ratio_is_not_called_outside() -> None:
    # 3 collisions of equal masses: pi is the upper bound itself, which 1.001 misses by little.
    result = found(SETUP, count=3, mass_ratio=1.0009, pi_low=2.3555, pi_high=3.1407, setup=None)
    assert (
        "within the uncertainty"
        in notes(result_text(replace(result, mass_ratio_sigma=0.004)))["Pi"]
    )
    assert "pi lies outside" in notes(result_text(replace(result, mass_ratio_sigma=0.0001)))["Pi"]
    assert "pi lies outside" in notes(result_text(replace(result, mass_ratio_sigma=None)))["Pi"]


def test_without_a_mass_ratio_nothing_is_expected() -> None:
    assert expected_counts(found(SETUP, mass_ratio=None)) is None
    assert "Expected" not in result_text(found(SETUP, mass_ratio=None))


def test_a_fit_in_which_no_threads_show_leaves_free_bodies() -> None:
    result = found(SETUP)
    assert result.setup is not None
    endless = replace(result.setup, ball_period_frames=Estimate(float("inf"), 0.0))
    expected = expected_counts(replace(result, setup=endless))
    assert expected is not None
    assert (expected.free, expected.hanging, expected.with_losses) == ((31, 31), None, None)


@pytest.mark.parametrize(
    "changes",
    [
        {"mass_ratio": math.nan},
        {"mass_ratio": math.inf},
        {"mass_ratio_sigma": math.nan},
        {"mass_ratio_sigma": math.inf},
        {"restitution_wall": Estimate(math.nan, math.nan)},
        {"restitution_bodies": None},
    ],
)
def test_what_is_not_known_leads_to_no_count_and_no_error(changes: dict[str, object]) -> None:
    result = found(SETUP, **changes)
    expected = expected_counts(result)
    assert expected is None or expected.hanging in (31, None)
    assert result_text(result).startswith("trial.mp4: 31 collisions")


def test_a_cylinder_that_may_be_as_heavy_as_the_ball_is_taken_for_no_lighter() -> None:
    """A lighter one would be driven back, and its threads turn it before the ball returns."""
    equal = replace(SETUP, heavy_mass_kg=LIGHT_KG, bodies_gap_m=-0.001)
    result = replace(found(equal), mass_ratio=0.997, mass_ratio_sigma=0.007)
    expected, lighter = expected_counts(result), replace(equal, heavy_mass_kg=0.997 * LIGHT_KG)

    assert expected is not None
    assert expected.hanging == simulate(equal).count
    assert expected.hanging != simulate(lighter).count

from __future__ import annotations

import math
import subprocess
import sys
from decimal import Decimal
from fractions import Fraction

import mpmath
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from count_video.errors import UsageError
from count_video.physics.theory import (
    WHOLE_QUOTIENTS,
    Mass,
    collision_count,
    mass_ratio_interval,
    pi_bounds,
    theta_rad,
)

RATIOS = st.fractions(Fraction(1, 1000), Fraction(10**8), max_denominator=1000)
A_HAIR = Fraction(1, 10**60)
FLOAT_ROUNDING = 2.0**-52


@pytest.mark.parametrize(
    ("heavy", "light", "count"),
    [
        (1, 1, 3),
        (2, 1, 5),
        (3, 1, 5),
        (4, 1, 6),
        (16, 1, 12),
        (64, 1, 25),
        (100, 1, 31),
        (10**4, 1, 314),
        (1, 3, 2),
        (1, Fraction(1, 3), 5),
        (Fraction(1, 3), 1, 2),
        (1.050, 0.0105, 31),
        (Decimal("1.050"), Decimal("0.0105"), 31),
    ],
)
def test_known_mass_ratios_give_their_count(heavy: Mass, light: Mass, count: int) -> None:
    assert collision_count(heavy, light) == count


@pytest.mark.parametrize("digits", range(21))
def test_a_hundred_to_the_n_reads_off_the_digits_of_pi(digits: int) -> None:
    context = mpmath.MPContext()
    context.dps = 40
    assert collision_count(100**digits) == int(context.floor(context.pi * 10**digits))


@pytest.mark.parametrize(("ratio", "quotient"), WHOLE_QUOTIENTS.items())
def test_a_hair_decides_where_pi_over_theta_is_whole(ratio: Fraction, quotient: int) -> None:
    assert collision_count(ratio - A_HAIR) == quotient - 1
    assert collision_count(ratio) == quotient - 1
    assert collision_count(ratio + A_HAIR) == quotient


@pytest.mark.parametrize("quotient", WHOLE_QUOTIENTS.values())
def test_the_whole_quotients_are_those_of_the_tangent(quotient: int) -> None:
    ratio = next(r for r, n in WHOLE_QUOTIENTS.items() if n == quotient)
    assert math.tan(math.pi / quotient) ** 2 == pytest.approx(1 / ratio, rel=8 * FLOAT_ROUNDING)


def test_a_float_is_taken_at_its_exact_value() -> None:
    assert collision_count(3.0) == 5
    assert collision_count(math.nextafter(3.0, 4.0)) == 6
    assert collision_count(1 / 3) == 2  # the float lies below one third
    assert collision_count(math.nextafter(1 / 3, 1.0)) == 3
    assert collision_count(Decimal("0.3"), Decimal("0.1")) == 5


@pytest.mark.parametrize("mass", [0, -1, math.nan, math.inf, Decimal("nan"), "heavy", None])
@pytest.mark.parametrize("place", ["heavy", "light"])
def test_an_unusable_mass_is_refused_by_name(mass: Mass, place: str) -> None:
    masses: dict[str, Mass] = {"heavy": 1, "light": 1, place: mass}
    with pytest.raises(UsageError, match=place):
        collision_count(**masses)


@given(RATIOS, st.fractions(Fraction(1, 100), 100))
def test_only_the_ratio_of_the_masses_counts(ratio: Fraction, light: Fraction) -> None:
    assume(light > 0)
    assert collision_count(ratio * light, light) == collision_count(ratio)


@given(RATIOS, RATIOS)
def test_a_heavier_cylinder_never_collides_less(one: Fraction, other: Fraction) -> None:
    lesser, greater = sorted((one, other))
    assert collision_count(lesser) <= collision_count(greater)


@given(RATIOS)
def test_the_count_holds_within_its_interval_of_mass_ratio(ratio: Fraction) -> None:
    low, high = mass_ratio_interval(collision_count(ratio))
    assert low * (1 - FLOAT_ROUNDING) <= ratio <= high * (1 + FLOAT_ROUNDING)


@given(st.integers(2, 10**7))
def test_intervals_of_mass_ratio_join_without_a_gap(count: int) -> None:
    low, high = mass_ratio_interval(count)
    assert mass_ratio_interval(count + 1).low == high
    middle = (Fraction(low) + Fraction(high)) / 2
    assert collision_count(middle) == count


@given(st.integers(3, 10**7))
def test_the_ends_of_an_interval_are_the_nearest_floats(count: int) -> None:
    end = mass_ratio_interval(count).low
    half = Fraction(math.ulp(end)) / 2
    assert collision_count(Fraction(end) - half) == count - 1
    assert collision_count(Fraction(end) + half) == count


def test_thirty_one_collisions_bound_the_mass_ratio() -> None:
    low, high = mass_ratio_interval(31)
    assert round(low, 1) == 96.7
    assert round(high, 1) == 103.1


def test_the_ends_of_an_interval_are_exact_where_they_are_rational() -> None:
    assert mass_ratio_interval(2) == (0.0, 1 / 3)
    assert mass_ratio_interval(3).high == 1.0
    assert mass_ratio_interval(5).high == 3.0


@given(RATIOS)
def test_the_right_count_encloses_pi_and_a_wrong_one_does_not(ratio: Fraction) -> None:
    count = collision_count(ratio)
    low, high = pi_bounds(count, ratio)
    assert low <= math.pi <= high
    assert high - low == pytest.approx(theta_rad(ratio), rel=1e-6)
    assert pi_bounds(count + 2, ratio).low > math.pi
    assert pi_bounds(count - 2, ratio).high < math.pi


def test_importing_theory_and_simulator_leaves_mpmath_for_later() -> None:
    program = (
        "import sys, count_video.physics.theory, count_video.physics.simulator;"
        "print('mpmath' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"

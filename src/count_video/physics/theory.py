"""How many collisions there are, exactly, and what a count says about the masses and about pi.

With θ = arctan √(m/M) every collision turns the state on the phase circle by θ seen from the
right place, and the count is ⌈π/θ⌉ − 1 (Galperin; section 2 of the paper with α = 2θ). Counts are
whole numbers read off real ones with proof, by arithmetic of growing precision.

Whatever takes masses raises ``UsageError`` if one is not a finite number greater than 0. The ratio
of those with angles has a place in a float.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from count_video.errors import UsageError
from count_video.records import Floats

Mass = int | Fraction | Decimal | float
"""A mass in any unit. A float or Decimal is taken at its exact value."""

# π/θ is an integer n only if tan²(π/n) = m/M is rational. Then cos(2π/n) = (1 − tan²)/(1 + tan²)
# is rational too, and by Niven's theorem a rational cosine of a rational part of the turn is 0,
# ±1/2 or ±1. So n is 1, 2, 3, 4 or 6, and as 0 < θ < π/2 only 3, 4 and 6 are left.
WHOLE_QUOTIENTS = {Fraction(1, 3): 3, Fraction(1): 4, Fraction(3): 6}
"""The mass ratios M/m at which π/θ is an integer, and that integer."""

_ROUNDING = 4 * 2.0**-52
"""A bound on the relative error in floats of atan(sqrt(ratio)) times a whole number, and of pi over
it."""
_LEAST, _MOST = 1e-300, 1e300
"""Mass ratios between these are sound floats, and so are their inverses."""


class Bounds(NamedTuple):
    """Ends of an interval."""

    low: float
    high: float


def exact_ratio(heavy: Mass, light: Mass) -> Fraction:
    """M/m as an exact fraction."""
    return _exact(heavy, "heavy") / _exact(light, "light")


def collision_count(heavy: Mass, light: Mass = 1) -> int:
    """Exact number of collisions of two elastic bodies and a wall: ⌈π/θ⌉ − 1."""
    ratio = exact_ratio(heavy, light)
    if ratio in WHOLE_QUOTIENTS:
        return WHOLE_QUOTIENTS[ratio] - 1
    if _LEAST < ratio < _MOST:  # floats decide it, but where the quotient is all but an integer
        rough = math.pi / theta_rad(ratio)
        low, high = (math.floor(rough * (1.0 + sign * _ROUNDING)) for sign in (-1, 1))
        if low == high:
            return low

    import mpmath  # noqa: PLC0415 - it would cost every start of the command

    bits = 64
    while True:
        with mpmath.workprec(bits):
            root = mpmath.sqrt(mpmath.mpf(ratio.denominator) / ratio.numerator)
            quotient = mpmath.pi / mpmath.atan(root)
            # Each of the steps is right to some units of the last bit; the last eight are doubted.
            doubt = mpmath.ldexp(quotient, 8 - bits)
            low, high = int(quotient - doubt), int(quotient + doubt)
        if low == high:
            return low
        bits *= 2


def theta_rad(heavy: Mass, light: Mass = 1) -> float:
    """θ = arctan √(m/M), to a rounding or two."""
    return math.atan(math.sqrt(float(1 / exact_ratio(heavy, light))))


def pi_bounds(count: int, heavy: Mass, light: Mass = 1) -> Bounds:
    """Bounds on π from a count: N θ ≤ π ≤ (N + 1) θ, rounded outward.

    At 1:100ⁿ the bounds read off the digits of π. They hold for the count of a lossless trial;
    whether a given count and mass ratio agree is seen by π lying between them or not.
    """
    theta = theta_rad(heavy, light)
    return Bounds(count * theta * (1.0 - _ROUNDING), (count + 1) * theta * (1.0 + _ROUNDING))


def mass_ratio_interval(count: int) -> Bounds:
    """Mass ratios M/m at which a lossless trial has ``count`` collisions, low < M/m ≤ high.

    N < π/θ ≤ N + 1 means cot²(π/N) < M/m ≤ cot²(π/(N + 1)). Both ends are the nearest floats. The
    fewest collisions are 2: bodies that collide at all collide twice.
    """
    import mpmath  # noqa: PLC0415 - see above

    with mpmath.workprec(128):
        angles = (mpmath.mpf(1) / parts for parts in (count, count + 1))  # as shares of π
        return Bounds(*(float((mpmath.cospi(x) / mpmath.sinpi(x)) ** 2) for x in angles))


@dataclass(frozen=True)
class Theory:
    """What the theory says of two bodies that move freely and lose nothing."""

    mass_ratio: float
    """Heavy over light."""
    count: int
    """Exact number of collisions."""
    theta_rad: float
    """arctan of the root of the light over the heavy mass, in radians."""
    pi_bounds: Bounds
    """``count`` and ``count`` + 1 times ``theta_rad``; pi lies between them."""
    same_count: Bounds
    """Mass ratios above the first and up to the second have the same count."""


def theory_of(heavy: Mass, light: Mass = 1) -> Theory:
    """Collect what follows from two masses."""
    count = collision_count(heavy, light)
    return Theory(
        mass_ratio=float(exact_ratio(heavy, light)),
        count=count,
        theta_rad=theta_rad(heavy, light),
        pi_bounds=pi_bounds(count, heavy, light),
        same_count=mass_ratio_interval(count),
    )


def state_points(heavy: Mass, light: Mass = 1) -> Floats:
    """Points (V₁, V₂) from before the first collision to after the last, on the unit circle.

    In the scaled velocities V₁ = √M v₁ and V₂ = √m v₂ the energy is a circle. A collision of the
    bodies moves the state along a line of slope −√(M/m) to the other crossing with the circle, one
    with the wall mirrors it at the V₁ axis: point k lies at angle ⌈k/2⌉ 2θ from the negative V₁
    axis, below the axis for odd k and above it for even k.

    Shape (count + 1, 2); multiply by √(2E) for a trial of energy E. Each point is computed from its
    angle, not from the one before, so that no rounding adds up.
    """
    steps = np.arange(collision_count(heavy, light) + 1)
    angles = (steps + 1) // 2 * (2.0 * theta_rad(heavy, light))
    side = np.where(steps % 2 == 0, 1.0, -1.0)
    return np.column_stack([-np.cos(angles), side * np.sin(angles)])


def _exact(mass: Mass, name: str) -> Fraction:
    """Return the exact value of a usable mass."""
    try:
        value = Fraction(mass)
    except (TypeError, ValueError, OverflowError) as error:
        raise UsageError(f"the {name} mass is {mass!r}; it must be a finite number") from error
    if value <= 0:
        raise UsageError(f"the {name} mass is {mass}; it must be greater than 0")
    return value

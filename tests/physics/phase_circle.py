"""The paper's geometry, as a second way to the exact count and the region in which states stop.

In the scaled velocities V₁ = √M v₁ and V₂ = √m v₂ the energy is a circle. A collision of the
bodies moves the state along a line of slope −√(M/m) to the other crossing with the circle, one
with the wall mirrors it at the V₁ axis. Seen together: point k lies at angle ⌈k/2⌉ α from the
negative V₁ axis, below the axis for odd k and above it for even k, α = arccos((M − m)/(M + m)).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from mpmath.ctx_iv import MPIntervalContext

from count_video.physics.theory import Mass, exact_ratio, theta_rad

# π/α is an integer n only if cos α = cos(π/n) is rational; by Niven's theorem it is then 0 or 1/2.
_WHOLE_HALF_TURNS = {Fraction(1): 2, Fraction(3): 3}

BORDER = 1e-14
"""Rounding of a scaled velocity, as a fraction of the stopping region's width. Borders are only
ever met at ratios near 1, where the width is of the order of the velocities."""


def in_stopping_region(
    scaled_heavy: float, scaled_light: float, heavy: Mass, light: Mass = 1
) -> bool:
    """Whether no collision can follow the state (V₁, V₂): 0 ≤ V₂ ≤ √(m/M) V₁.

    The paper writes < on both sides. The borders belong to the region as well: on the axis the
    ball rests (1:1), on the line both bodies run at one speed (1:⅓); neither pair meets again.
    A state is on a border if it is so to within ``BORDER`` of the region's width.
    """
    width = math.tan(theta_rad(heavy, light)) * scaled_heavy
    return -BORDER * width <= scaled_light <= (1.0 + BORDER) * width


def count_by_phase_circle(heavy: Mass, light: Mass = 1) -> int:
    """Exact count by the paper's route: 2 j_max, or one more if point 2 j_max may not stop.

    j_max is the largest j with j α < π: ⌊π/α⌋ but for the two ratios (1 and 3) at which α divides
    π, where the floor would count the point on the axis itself. Point 2 j_max stops if its angle
    π − j_max α from the V₁ axis is at most φ = arctan √(m/M).
    """
    ratio = exact_ratio(heavy, light)
    bits = abs(ratio.numerator.bit_length() - ratio.denominator.bit_length()) // 2
    if ratio in _WHOLE_HALF_TURNS:
        # The point is a whole α away from the axis, twice the angle φ of the region.
        return 2 * (_WHOLE_HALF_TURNS[ratio] - 1) + 1
    j_max = certain_floor(lambda context: context.pi / _alpha(context, ratio), bits)
    if ratio == Fraction(1, 3):
        return 2 * j_max  # the point lies on the border of the region exactly

    def angle_in_region(context: Any) -> Any:
        phi = context.atan2(
            context.sqrt(context.mpf(ratio.denominator)), context.sqrt(context.mpf(ratio.numerator))
        )
        return (context.pi - j_max * _alpha(context, ratio)) / phi

    # Floor 0: below the line, the region. Floor 1 (the angle is less than α = 2φ): above it.
    return 2 * j_max + certain_floor(angle_in_region, bits)


def velocities_by_collision(heavy: Mass, light: Mass = 1) -> list[tuple[Fraction, Fraction]]:
    """Follow the collisions one by one in exact fractions, the cylinder coming in at speed 1.

    Returns (v₁, v₂) before the first collision and after each; its length is the count plus 1.
    The fractions grow with every collision: meant for hundreds, not for millions.
    """
    ratio = exact_ratio(heavy, light)
    v_heavy, v_light = Fraction(-1), Fraction(0)
    states = [(v_heavy, v_light)]
    while not 0 <= v_light <= v_heavy:
        if len(states) % 2 == 1:  # the bodies meet: conservation of momentum and energy
            centre = (ratio * v_heavy + v_light) / (ratio + 1)
            v_heavy, v_light = 2 * centre - v_heavy, 2 * centre - v_light
        else:
            v_light = -v_light
        states.append((v_heavy, v_light))
    return states


def _alpha(context: Any, ratio: Fraction) -> Any:
    """arccos((M − m)/(M + m)) as an interval, by the legs M − m and 2 √(M m) of its triangle."""
    heavy, light = ratio.numerator, ratio.denominator
    return context.atan2(2 * context.sqrt(context.mpf(heavy * light)), context.mpf(heavy - light))


def certain_floor(real: Callable[[Any], Any], scale_bits: int = 0) -> int:
    """Return the floor of a positive real number that is not an integer.

    ``real`` is called with an interval context of mpmath and returns the interval that holds the
    number; it is called again with twice the precision until both ends have the same floor. For an
    integer that would never end: the caller excludes integers by algebra. ``scale_bits`` is the
    rough number of bits before the point, a start for the precision.
    """
    context = _intervals(64 + scale_bits)
    while True:
        # The outermost eight bits of an interval's ends are not trusted: atan2 is rounded outward
        # from a value that is itself only good to some guard bits.
        doubt = context.mpf(2) ** (8 - context.prec)
        interval = real(context) * context.mpf([(1 - doubt).a, (1 + doubt).b])
        low, high = int(interval.a), int(interval.b)
        if low == high:
            return low
        context.prec *= 2


def _intervals(precision_bits: int) -> Any:
    """Return a context of interval arithmetic."""
    context = MPIntervalContext()
    context.prec = precision_bits
    return context

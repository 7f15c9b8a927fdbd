"""What the theory says of two masses, in words and as the paper's table."""

from __future__ import annotations

import math
from fractions import Fraction

from count_video.physics.theory import (
    collision_count,
    mass_ratio_interval,
    pi_bounds,
    theta_rad,
)

POWERS = range(8)
"""Exponents n of the table for 1:100^n."""


def theory_text(heavy: Fraction, light: Fraction) -> str:
    """Tell count, angles and bounds on pi as plain text, then the table for 1:100^n."""
    lines = [f"{plain(heavy)} and {plain(light)}: {_collisions(heavy, light)}", ""]
    lines += [f"  {label:<15}{words}" for label, words in facts(heavy, light)]
    lines += ["", "  m : M = 1 : 100^n", "    n  collisions  pi lies between"]
    lines += [
        f"    {power}{count:>12}  {low} and {high}" for power, count, low, high in powers_table()
    ]
    return "\n".join(lines)


def facts(heavy: Fraction, light: Fraction) -> list[tuple[str, str]]:
    """Label and words of all that the theory says of two masses."""
    theta, count = theta_rad(heavy, light), collision_count(heavy, light)
    bounds, ratios = pi_bounds(count, heavy, light), mass_ratio_interval(count)
    return [
        ("Mass ratio", f"M : m = {plain(heavy / light)} : 1"),
        ("Exact count", f"{count} = ⌈π/θ⌉ − 1"),
        ("θ", f"{_angle(theta)} = arctan √(m/M)"),
        ("α = 2θ", f"{_angle(2 * theta)} = arccos((M − m)/(M + m))"),
        ("Interval of π", f"{bounds.low:.10g} to {bounds.high:.10g}, {count} θ to {count + 1} θ"),
        ("Same count", f"for M/m above {ratios.low:.10g} up to {ratios.high:.10g}"),
    ]


def powers_table() -> list[tuple[int, int, str, str]]:
    """Rows of n, count and bounds on pi for the mass ratios 1:100^n."""
    rows = []
    for power in POWERS:
        heavy = 100**power
        count = collision_count(heavy)
        bounds = pi_bounds(count, heavy)
        decimals = power + 2
        # Rounded outward, so that what is printed still holds pi between it.
        low = math.floor(bounds.low * 10**decimals) / 10**decimals
        high = math.ceil(bounds.high * 10**decimals) / 10**decimals
        rows.append((power, count, f"{low:.{decimals}f}", f"{high:.{decimals}f}"))
    return rows


def plain(value: Fraction) -> str:
    """Write a mass or a ratio without needless digits."""
    return f"{float(value):.10g}"


def _collisions(heavy: Fraction, light: Fraction) -> str:
    return f"{collision_count(heavy, light)} collisions"


def _angle(radians: float) -> str:
    return f"{radians:.10g} rad ({math.degrees(radians):.6g}°)"

"""Whole numbers read off real ones, with proof: interval arithmetic of growing precision."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_START_BITS = 64
_GUARD_BITS = 8
"""The outermost bits of an interval's ends are not trusted: atan2 is rounded outward from a value
that is itself only good to some guard bits. The interval is widened by this many bits."""


def certain_floor(real: Callable[[Any], Any], scale_bits: int = 0) -> int:
    """Return the floor of a positive real number that is not an integer.

    Parameters
    ----------
    real
        Called with an interval context of mpmath (a private one: its precision is nobody else's);
        returns the interval that holds the number. Called again with twice the precision until
        both ends of the interval have the same floor. For an integer that would never end: the
        caller excludes integers by algebra.
    scale_bits
        Rough number of bits before the point, a start for the precision.
    """
    # mpmath is imported here because it would cost every start of the command.
    from mpmath.ctx_iv import MPIntervalContext  # noqa: PLC0415

    context = MPIntervalContext()
    context.prec = _START_BITS + scale_bits
    while True:
        doubt = context.mpf(2) ** (_GUARD_BITS - context.prec)
        interval = real(context) * context.mpf([(1 - doubt).a, (1 + doubt).b])
        low, high = int(interval.a), int(interval.b)
        if low == high:
            return low
        context.prec *= 2


def nearest_float(real: Callable[[Any], Any], precision_bits: int) -> float:
    """Return the float nearest to a real number, evaluated at ``precision_bits``."""
    from mpmath.ctx_iv import MPIntervalContext  # noqa: PLC0415

    context = MPIntervalContext()
    context.prec = precision_bits
    return float(real(context).mid)

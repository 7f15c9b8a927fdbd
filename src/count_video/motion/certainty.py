"""How sure a count of impacts is: what speaks for each of them, and for others that are not shown.

Every impact and every doubt is one independent chance: an impact that few pictures show may be
none, a flight that strays from free flight may hide one more. The count's probabilities are those
of their sum.
"""

from __future__ import annotations

from collections.abc import Sequence

CHANCE_AT_LEAST = 0.005
"""Counts less probable than this are left out."""


def chances_of_sum(chances: Sequence[float]) -> dict[int, float]:
    """Probability of each number of independent events that come true, given the chance of each."""
    sums = [1.0]
    for chance in chances:
        missed = [share * (1 - chance) for share in (*sums, 0.0)]
        met = [share * chance for share in (0.0, *sums)]
        sums = [a + b for a, b in zip(missed, met, strict=True)]
    likely = {number: share for number, share in enumerate(sums) if share >= CHANCE_AT_LEAST}
    total = sum(likely.values())
    return {number: share / total for number, share in likely.items()}

"""Rows of a campaign's table, made by hand."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

from count_video.records import Ending, Estimate, TrialResult
from count_video.reports.campaign import TrialRow

Masses = tuple[Fraction, Fraction] | None


def row(
    name: str = "trial",
    count: int | None = 31,
    chance: float = 1.0,
    *,
    masses: Masses = None,
    not_kept: str | None = None,
    files: frozenset[str] = frozenset(),
    **changes: Any,
) -> TrialRow:
    """Return a row with a count of some probability, or one not counted for a count of None.

    ``changes`` are fields of the result; ``restitution_wall=0.9`` stands for that value, and
    ``ending="geometric"`` for that kind.
    """
    values: dict[str, Any] = {}
    if count is not None:
        chances = {count: chance} | ({count - 1: 1 - chance} if chance < 1 else {})
        values |= {"status": "counted", "reason": None, "count": count, "seen": count}
        values |= {"between_frames": 0, "probability": chances}
        values |= {"mass_ratio": 100.0, "mass_ratio_sigma": 1.0}
    for kind in ("restitution_bodies", "restitution_wall"):
        if kind in changes:
            changes[kind] = Estimate(changes[kind], 0.01)
    if "ending" in changes:
        changes["ending"] = Ending(changes["ending"], 1.0, 1.0, 0.5)
    result = replace(
        TrialResult(f"clips/{name}.mp4", "not_counted", "nothing moves"), **values | changes
    )
    return TrialRow(name, result, masses, not_kept, files)


def rows_of(histogram: dict[int, int]) -> list[TrialRow]:
    """Return so many rows with each count."""
    return [
        row(f"trial{count}-{number}", count)
        for count, many in histogram.items()
        for number in range(many)
    ]

"""Rows of a campaign's table, made by hand."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from count_video.records import unread_result
from count_video.reports.campaign import TrialRow
from count_video.reports.json_object import json_object

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

    ``changes`` are keys of the JSON object; ``restitution_wall=0.9`` stands for that value.
    """
    result: dict[str, Any] = json_object(unread_result(f"clips/{name}.mp4", "nothing moves"))
    if count is not None:
        chances = {str(count): chance} | ({str(count - 1): 1 - chance} if chance < 1 else {})
        result |= {"status": "counted", "reason": None, "count": count, "seen": count}
        result |= {"between_frames": 0, "probability": chances}
        result |= {"mass_ratio": 100.0, "mass_ratio_sigma": 1.0}
    for kind in ("bodies", "wall"):
        value = changes.pop(f"restitution_{kind}", None)
        if value is not None:
            result["restitution"] = {kind: {"value": value, "sigma": 0.01}}
    if "ending" in changes:
        changes["ending"] = {"kind": changes["ending"]}
    return TrialRow(name, result | changes, masses, not_kept, files)


def rows_of(histogram: dict[int, int]) -> list[TrialRow]:
    """Return so many rows with each count."""
    return [
        row(f"trial{count}-{number}", count)
        for count, many in histogram.items()
        for number in range(many)
    ]

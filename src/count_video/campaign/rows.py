"""From a result, as JSON, to its row in the campaign's table."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from count_video.campaign.plan import Job
from count_video.physics.theory import collision_count
from count_video.reports.campaign_rows import TrialRow
from count_video.reports.json_object import json_object
from count_video.verdict import unread_result

_KEYS = frozenset(json_object(unread_result("", "")))
_TYPES: Mapping[str, tuple[type, ...]] = {
    "clip": (str,),
    "status": (str,),
    "reason": (str, type(None)),
    **dict.fromkeys(("count", "seen", "between_frames"), (int, type(None))),
    **dict.fromkeys(("capture_fps", "mass_ratio", "pi_low", "pi_high"), (int, float, type(None))),
    "probability": (dict,),
}
"""What the table needs of a result. A file may have been edited, or be of another program."""


def read_result(text: str) -> dict[str, Any]:
    """Parse a result's JSON text.

    Raises
    ------
    ValueError
        It is no result of this program.
    """
    try:
        result = json.loads(text)
    except RecursionError as error:
        raise ValueError("nested too deeply") from error
    if not isinstance(result, dict) or not result.keys() >= _KEYS:
        raise ValueError("no result")
    if result["status"] not in ("counted", "not_counted"):
        raise ValueError("no status")
    chances = result["probability"]
    for values, types in (
        *(([result[key]], types) for key, types in _TYPES.items()),
        (chances.values() if isinstance(chances, dict) else (), (int, float)),
    ):
        if any(not isinstance(value, types) or isinstance(value, bool) for value in values):
            raise ValueError("a value of another type")
    for count in chances:
        int(count)
    return result


def row_of(
    job: Job, text: str, not_kept: str | None = None, files: frozenset[str] = frozenset()
) -> TrialRow:
    """Read a result's JSON text; one path for results of this run and of earlier ones.

    Raises
    ------
    ValueError
        It is no result of this program.
    """
    result = read_result(text)
    restitution = result.get("restitution")
    return TrialRow(
        name=job.name,
        clip=result["clip"],
        status=result["status"],
        count=result["count"],
        chances={int(count): chance for count, chance in result["probability"].items()},
        reason=result["reason"],
        not_kept=not_kept,
        seen=result["seen"],
        between_frames=result["between_frames"],
        capture_fps=result["capture_fps"],
        mass_ratio=result["mass_ratio"],
        theory=None if job.settings.masses is None else collision_count(*job.settings.masses),
        pi_low=result["pi_low"],
        pi_high=result["pi_high"],
        restitution_bodies=_value(_part(restitution, "bodies")),
        restitution_wall=_value(_part(restitution, "wall")),
        energy_kept=_value(result.get("energy_kept")),
        ending=_word(result.get("ending")),
        files=files,
    )


def _part(value: object, key: str) -> object:
    return value.get(key) if isinstance(value, Mapping) else None


def _value(value: object) -> float | None:
    """Return a number, one with its uncertainty, or the last of a list; None for all else."""
    if isinstance(value, Mapping):
        value = value.get("value")
    if isinstance(value, list):
        value = value[-1] if value else None
    return float(value) if isinstance(value, int | float) else None


def _word(value: object) -> str | None:
    if isinstance(value, Mapping):
        value = value.get("kind")
    return value if isinstance(value, str) else None

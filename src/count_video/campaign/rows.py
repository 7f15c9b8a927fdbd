"""From a result, as JSON, to its row in the campaign's table."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from count_video.campaign.plan import Job
from count_video.inputs import Range, stored_number
from count_video.physics.theory import collision_count
from count_video.reports.campaign_rows import TrialRow
from count_video.reports.json_object import json_object
from count_video.verdict import unread_result

_KEYS = frozenset(json_object(unread_result("", "")))
_COUNT = Range(0, 1e9, "")
_CHANCE = Range(0, 1.001, "")
_FIGURE = Range(-1e50, 1e50, "")
_WHOLE = ("count", "seen", "between_frames")
_FIGURES = ("capture_fps", "mass_ratio", "pi_low", "pi_high")


def read_result(text: str) -> dict[str, Any]:
    """Parse a result's JSON text, and check what tables need of it.

    Raises
    ------
    ValueError
        It is no result of this program: a file may have been edited, or be of another program.
    """
    try:
        result = json.loads(text)
    except RecursionError as error:
        raise ValueError("nested too deeply") from error
    if not isinstance(result, dict) or not result.keys() >= _KEYS:
        raise ValueError("no result")
    status, count, chances = result["status"], result["count"], result["probability"]
    if (
        not isinstance(result["clip"], str)
        or not isinstance(result["reason"], str | None)
        or not isinstance(chances, dict)
        or (status, count is None) not in (("counted", False), ("not_counted", True))
        or not all(_is_number(result[key], _COUNT, whole=True) for key in _WHOLE)
        or not all(_is_number(result[key], _FIGURE) for key in _FIGURES)
        or not all(stored_number(chance, _CHANCE) is not None for chance in chances.values())
        or not all(counted.isascii() and counted.isdecimal() for counted in chances)
    ):
        raise ValueError("a value that no result has")
    return result


def _is_number(value: object, allowed: Range, *, whole: bool = False) -> bool:
    """Return whether a value is null or a number in its range."""
    if value is None:
        return True
    return stored_number(value, allowed) is not None and (isinstance(value, int) or not whole)


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
    return stored_number(value, _FIGURE)


def _word(value: object) -> str | None:
    if isinstance(value, Mapping):
        value = value.get("kind")
    return value if isinstance(value, str) else None

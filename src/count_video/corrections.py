"""A person's corrections of a count: read from the file that the page saves, laid over a result.

The file is one JSON object: ``corrections_version`` 1, ``clip`` (the file's name without its
folders), and ``corrections``, a list of objects with ``action`` (``wrong`` or ``missed``),
``kind``, ``frame`` and, where a collision is wrong, its ``number``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import ParamSpec

from count_video.errors import UsageError
from count_video.records import Collision, Correction, TrialResult
from count_video.reports.printable import storable

CORRECTIONS_VERSION = 1
SAME_COLLISION_FRAMES = 1.0
"""A collision is the one meant if it has the kind and lies this close: another version of the tool
may place it a little differently, and give it another number."""
MOST_BYTES = 10_000_000
"""A larger file is not one that the page has saved."""


_Request = ParamSpec("_Request")


def with_corrections(
    count: Callable[_Request, TrialResult], path: Path
) -> Callable[_Request, TrialResult]:
    """Let a function that counts a clip lay the corrections of a file over its result."""

    def count_reviewed(*args: _Request.args, **kwargs: _Request.kwargs) -> TrialResult:
        return reviewed(count(*args, **kwargs), path)

    return count_reviewed


def reviewed(result: TrialResult, path: Path) -> TrialResult:
    """Lay the corrections of a file over a result.

    Raises
    ------
    UsageError
        If the file cannot be read, belongs to another clip, or corrects what is not there.
    """
    stored = _stored(path)
    clip = storable(Path(result.clip).name)
    if stored.get("clip") != clip:
        raise UsageError(
            f"{path}: these corrections are for {stored.get('clip')!r}, not for {clip!r}; "
            "give the file that was saved for this clip"
        )
    entries = stored.get("corrections")
    if not isinstance(entries, list):
        raise UsageError(f"{path}: has no list of corrections; save the file again from the page")
    corrections = tuple(_correction(entry, result, path) for entry in entries)
    numbers = [c.number for c in corrections if c.number is not None]
    if len(numbers) != len(set(numbers)):
        raise UsageError(f"{path}: marks one collision wrong twice; save the file again")
    return replace(
        result,
        corrections=corrections,
        reviewed_count=burst_size(result) + sum(_step(correction) for correction in corrections),
    )


def burst_size(result: TrialResult) -> int:
    """How many of the collisions found belong to the burst, counted or not."""
    return result.count if result.count is not None else result.seen or 0


def _step(correction: Correction) -> int:
    if not correction.changes_count:
        return 0
    return 1 if correction.action == "missed" else -1


def _stored(path: Path) -> dict[str, object]:
    """Parse the file, refusing everything that the page cannot have written."""
    try:
        with path.open("rb") as file:
            text = file.read(MOST_BYTES + 1)
        stored = json.loads(text) if len(text) <= MOST_BYTES else None
    except OSError as error:
        raise UsageError(f"{path}: cannot read the corrections: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{path}: is no JSON; give the file that the page saved") from error
    if not isinstance(stored, dict) or stored.get("corrections_version") != CORRECTIONS_VERSION:
        raise UsageError(
            f"{path}: is no file of corrections, version {CORRECTIONS_VERSION}; "
            "give the file that the page saved"
        )
    return stored


def _correction(entry: object, result: TrialResult, path: Path) -> Correction:
    if not isinstance(entry, dict):
        raise UsageError(f"{path}: {entry!r} is no correction; save the file again from the page")
    action, kind, frame = entry.get("action"), entry.get("kind"), entry.get("frame")
    if (
        action not in ("wrong", "missed")
        or kind not in ("bodies", "wall")
        or isinstance(frame, bool)
        or not isinstance(frame, int | float)
        or not (math.isfinite(frame) and frame >= 0)
    ):
        raise UsageError(f"{path}: {entry!r} is no correction; save the file again from the page")
    if action == "missed":
        return Correction("missed", kind, float(frame), None, _before_the_end(frame, result))
    wrong = _meant([c for c in result.collisions if c.kind == kind], frame)
    if wrong is None:
        raise UsageError(
            f"{path}: corrects a collision ({kind}, frame {frame:.6g}) that is not in the result; "
            "correct this result on its own page"
        )
    return Correction("wrong", kind, wrong.frame, wrong.number, wrong.number <= burst_size(result))


def _meant(collisions: Sequence[Collision], frame: float) -> Collision | None:
    nearest = min(collisions, key=lambda c: abs(c.frame - frame), default=None)
    if nearest is None or abs(nearest.frame - frame) > SAME_COLLISION_FRAMES:
        return None
    return nearest


def _before_the_end(frame: float, result: TrialResult) -> bool:
    """Whether a missed collision belongs to the burst: no collision beyond it came before."""
    beyond = [c.frame for c in result.collisions if c.number > burst_size(result)]
    return frame < min(beyond, default=math.inf)

"""A person's corrections of a count: read from the file that the page saves, laid over a result.

The file is one JSON object: ``corrections_version`` 1, ``clip`` (the file's name without its
folders), ``clip_sha256`` (the digest of its bytes), ``tool_count`` (the count that was corrected),
and ``corrections``, a list of objects with ``action`` (``wrong`` or ``missed``), ``kind``,
``frame`` and, where a collision is wrong, its ``number``. It may have ``notes`` as well: texts by
what they are on, as ``records.TrialResult`` has them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from count_video.errors import UsageError
from count_video.inputs import FRAME, content_digest, read_json_object, shown, stored_number
from count_video.records import SAME_COLLISION_FRAMES, Collision, Correction, TrialResult
from count_video.reports.exports import plain
from count_video.reports.words import storable

CORRECTIONS_VERSION = 1


def reviewed(result: TrialResult, path: Path) -> TrialResult:
    """Lay the corrections of a file over a result; UsageError if they do not belong to it."""
    stored = read_json_object(path)
    if stored.get("corrections_version") != CORRECTIONS_VERSION:
        raise UsageError(
            f"{path}: is no file of corrections, version {CORRECTIONS_VERSION}; "
            "give the file that the page saved"
        )
    changed = _changed_count(stored, result, path)
    entries = stored.get("corrections")
    if not isinstance(entries, list):
        raise UsageError(f"{path}: has no list of corrections; save the file again from the page")
    corrections = tuple(
        _correction(entry, result, f"{path}, correction {place}")
        for place, entry in enumerate(entries, 1)
    )
    if len(set(corrections)) < len(corrections):
        raise UsageError(f"{path}: makes one correction twice; save the file again from the page")
    notes = stored.get("notes", {})
    if not isinstance(notes, dict) or not all(isinstance(note, str) for note in notes.values()):
        raise UsageError(f"{path}: its notes are no texts; save the file again from the page")
    steps = (1 if c.action == "missed" else -1 for c in corrections if c.changes_count)
    return replace(
        result,
        corrections=corrections,
        notes={_place_of_note(str(key), result): note for key, note in notes.items()},
        reviewed_count=result.burst_size + sum(steps),
        warnings=(*result.warnings, *changed),
    )


def _changed_count(stored: Mapping[str, object], result: TrialResult, path: Path) -> list[str]:
    """Refuse corrections of another clip; return a sentence if they were made to another count."""
    name = storable(Path(result.clip).name)
    other = stored.get("clip")
    if other != name:
        whose = shown(other) if isinstance(other, str) else "no clip"
        raise UsageError(
            f"{path}: these corrections are for {whose}, not for {shown(name)}; "
            "give the file that was saved for this clip"
        )
    digest = stored.get("clip_sha256")
    if digest and digest != content_digest(Path(result.clip)):
        raise UsageError(
            f"{path}: these corrections are for another clip called {shown(name)}, or for this "
            "one before it changed; give the file that was saved for this clip"
        )
    count = stored.get("tool_count", result.count)
    if count == result.count:
        return []
    if count is not None and stored_number(count, FRAME) is None:
        raise UsageError(f"{path}: its count is no number; save the file again from the page")
    before, now = ("not counted" if one is None else str(one) for one in (count, result.count))
    counts = f"{before}, now {now}"
    if not digest:
        raise UsageError(
            f"{path}: these corrections were made to another count ({counts}), perhaps of another "
            "clip of this name; correct this result on its own page"
        )
    return [f"the corrections were made when the tool's count was another: {counts}"]


def _correction(entry: object, result: TrialResult, where: str) -> Correction:
    fields = entry if isinstance(entry, dict) else {}
    action, kind = fields.get("action"), fields.get("kind")
    frame = stored_number(fields.get("frame"), FRAME)
    if action not in ("wrong", "missed") or kind not in ("bodies", "wall") or frame is None:
        raise UsageError(f"{where}: needs an action, a kind and a frame; save the file again")
    if result.frames_decoded is not None and frame >= result.frames_decoded:
        raise UsageError(
            f"{where}: frame {frame:.15g} is not in the clip, which has {result.frames_decoded}"
        )
    if action == "missed":
        # It belongs to the burst if no collision beyond it came before.
        ends = min((c.frame for c in result.beyond_burst), default=math.inf)
        return Correction("missed", kind, frame, None, frame < ends)
    wrong = _meant(result, kind, frame)
    if wrong is None:
        raise UsageError(
            f"{where}: there is no such collision ({kind}, frame {frame:.6g}) in the result; "
            "correct this result on its own page"
        )
    return Correction("wrong", kind, wrong.frame, wrong.number, wrong.number <= result.burst_size)


def _meant(result: TrialResult, kind: str, frame: float) -> Collision | None:
    """Find the collision of a kind that is meant by a frame."""
    near = [c for c in result.collisions if abs(c.frame - frame) <= SAME_COLLISION_FRAMES]
    alike = [c for c in near if c.kind == kind]
    return min(alike, key=lambda c: abs(c.frame - frame), default=None)


def _place_of_note(key: str, result: TrialResult) -> str:
    """Name what a note is on by the result's own collision, if it is on one."""
    try:
        number, kind, frame = key.split("/")
        meant = None if number == "+" else _meant(result, kind, float(frame))
    except ValueError:  # it is on the clip, or on something that this tool does not know
        return key
    return key if meant is None else f"{meant.number}/{meant.kind}/{plain(meant.frame):.15g}"

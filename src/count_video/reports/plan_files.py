"""A plan in a folder: its picture for screen and print, its map as a table, page and values."""

from __future__ import annotations

import json
import os
from pathlib import Path

from count_video.errors import UsageError
from count_video.planning.whole import Plan
from count_video.progress import NO_PROGRESS, Progress
from count_video.reports.drawing import picture_bytes
from count_video.reports.picture_plan_map import map_csv
from count_video.reports.plan_json import plan_object
from count_video.reports.plan_page import plan_page
from count_video.reports.plan_picture import plan_figure


def write_plan(plan: Plan, folder: Path, progress: Progress = NO_PROGRESS) -> None:
    """Write ``plan.json``, ``plan.csv``, ``plan.html``, ``plan.png`` and ``plan.svg``.

    The folder is made if needed; each file appears when it is complete.

    Raises
    ------
    UsageError
        If one cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _unwritable(folder, error) from error
    progress.start(3, "drawing")
    _write(folder / "plan.json", json.dumps(plan_object(plan), indent=1).encode("ascii") + b"\n")
    if plan.chart is not None:
        _write(folder / "plan.csv", map_csv(plan.chart).encode("ascii"))
    _write(folder / "plan.html", plan_page(plan).encode("utf-8"))
    progress.advance(1)
    figure = plan_figure(plan)
    for picture_format in ("png", "svg"):
        _write(folder / f"plan.{picture_format}", picture_bytes(figure, picture_format))
        progress.advance(1)
    progress.finish()


def _write(target: Path, data: bytes) -> None:
    """Let a file appear under its name when it is complete."""
    partial = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        partial.write_bytes(data)
        os.replace(partial, target)
    except OSError as error:
        raise _unwritable(target, error) from error
    finally:
        partial.unlink(missing_ok=True)


def _unwritable(path: Path, error: OSError) -> UsageError:
    reason = error.strerror or "it failed"
    return UsageError(f"cannot write {path}: {reason}; give another folder with -o")

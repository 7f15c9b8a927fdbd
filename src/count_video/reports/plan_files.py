"""A plan in a folder: its picture for screen and print, its map as a table, page and values."""

from __future__ import annotations

import json
from pathlib import Path

from count_video.errors import UsageError
from count_video.outputs import OutputFolder, open_outputs
from count_video.planning.whole import Plan
from count_video.progress import NO_PROGRESS, Progress
from count_video.reports.drawing import picture_bytes
from count_video.reports.picture_plan_map import map_csv
from count_video.reports.plan_json import plan_object
from count_video.reports.plan_page import plan_page
from count_video.reports.plan_picture import plan_figure

NAMES = ("plan.json", "plan.csv", "plan.html", "plan.png", "plan.svg")


def open_folder(folder: Path) -> OutputFolder:
    """Open the folder that a plan goes to, made if needed, before the plan is worked out.

    Raises
    ------
    UsageError
        It cannot be made, or has files of these names that this program did not write.
    """
    outputs = open_outputs(folder)
    for name in NAMES:
        outputs.check(name)
    return outputs


def write_plan(plan: Plan, outputs: OutputFolder, progress: Progress = NO_PROGRESS) -> None:
    """Write ``plan.json``, ``plan.csv``, ``plan.html``, ``plan.png`` and ``plan.svg``.

    Each file appears when it is complete.

    Raises
    ------
    UsageError
        If one cannot be written, or would replace what this program did not write.
    """
    progress.start(3, "drawing")
    text = json.dumps(plan_object(plan), indent=1)
    _write(outputs, "plan.json", text.encode("ascii") + b"\n")
    if plan.chart is not None:
        _write(outputs, "plan.csv", map_csv(plan.chart).encode("ascii"))
    _write(outputs, "plan.html", plan_page(plan).encode("utf-8"))
    progress.advance(1)
    figure = plan_figure(plan)
    for picture_format in ("png", "svg"):
        _write(outputs, f"plan.{picture_format}", picture_bytes(figure, picture_format))
        progress.advance(1)
    progress.finish()


def _write(outputs: OutputFolder, name: str, data: bytes) -> None:
    try:
        outputs.write(name, data)
    except OSError as error:
        reason = error.strerror or "it failed"
        place = outputs.folder / name
        raise UsageError(f"cannot write {place}: {reason}; give another folder with -o") from error

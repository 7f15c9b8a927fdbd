"""A campaign's manifest: a CSV file with a clip a line and what is special about it.

The column ``clip`` is needed; its paths start at the manifest's folder. The others are called as
the options are and take what those take; an empty cell leaves what the command line says.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from count_video import inputs
from count_video.errors import UsageError
from count_video.inputs import shown
from count_video.trial import TrialSettings

MANIFEST_SUFFIX = ".csv"
WITH_DECIMALS = frozenset({"masses", "capture_fps", "ball_diameter_mm"})
"""Columns whose numbers may have decimals."""


def _masses(cell: str) -> object:
    two = cell.split()
    if len(two) != 2:
        raise UsageError(f"{shown(cell)} is not two masses, heavy and light")
    return inputs.masses(inputs.mass(two[0]), inputs.mass(two[1]))


def _wall(cell: str) -> str:
    if cell not in ("left", "right"):
        raise UsageError(f"{shown(cell)} is not left or right")
    return cell


READERS: Mapping[str, tuple[str, Callable[[str], object]]] = {
    "region": ("region", inputs.region),
    "masses": ("masses", _masses),
    "wall": ("wall_side", _wall),
    "capture_fps": ("capture_fps", inputs.capture_rate),
    "start": ("start", inputs.frame),
    "end": ("end", inputs.frame),
    "ball_diameter_mm": ("ball_diameter_mm", inputs.ball_diameter),
}
"""For every column the setting that it sets, and what reads its cells, as the options are read."""


@dataclass(frozen=True)
class ManifestLine:
    """One trial of a manifest."""

    name: str
    """Name to keep the result under; empty where none is given."""
    clip: Path
    settings: TrialSettings


def read_manifest(path: Path, settings: TrialSettings) -> list[ManifestLine]:
    """Read a manifest; what a line leaves open is taken from ``settings``.

    Raises
    ------
    UsageError
        The file cannot be read, has no clip, or a line says what makes no sense.
    """
    text = inputs.read_text(path, inputs.MOST_MANIFEST_BYTES)
    lines = []
    try:
        for where, cells in _cells(path, text):
            lines.append(_line(path, where, cells, settings))
    except csv.Error as error:
        raise UsageError(f"{path}: {error}; quote cells as a spreadsheet does") from error
    if not lines:
        raise UsageError(f"{path}: the manifest names no clip; add a line a clip")
    return lines


def _cells(path: Path, text: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield where a line stands and its cells by column."""
    head = text.partition("\n")[0]
    delimiter = ";" if ";" in head and "," not in head else ","
    # Not splitlines: signs that it takes for the end of a line may stand in a name.
    reader = csv.DictReader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    known = ("clip", "name", *READERS)
    columns = [column.strip().lower() for column in reader.fieldnames or ()]
    unknown = [column for column in columns if column not in known]
    if "clip" not in columns or unknown or len(set(columns)) < len(columns):
        raise UsageError(
            f"{path}: the first line must name the columns, each once, clip among them; "
            f"there are: {', '.join(known)}"
        )
    reader.fieldnames = columns
    for row in reader:
        where = f"{path}, line {reader.line_num}"
        if None in row:
            raise UsageError(f"{where}: more cells than columns; quote a cell with a comma")
        yield where, {column: _cell(column, cell, delimiter) for column, cell in row.items()}


def _cell(column: str, cell: str | None, delimiter: str) -> str:
    """Return a cell; where semicolons stand between cells, a number may have a decimal comma."""
    text = (cell or "").strip()
    decimal_commas = delimiter == ";" and column in WITH_DECIMALS
    return text.replace(",", ".") if decimal_commas else text


def _line(
    path: Path, where: str, cells: Mapping[str, str], settings: TrialSettings
) -> ManifestLine:
    name = cells.get("name", "")
    if not cells["clip"]:
        raise UsageError(f"{where}: no clip; write its path in the column clip")
    if any(sign in name for sign in "/\\\0") or name.startswith("."):
        raise UsageError(
            f"{where}: {shown(name)} is no name for a file; leave out slashes and dots"
        )
    try:
        clip = path.parent / inputs.some_path(cells["clip"])
        settings = replace(settings, **_told(cells))
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from error
    if settings.end is not None and settings.start >= settings.end:
        raise UsageError(f"{where}: start {settings.start} leaves no frame before {settings.end}")
    return ManifestLine(name, clip, settings)


def _told(cells: Mapping[str, str]) -> dict[str, Any]:
    """Return the settings that a line gives."""
    return {
        setting: read(cells[column])
        for column, (setting, read) in READERS.items()
        if cells.get(column)
    }

"""A campaign's manifest: a CSV file with a clip a line and what is special about it.

The column ``clip`` is needed; its paths start at the manifest's folder. The others are called as
the options are and take what those take; an empty cell leaves what the command line says.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from count_video.errors import UsageError
from count_video.options import read_options
from count_video.trial import TrialSettings

MANIFEST_SUFFIX = ".csv"
OPTION_OF_COLUMN: Mapping[str, tuple[str, str]] = {
    "region": ("--region", "region"),
    "masses": ("--masses", "masses"),
    "wall": ("--wall", "wall_side"),
    "capture_fps": ("--capture-fps", "capture_fps"),
    "start": ("--start", "start"),
    "end": ("--end", "end"),
    "ball_diameter_mm": ("--ball-diameter-mm", "ball_diameter_mm"),
}
"""For every column the option that reads its cells, and the setting that it sets."""


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
    try:
        text = path.read_text("utf-8-sig")  # spreadsheets put a mark in front
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{path}: not readable as a manifest ({error}); check the file") from error
    lines = [_line(path, where, cells, settings) for where, cells in _cells(path, text)]
    if not lines:
        raise UsageError(f"{path}: the manifest names no clip; add a line a clip")
    return lines


def _cells(path: Path, text: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield where a line stands and its cells by column."""
    head = text.partition("\n")[0]
    delimiter = ";" if ";" in head and "," not in head else ","
    reader = csv.DictReader(text.splitlines(), delimiter=delimiter, strict=True)
    known = ("clip", "name", *OPTION_OF_COLUMN)
    columns = [column.strip().lower() for column in reader.fieldnames or ()]
    unknown = [column for column in columns if column not in known]
    if "clip" not in columns or unknown or len(set(columns)) < len(columns):
        raise UsageError(
            f"{path}: the first line must name the columns, each once, clip among them; "
            f"there are: {', '.join(known)}"
        )
    reader.fieldnames = columns
    try:
        for row in reader:
            where = f"{path}, line {reader.line_num}"
            if None in row:
                raise UsageError(f"{where}: more cells than columns; quote a cell with a comma")
            yield where, {column: (cell or "").strip() for column, cell in row.items()}
    except csv.Error as error:
        raise UsageError(f"{path}, line {reader.line_num}: {error}") from error


def _line(
    path: Path, where: str, cells: Mapping[str, str], settings: TrialSettings
) -> ManifestLine:
    name = cells.get("name", "")
    if not cells["clip"]:
        raise UsageError(f"{where}: no clip; write its path in the column clip")
    if any(sign in name for sign in "/\\\0") or name.startswith("."):
        raise UsageError(f"{where}: {name!r} is no name for a file; leave out slashes and dots")
    try:
        settings = replace(settings, **_told(cells))
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from error
    if settings.end is not None and settings.start >= settings.end:
        raise UsageError(f"{where}: start {settings.start} leaves no frame before {settings.end}")
    return ManifestLine(name, path.parent / cells["clip"], settings)


def _told(cells: Mapping[str, str]) -> dict[str, Any]:
    """Return the settings that a line gives, read as the options read them."""
    told: dict[str, Any] = {}
    for column, (option, setting) in OPTION_OF_COLUMN.items():
        cell = cells.get(column, "")
        if cell:
            given = [option, *cell.split()] if column == "masses" else [f"{option}={cell}"]
            value = getattr(read_options([*given, "--", "clip"]), setting)
            told[setting] = tuple(value) if column == "masses" else value
    return told

"""What a campaign has to count: from files, folders and manifests to one job a trial.

A manifest is a CSV file with a clip a line and what is special about it. The column ``clip`` is
needed; its paths start at the manifest's folder. The others are called as the options are and take
what those take; an empty cell leaves what the command line says.
"""

from __future__ import annotations

import csv
import io
import os
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from count_video import inputs
from count_video.answers import Followed
from count_video.errors import FootageError, UsageError
from count_video.inputs import shown
from count_video.outputs import OutputFolder, output_name
from count_video.settings import READERS, EvidenceSettings, TrialSettings

VIDEO_SUFFIXES = (
    *(".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm"),
    *(".3gp", ".mpg", ".mpeg", ".mts", ".m2ts", ".wmv"),
)
"""Which files of a folder are taken for clips; upper and lower case alike."""
WITH_DECIMALS = frozenset({"masses", "capture_fps", "ball_diameter_mm"})
"""Columns whose numbers may have decimals."""


@dataclass(frozen=True)
class Job:
    """One trial to count."""

    name: str
    """Its result is kept as ``NAME.json``; no two of a campaign are alike."""
    clip: str
    """The clip as the user named it."""
    settings: TrialSettings
    problem: str | None = None
    """Why there is no clip to count; None for a clip."""
    pages: EvidenceSettings | None = None
    """Evidence that the trial gets; None where the count alone is wanted."""
    start: str = ""
    """Folder at which relative paths start; a worker of a cluster runs in one of its own."""
    found: Followed | None = None
    """What an earlier run counted and followed, from which pages can be drawn; None if nothing."""

    @property
    def file(self) -> Path:
        """Where the clip lies."""
        return Path(self.start, self.clip)


def jobs_of(
    paths: Iterable[Path], settings: TrialSettings, pages: EvidenceSettings | None = None
) -> list[Job]:
    """List the trials that files, folders and manifests stand for, in the order given.

    A folder stands for its clips in natural order, a manifest (``.csv``) for its lines; what a
    folder's own ``manifest.csv`` says of clips is heeded. A folder without a clip, or one that
    cannot be read, is a job with its problem; UsageError for a manifest that makes no sense.
    """
    taken = {"campaign": 2}  # its results would overwrite the campaign's own files
    wanted = (job for path in paths for job in _wanted(path, settings))
    try:
        start = os.getcwd()
    except OSError as error:
        raise UsageError("the current folder is gone; change to one that is there") from error
    jobs = [replace(job, name=_free_name(job, taken), pages=pages, start=start) for job in wanted]
    _check_listed_once(jobs)
    return jobs


def _check_listed_once(jobs: Iterable[Job]) -> None:
    """Raise UsageError if a trial would be summed up twice: one clip with the same settings."""
    seen: set[tuple[str, TrialSettings]] = set()
    for job in jobs:
        trial = os.path.realpath(job.clip), job.settings
        if trial in seen:
            raise UsageError(f"{job.clip}: is listed twice with the same settings; list it once")
        seen.add(trial)


def clips_in(folder: Path) -> list[Path]:
    """List the video files of a folder (not of its subfolders), clip2 before clip10.

    Annotated clips that this program wrote there are left out. FootageError if there is none.
    """
    written = OutputFolder(folder).written()
    clips = [
        entry
        for entry in folder.iterdir()
        if entry.suffix.lower() in VIDEO_SUFFIXES
        and entry.name not in written
        and not entry.name.startswith(".")  # what other systems leave beside a clip
        and not entry.is_dir()  # a link that leads nowhere has a row that says so
    ]
    if not clips:
        raise FootageError(
            f"no video file in this folder (none that ends in {' '.join(VIDEO_SUFFIXES)}); give "
            "the folder that has the clips"
        )

    def natural_order(path: Path) -> tuple[list[str | int], str]:
        # Splitting at a captured group alternates text and digits, so that like meets like.
        parts = re.split(r"(\d+)", path.name.casefold())
        return [int(part) if part.isdecimal() else part for part in parts], path.name

    return sorted(clips, key=natural_order)


def _wanted(path: Path, settings: TrialSettings) -> Iterator[Job]:
    """Yield jobs whose names are wishes; a folder's manifest comes before its other clips."""
    if path.suffix.lower() == ".csv":
        yield from read_manifest(path, settings)
        return
    if not os.path.isdir(path):
        yield Job("", str(path), settings)
        return
    manifest = path / "manifest.csv"
    listed = read_manifest(manifest, settings) if os.path.isfile(manifest) else []
    yield from listed
    known = {os.path.realpath(job.clip) for job in listed}
    try:
        clips = clips_in(path)
    except (FootageError, OSError) as error:
        if not listed:
            problem = str(error)
            if isinstance(error, OSError):
                problem = f"this folder cannot be read ({error.strerror}); check its rights"
            yield Job("", str(path), settings, problem)
    else:
        others = (clip for clip in clips if os.path.realpath(clip) not in known)
        yield from (Job("", str(clip), settings) for clip in others)


def _free_name(job: Job, taken: dict[str, int]) -> str:
    """Choose and take the shortest free name; ``taken`` has the next number for each name.

    Where clips of two folders have one name, the folder's name comes before it.
    """
    full = job.file.name or "clip"
    stem = job.name or job.file.stem or full
    folder = Path(os.path.abspath(job.clip)).parent
    anywhere, here = f"/{_alike(stem)}", f"{folder}/{_alike(stem)}"
    elsewhere = anywhere in taken and here not in taken
    wishes = (stem, f"{folder.name}-{stem}" if elsewhere else full, f"{folder.name}-{full}")
    taken |= {anywhere: 2, here: 2}
    for name in map(output_name, wishes[:1] if job.name else wishes):
        if _alike(name) not in taken:
            taken[_alike(name)] = 2
            return name
    number = taken[_alike(stem)]
    while _alike(name := output_name(f"{stem}-{number}")) in taken:
        number += 1
    taken[_alike(stem)], taken[_alike(name)] = number + 1, 2
    return name


def _alike(name: str) -> str:
    """Return what is the same for names that many file systems hold for the same one."""
    return unicodedata.normalize("NFC", output_name(name)).casefold()


def read_manifest(path: Path, settings: TrialSettings) -> list[Job]:
    """Read a manifest; what a line leaves open is taken from ``settings``."""
    text = inputs.read_text(path, inputs.MOST_MANIFEST_BYTES)
    try:
        jobs = [_job(path, where, cells, settings) for where, cells in _cells(path, text)]
    except csv.Error as error:
        raise UsageError(f"{path}: {error}; quote cells as a spreadsheet does") from error
    if not jobs:
        raise UsageError(f"{path}: the manifest names no clip; add a line a clip")
    return jobs


def _cells(path: Path, text: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield where a line stands and its cells by column."""
    head = text.partition("\n")[0]
    delimiter = ";" if ";" in head and "," not in head else ","
    # Not splitlines: signs that it takes for the end of a line may stand in a name.
    reader = csv.DictReader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    known = ("clip", "name", *READERS)
    columns = [column.strip().lower() for column in reader.fieldnames or ()]
    unknown = [shown(column) for column in columns if column not in known]
    if "clip" not in columns or unknown or len(set(columns)) < len(columns):
        wrong = f" and not {', '.join(unknown)}" if unknown else ""
        raise UsageError(
            f"{path}: the first line must name the columns{wrong}, each once, clip among them, "
            f"with a comma or semicolon between two; there are: {', '.join(known)}"
        )
    reader.fieldnames = columns
    for row in reader:
        where = f"{path}, line {reader.line_num}"
        if not any("".join(cell or "").strip() for cell in row.values()):
            continue  # a line that a spreadsheet leaves, of nothing but separators
        if None in row:
            raise UsageError(f"{where}: more cells than columns; quote a cell with a comma")
        cells = {column: (cell or "").strip() for column, cell in row.items()}
        # Where semicolons stand between cells, a number may have a decimal comma.
        for column in WITH_DECIMALS & cells.keys() if delimiter == ";" else ():
            cells[column] = cells[column].replace(",", ".")
        yield where, cells


def _job(path: Path, where: str, cells: Mapping[str, str], settings: TrialSettings) -> Job:
    """Read a line; its job has the name that the line gives, or none."""
    name = cells.get("name", "")
    try:
        if not cells["clip"]:
            raise UsageError("no clip; write its path in the column clip")
        if any(sign in name for sign in "/\\\0") or name.startswith("."):
            raise UsageError(f"{shown(name)} is no name for a file; leave out slashes and dots")
        clip = path.parent / inputs.some_path(cells["clip"])
        given: dict[str, Any] = {
            column: read(cells[column]) for column, read in READERS.items() if cells.get(column)
        }
        settings = replace(settings, **given)
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from error
    return Job(name, str(clip), settings)

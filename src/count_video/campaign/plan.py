"""What a campaign has to do: one job a trial, each with a name of its own."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Literal

from count_video.campaign.folder import clips_in
from count_video.campaign.manifest import MANIFEST_SUFFIX, read_manifest
from count_video.errors import FootageError
from count_video.outputs import CsvDialect, output_name
from count_video.trial import TrialSettings

RESERVED_NAMES = frozenset({"campaign"})
"""Names of trials whose results would overwrite the campaign's own files."""
FOLDER_MANIFEST = "manifest.csv"
"""What is special about clips of a folder may lie beside them."""


@dataclass(frozen=True)
class Pages:
    """That each trial gets its evidence: page, pictures, annotated clip, tables."""

    folder: Path
    picture_format: Literal["png", "svg"] = "png"
    csv_dialect: CsvDialect = "comma"


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
    pages: Pages | None = None
    """None where the count alone is wanted."""
    start: str = ""
    """Folder at which relative paths start; a worker of a cluster runs in one of its own."""

    @property
    def file(self) -> Path:
        """Where the clip lies."""
        return Path(self.start, self.clip)


def jobs_of(
    paths: Iterable[Path], settings: TrialSettings, pages: Pages | None = None
) -> list[Job]:
    """List the trials that files, folders and manifests stand for, in the order given.

    A folder stands for its clips in natural order, a manifest (``.csv``) for its lines; what a
    folder's own ``manifest.csv`` says of clips is heeded. A folder without a clip, or one that
    cannot be read, is a job with its problem.

    Raises
    ------
    UsageError
        A manifest cannot be read or says what makes no sense.
    """
    wanted = list(chain.from_iterable(_wanted(path, settings) for path in paths))
    taken = dict.fromkeys(RESERVED_NAMES, 2)
    start = os.getcwd()
    return [replace(job, name=_free_name(job, taken), pages=pages, start=start) for job in wanted]


def is_manifest(path: Path) -> bool:
    """Tell a manifest from a clip, by its suffix."""
    return path.suffix.lower() == MANIFEST_SUFFIX


def _wanted(path: Path, settings: TrialSettings) -> Iterator[Job]:
    """Yield jobs whose names are wishes: empty, or given by a manifest."""
    if is_manifest(path):
        for line in read_manifest(path, settings):
            yield Job(line.name, str(line.clip), line.settings)
    elif os.path.isdir(path):
        yield from _of_folder(path, settings)
    else:
        yield Job("", str(path), settings)


def _of_folder(folder: Path, settings: TrialSettings) -> Iterator[Job]:
    """Yield the trials of the folder's manifest, if it has one, then its other clips."""
    manifest = folder / FOLDER_MANIFEST
    told = list(_wanted(manifest, settings)) if os.path.isfile(manifest) else []
    yield from told
    known = {os.path.realpath(job.clip) for job in told}
    try:
        clips: Sequence[Path] = clips_in(folder)
    except (FootageError, OSError) as error:
        if not told:
            yield Job("", str(folder), settings, getattr(error, "strerror", None) or str(error))
    else:
        others = (clip for clip in clips if os.path.realpath(clip) not in known)
        yield from (Job("", str(clip), settings) for clip in others)


def _free_name(job: Job, taken: dict[str, int]) -> str:
    """Choose the shortest name that is still free, and take it.

    ``taken`` has the lowest number that others of each name may have.
    """
    full = job.file.name or "clip"
    stem = job.name or job.file.stem or full
    folder = Path(os.path.abspath(job.clip)).parent.name
    for name in map(output_name, (stem, full, f"{folder}-{full}")):
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

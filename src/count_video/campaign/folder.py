"""Which files of a folder are clips, in the order in which people number them."""

from __future__ import annotations

import re
from pathlib import Path

from count_video.errors import FootageError
from count_video.outputs import OutputFolder

VIDEO_SUFFIXES = (
    *(".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm"),
    *(".3gp", ".mpg", ".mpeg", ".mts", ".m2ts", ".wmv"),
)
"""Which files of a folder are taken for clips; upper and lower case alike."""


def clips_in(folder: Path) -> list[Path]:
    """List the video files of a folder (not of its subfolders), clip2 before clip10.

    Annotated clips that this program wrote there are left out.

    Raises
    ------
    FootageError
        The folder holds no video file.
    """
    written = OutputFolder(folder).written()
    clips = [
        entry
        for entry in folder.iterdir()
        if entry.suffix.lower() in VIDEO_SUFFIXES
        and entry.name not in written
        and not entry.name.startswith(".")  # what other systems leave beside a clip
        and entry.is_file()
    ]
    if not clips:
        raise FootageError(f"no video file in this folder (looked for {' '.join(VIDEO_SUFFIXES)})")
    return sorted(clips, key=_natural_order)


def _natural_order(path: Path) -> tuple[list[str | int], str]:
    # Splitting at a captured group alternates text and digits, so that like meets like.
    parts = re.split(r"(\d+)", path.name.casefold())
    return [int(part) if part.isdecimal() else part for part in parts], path.name

"""What a result depends on, as short texts that can be compared: clip, options, tool."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from functools import cache
from pathlib import Path

import count_video
from count_video.reports.json_object import SCHEMA_VERSION
from count_video.trial import TrialSettings

Signature = list[int]
"""What a file system says of a file; it changes whenever somebody writes to the file."""


def text_digest(text: str) -> str:
    """Digest a text."""
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def signature(file: Path) -> Signature:
    """Size, times of the last change and number of a file.

    Raises
    ------
    OSError
        If there is no such file.
    """
    stat = file.stat()
    return [stat.st_size, stat.st_mtime_ns, stat.st_ctime_ns, stat.st_ino]


def settings_text(settings: TrialSettings) -> str:
    """Write the settings as a text that is the same for the same settings."""
    return json.dumps(asdict(settings), default=str, sort_keys=True)


@cache
def tool_version() -> str:
    """Version of the tool, with a digest of its source: between releases the code changes too."""
    package = Path(count_video.__file__).parent
    digest = hashlib.sha256()
    for file in sorted(package.rglob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode())
        digest.update(file.read_bytes())
    return f"{count_video.__version__}+schema{SCHEMA_VERSION}+{digest.hexdigest()[:16]}"

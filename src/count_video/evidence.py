"""The evidence for one clip: pictures, annotated clip, tables and page, next to its count."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from count_video.progress import NO_PROGRESS, Progress
from count_video.records import TrialResult
from count_video.trial import TrialSettings

PictureFormat = Literal["png", "svg"]


@dataclass(frozen=True)
class EvidenceSettings:
    """Where the evidence goes and what it looks like."""

    folder: Path
    """Made if it is not there."""
    picture_format: PictureFormat = "png"
    corrections: Path | None = None
    """File of a person's corrections to lay over the result."""


def count_with_evidence(
    path: Path,
    settings: TrialSettings,
    evidence: EvidenceSettings,
    progress: Progress = NO_PROGRESS,
) -> TrialResult:
    """Count a clip as ``trial.count_clip`` does and write its evidence beside the answer.

    Files are named after the clip: for ``trial7.mp4`` they are ``trial7.html``, ``trial7.png``,
    ``trial7.strip.jpg``, ``trial7.annotated.mp4``, ``trial7.track.csv``,
    ``trial7.collisions.csv``.

    Raises
    ------
    FootageError
        If the file cannot be read as footage.
    UsageError
        If a setting does not fit the clip, or the evidence cannot be written.
    """
    raise NotImplementedError

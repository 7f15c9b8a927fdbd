"""What the tests of the evidence share: a rendered clip, its truth, and where its files are."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from count_video.answers import Followed
from count_video.evidence import EvidenceSettings, draw_evidence
from count_video.pipeline import TrialSettings, work_through
from count_video.records import Floats, TrialResult

FIXTURES = Path(__file__).parents[2] / "fixtures"
CLIP = FIXTURES / "ratio16-count12.mp4"


@dataclass(frozen=True)
class Truth:
    """Where the bodies really are, a row a frame."""

    ball_x_px: Floats
    ball_y_px: Floats
    diameter_px: float
    face_x_px: Floats


@dataclass(frozen=True)
class Made:
    """A clip, its answer, and the folder with its evidence."""

    clip: Path
    folder: Path
    trial: Followed
    """What was counted and followed, before anything was drawn."""
    result: TrialResult

    def file(self, suffix: str) -> Path:
        return self.folder / f"{self.clip.stem}.{suffix}"


def count_with_evidence(
    path: Path, settings: TrialSettings, evidence: EvidenceSettings
) -> TrialResult:
    """Count a clip and write its evidence."""
    found = work_through(path, settings)
    draw_evidence(found, evidence)
    return found.result

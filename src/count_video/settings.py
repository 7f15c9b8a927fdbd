"""What may be said about a clip and its results, read from text or given as values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack

from count_video import inputs
from count_video.errors import UsageError
from count_video.inputs import shown

if TYPE_CHECKING:  # NumPy takes time, and the command needs this module at once
    from count_video.physics.theory import Mass
    from count_video.records import WallSide

PictureFormat = Literal["png", "svg"]
CsvDialect = Literal["comma", "semicolon"]
"""How tables are written: cells between commas with decimal points, or cells between semicolons
with decimal commas, as spreadsheets in many countries read them."""
Shape = Literal["wide", "upright"]


@dataclass(frozen=True)
class TrialSettings:
    """What the user may say about a clip."""

    capture_fps: float | None = None
    """Camera's rate in frames per second of real time."""
    ball_diameter_mm: float = 40.0
    wall: WallSide | None = None
    """Side on which it stands."""
    region: tuple[int, int, int, int] | None = None
    """Part of the picture that holds the experiment: x, y, width, height in px."""
    start: int = 0
    """First frame to use."""
    end: int | None = None
    """Frame to stop before; None for the clip's end."""
    masses: tuple[Fraction, Fraction] | None = None
    """Heavy and light mass, in any one unit."""
    seen_only: bool = False
    """Count what the frames show and infer nothing between them."""

    def __post_init__(self) -> None:
        if self.end is not None and self.start >= self.end:
            raise UsageError(
                f"start {self.start} leaves no frame before end {self.end}: give an end above it"
            )


@dataclass(frozen=True)
class EvidenceSettings:
    """The folder of a clip's evidence, and its formats."""

    folder: Path
    """Made if it is not there."""
    picture_format: PictureFormat = "png"
    csv_dialect: CsvDialect = "comma"
    presenter: Shape | None = None
    """Shape of a clip for a talk, with its GIF; None for none."""
    name: str | None = None
    """What the files are named after; None for the clip's name without its suffix."""


class Settings(TypedDict, total=False):
    """What may be said about a clip; see :func:`count_video.count`."""

    masses: tuple[Mass, Mass] | None
    capture_fps: float | None
    region: tuple[int, int, int, int] | None
    wall: WallSide | None
    start: int
    end: int | None
    ball_diameter_mm: float
    seen_only: bool


def _wall(text: str) -> str:
    if text not in ("left", "right"):
        raise UsageError(f"{shown(text)} is not left or right")
    return text


def _masses(text: str) -> tuple[Fraction, Fraction]:
    two = text.split()
    if len(two) != 2:
        raise UsageError(f"{shown(text)} is not two masses, heavy and light")
    return inputs.masses(*map(inputs.MASS.exact, two))


READERS: Mapping[str, Callable[[str], Any]] = {
    "region": inputs.region,
    "masses": _masses,
    "wall": _wall,
    "capture_fps": inputs.CAPTURE_RATE,
    "start": inputs.FRAME,
    "end": inputs.FRAME,
    "ball_diameter_mm": inputs.BALL_DIAMETER,
}
"""What reads each setting that has a value from text."""


def trial_settings(**settings: Unpack[Settings]) -> TrialSettings:
    """Check what was said about a clip, as the command line does; UsageError names the setting."""
    if unknown := settings.keys() - Settings.__annotations__.keys():
        raise UsageError(f"there is no setting {', '.join(sorted(unknown))}")
    given: Mapping[str, object] = settings
    values: dict[str, Any] = {
        name: inputs.checked(name, given[name], read)
        for name, read in READERS.items()
        if given.get(name) is not None
    }
    return TrialSettings(**values, seen_only=bool(settings.get("seen_only", False)))

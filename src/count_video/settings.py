"""What may be said about a clip, checked as the command line checks it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypedDict, TypeVar, Unpack

from count_video import inputs
from count_video.errors import UsageError
from count_video.physics.theory import Mass
from count_video.records import WallSide

_Value = TypeVar("_Value")


@dataclass(frozen=True)
class TrialSettings:
    """What the user may say about a clip."""

    capture_fps: float | None = None
    """Camera's rate in frames per second of real time."""
    ball_diameter_mm: float = 40.0
    wall_side: WallSide | None = None
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


def trial_settings(**settings: Unpack[Settings]) -> TrialSettings:
    """Check what was said about a clip, as the command line does.

    Raises
    ------
    UsageError
        A value makes no sense; the message names it.
    """
    unknown = settings.keys() - Settings.__annotations__.keys()
    if unknown:
        raise UsageError(f"there is no setting {', '.join(sorted(unknown))}")
    end, fps = settings.get("end"), settings.get("capture_fps")
    start = _read("start", inputs.frame, settings.get("start", 0))
    if end is not None and start >= _read("end", inputs.frame, end):
        raise UsageError(f"start {start} leaves no frame before end {end}: give a start below it")
    region, wall = settings.get("region"), settings.get("wall")
    if region is not None:
        region = _read("region", inputs.region, ",".join(str(edge) for edge in region))
    if wall not in (None, "left", "right"):
        raise UsageError(f"wall is {inputs.shown(str(wall))}; it must be 'left' or 'right'")
    masses = settings.get("masses")
    return TrialSettings(
        capture_fps=None if fps is None else _read("capture_fps", inputs.capture_rate, fps),
        ball_diameter_mm=_read(
            "ball_diameter_mm", inputs.ball_diameter, settings.get("ball_diameter_mm", 40.0)
        ),
        wall_side=wall,
        region=region,
        start=start,
        end=end,
        masses=None if masses is None else _masses(masses),
        seen_only=bool(settings.get("seen_only", False)),
    )


def _read(name: str, read: Callable[[str], _Value], value: object) -> _Value:
    """Read a value with the reader of the command line, which has the ranges."""
    try:
        return read(str(value))
    except UsageError as error:
        raise UsageError(f"{name}: {error}") from error


def _masses(two: Sequence[Mass]) -> tuple[Fraction, Fraction]:
    if len(two) != 2:
        raise UsageError(f"masses are {two!r}; give two, the cylinder's and the ball's")
    return inputs.masses(exact_mass(two[0]), exact_mass(two[1]))


def exact_mass(value: Mass) -> Fraction:
    """Return a mass at its exact value, a float at the number it is written as: 1.05 is 105/100.

    Raises
    ------
    UsageError
        It is no number, or out of range.
    """
    try:
        mass = Fraction(str(value))
    except ValueError as error:
        raise UsageError(f"a mass is {value!r}; it must be a number greater than 0") from error
    if not inputs.MASS.holds(mass):
        raise UsageError(f"a mass is {value!r}; it must be a number {inputs.MASS}")
    return mass

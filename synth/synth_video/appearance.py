"""The appearance of what stands before the camera, one frozen record a thing.

Colours are display values (red, green, blue), 0 to 255; lengths are metres of the apparatus.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from count_video.errors import UsageError
from count_video.records import WallSide

Color = tuple[int, int, int]
BodyShape = Literal["ball", "block", "cart", "puck"]
HeavyShape = Literal["cylinder", "block", "cart", "puck"]
Pattern = Literal["print", "plain", "stripes", "halves"]
SpinAxis = Literal["upright", "sight"]
BackgroundKind = Literal["table", "cloth", "shelf", "plaster", "stone", "boards"]


def require(condition: bool, complaint: str) -> None:
    """Raise ``UsageError`` with the complaint unless the condition holds."""
    if not condition:
        raise UsageError(complaint)


@dataclass(frozen=True)
class BallSettings:
    """Appearance of the light body; its diameter (length along the line) belongs to the set-up."""

    shape: BodyShape = "ball"
    """A ball, a wooden block or a cart seen from the side, or a puck seen from above."""
    height_m: float = 0.0
    """Height of a block or a cart; 0 for as high as long."""
    pattern: Pattern = "print"
    """What is on a ball: the print of ``mark``, nothing, stripes, or halves, in ``mark_color``."""
    spin_hz: float = 0.0
    """Turns per second of real time, of a ball or a puck, of either sign."""
    spin_axis: SpinAxis = "upright"
    """Axis of a ball's turn: its thread, or the line of sight (as if it rolled)."""
    color: Color = (226, 103, 28)
    ring: bool = True
    ring_color: Color = (38, 36, 38)
    mark: str = "40+"
    """Printed on the ball; empty for none."""
    mark_color: Color = (60, 34, 24)
    gloss: float = 0.25
    """Strength of the highlight, 0 to 1."""
    shading: float = 1.0
    """How much the lamp models the sphere: 1 as a lamp does, 0 for a disc of one brightness."""

    def __post_init__(self) -> None:
        require(0 <= self.gloss <= 1, "ball.gloss must lie between 0 and 1")
        require(0 <= self.shading <= 1, "ball.shading must lie between 0 and 1")
        require(self.height_m >= 0, "ball.height_m must not be negative")


@dataclass(frozen=True)
class CylinderSettings:
    """Appearance and size of the heavy body; its mass belongs to the set-up."""

    shape: HeavyShape = "cylinder"
    """A cylinder, a wooden block or a cart seen from the side, or a puck seen from above."""
    length_m: float = 0.063
    diameter_m: float = 0.049
    color: Color = (206, 152, 62)
    glint: float = 0.6
    """Part of the highlight that stays where the lamps are while the cylinder passes, 0 to 1."""
    rim_m: float = 0.0
    """The near half of the front face, as a camera sees it from behind, past the body: it
    hides so much of the ball when the two touch."""
    clay: bool = True
    """Modelling clay at the far end."""
    clay_color: Color = (44, 62, 122)

    def __post_init__(self) -> None:
        require(self.length_m > 0, "cylinder.length_m must be positive")
        require(self.diameter_m > 0, "cylinder.diameter_m must be positive")
        require(0 <= self.glint <= 1, "cylinder.glint must lie between 0 and 1")
        require(self.rim_m >= 0, "cylinder.rim_m must not be negative")


@dataclass(frozen=True)
class ThreadSettings:
    """Sewing threads from the bodies up to their hangers; drawn when the bodies are suspended."""

    color: Color = (205, 200, 192)
    width_m: float = 0.0003
    opacity: float = 0.8

    def __post_init__(self) -> None:
        require(self.width_m >= 0, "threads.width_m must not be negative")
        require(0 <= self.opacity <= 1, "threads.opacity must lie between 0 and 1")


@dataclass(frozen=True)
class WallSettings:
    """The clear plate that the ball strikes."""

    side: WallSide = "left"
    """Side of the picture on which the wall stands."""
    thickness_m: float = 0.008
    front_m: float = 0.012
    """How far the near part of the plate reaches over the bodies' side in perspective."""
    tint: Color = (158, 172, 160)
    opacity: float = 0.12
    """How much of the plate's own colour is seen, 0 to 1."""
    edge: float = 0.35
    """Strength of the plate's edges, 0 to 1."""
    reflection: float = 0.12
    """Strength of the ball's mirror image in the plate, 0 to 1."""
    mirror_m: float = 0.0128
    """How far behind the plate's face its mirror image is seen."""
    clamp_m: float = 0.0
    """An opaque clamp in front of the plate reaches so far over the bodies' side; 0 for none."""
    clamp_up_m: float = -0.008
    """Height over the rest line up to which the clamp hides what is behind it."""

    def __post_init__(self) -> None:
        require(self.thickness_m > 0, "wall.thickness_m must be positive")
        require(self.front_m >= 0, "wall.front_m must not be negative")
        for name in ("mirror_m", "clamp_m"):
            require(getattr(self, name) >= 0, f"wall.{name} must not be negative")
        for name in ("opacity", "edge", "reflection"):
            require(0 <= getattr(self, name) <= 1, f"wall.{name} must lie between 0 and 1")


@dataclass(frozen=True)
class BackgroundSettings:
    """What stands behind the bodies."""

    kind: BackgroundKind = "table"
    color: Color = (128, 119, 110)
    """Mean colour of what is behind the bodies."""
    texture: float = 1.0
    """Strength of grain and pattern; 0 is flat."""
    blur_m: float = 0.0004
    """Defocus of the background."""

    def __post_init__(self) -> None:
        require(self.texture >= 0, "background.texture must not be negative")
        require(self.blur_m >= 0, "background.blur_m must not be negative")


@dataclass(frozen=True)
class LightSettings:
    """Lamps."""

    brightness: float = 1.0
    """Factor on everything seen."""
    shadow: float = 0.45
    """Depth of the shadows that follow the bodies, 0 to 1."""
    flicker_amplitude: float = 0.0
    """Relative swing of the brightness, 0 to 1."""
    flicker_hz: float = 100.0
    """Cycles per second of real time."""
    flicker_phase_deg: float = 0.0
    """Phase of the cycle at the centre of frame 0."""
    drift: float = 0.0
    """Relative change of the brightness from the first frame to the last, as of a camera that sets
    its exposure anew."""

    def __post_init__(self) -> None:
        require(self.brightness > 0, "light.brightness must be positive")
        require(0 <= self.shadow <= 1, "light.shadow must lie between 0 and 1")
        require(0 <= self.flicker_amplitude <= 1, "light.flicker_amplitude must lie in 0 to 1")
        require(self.flicker_hz > 0, "light.flicker_hz must be positive")
        require(self.drift > -1, "light.drift must be above -1")

"""What gets into the picture besides the apparatus."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from synth_video.looks import require

Side = Literal["far", "near"]


@dataclass(frozen=True)
class ThingsSettings:
    """People and things that have nothing to do with the count."""

    lying_ball: bool = False
    """A second ball like the first lies on the table."""
    lying_along_m: float = 0.16
    """Its distance from the wall."""
    lying_up_m: float = -0.03
    """Height of its centre over the rest line."""
    person: float = 0.0
    """A person at the edge of the picture reaches so far into it: part of its width, 0 for none."""
    person_side: Side = "far"
    """The edge: far from the wall, or near it."""
    person_m_s: float = 0.15
    """The person's greatest speed, to and fro."""
    hand_s: float = 0.0
    """A hand holds the far part of a suspended cylinder, goes with it and lets it go so long after
    the release, in seconds; 0 for none. Before the first collision, or it would disturb it."""
    cords: int = 0
    """Number of cords that cross the picture in front of the bodies."""
    cord_m: float = 0.0012
    """Their thickness."""

    def __post_init__(self) -> None:
        require(0 <= self.person <= 0.6, "things.person must lie between 0 and 0.6")
        for name in ("person_m_s", "hand_s", "cords"):
            require(getattr(self, name) >= 0, f"things.{name} must not be negative")
        require(self.cord_m > 0, "things.cord_m must be positive")

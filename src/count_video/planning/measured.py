"""How often clips of known truth were counted exactly: the tables of docs/accuracy.md.

A plan's chance is that of the clips that were most like it, by how many frames lie from one
collision to the next and by how many collisions there are. Where no such clips were measured
nothing is promised.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

RESOLVED_FRAMES = 2.5
"""From this interval on the frames show each collision."""
CLOSEST_FRAMES = 0.25
"""Trials near 1:100 were measured down to this shortest interval, ..."""
CLOSER_FRAMES = 0.08
"""... and planned ones, with their masses given, down to this."""
MOST_OF_A_SHORT_BURST = 45
"""Measured trials that were not resolved have up to so many collisions, or some 310."""
LONG_BURST = (250, 350)
LONG_BURST_FPS = 1000.0
"""Slowest camera with which long bursts were measured."""

Way = Literal["seen", "inferred", "not measured"]


@dataclass(frozen=True)
class Measured:
    """Clips of one kind and how they came out."""

    kind: str
    """What they have in common, in a few words."""
    clips: int
    exact: int
    not_counted: int
    wrong: int

    @property
    def chance(self) -> float:
        """Chance that the next such clip is counted exactly, by Laplace's rule of succession."""
        return (self.exact + 1) / (self.clips + 2)


RESOLVED = Measured("rendered clips whose frames show every collision", 1060, 1056, 4, 0)
BETWEEN = Measured("rendered clips with some collisions between the frames", 42, 42, 0, 0)
CLOSE = Measured("planned clips with collisions closer than a quarter of a frame", 20, 19, 1, 0)
LONG = Measured("clips of some 310 collisions with the masses given", 20, 20, 0, 0)


def most_like(
    count: int, shortest_frames: float, capture_fps: float
) -> tuple[Way, Measured | None]:
    """Return how a clip would be counted, and the measured clips that were most like it."""
    if shortest_frames >= RESOLVED_FRAMES:
        return "seen", RESOLVED
    if count <= MOST_OF_A_SHORT_BURST:
        if shortest_frames >= CLOSEST_FRAMES:
            return "inferred", BETWEEN
        if shortest_frames >= CLOSER_FRAMES:
            return "inferred", CLOSE
    if LONG_BURST[0] <= count <= LONG_BURST[1] and capture_fps >= LONG_BURST_FPS:
        return "inferred", LONG
    return "not measured", None

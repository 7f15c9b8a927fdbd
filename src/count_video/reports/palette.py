"""Colours and shapes of everything that is drawn, the same in pictures, clip and page.

The colours are those of Okabe and Ito, which people with any kind of colour blindness can tell
apart; a kind of collision is told by its shape as well.
"""

from __future__ import annotations

from dataclasses import dataclass

from count_video.records import CollisionKind

BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
YELLOW = "#F0E442"
BLUE = "#0072B2"
VERMILION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#666666"

BALL = SKY_BLUE
HEAVY = ORANGE


@dataclass(frozen=True)
class Mark:
    """How one kind of collision is drawn."""

    colour: str
    shape: str
    """Marker of matplotlib: ``o`` is a disc, ``s`` a square."""
    words: str


MARKS: dict[CollisionKind, Mark] = {
    "bodies": Mark(VERMILION, "o", "between the bodies"),
    "wall": Mark(BLUE, "s", "with the wall"),
}


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green and blue of ``#RRGGBB``, each 0 to 255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)

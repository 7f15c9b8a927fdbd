"""What the tracker sees: some frames of a clip, a part of the picture, in a handy size."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from count_video.errors import UsageError
from count_video.records import Chroma, Floats, Frame
from count_video.video.pictures import reduced
from count_video.video.reader import Footage

Region = tuple[int, int, int, int]
"""x, y, width, height in px."""

WIDTH_AT_MOST_PX = 2000
"""Wider pictures are reduced by a whole factor: positions are known to a few hundredths of a px,
and bodies that move far from frame to frame are lost."""


@dataclass(frozen=True)
class View:
    """A clip seen through a region and at reduced size."""

    footage: Footage
    region: Region
    start: int
    """First frame to use."""
    end: int | None
    """Frame to stop before; None for the clip's end."""
    factor: int
    """How many px of the picture one px of the view spans."""

    def frames(self) -> Iterator[Frame]:
        """Stream the clip's frames as they are seen in this view; at full size without a copy."""
        x, y, width, height = self.region
        for frame in self.footage.frames(self.start, self.end, colour=True):
            luma = reduced(frame.luma[y : y + height, x : x + width], self.factor)
            chroma = None if frame.chroma is None else self._of_chroma(frame.chroma)
            yield replace(frame, luma=luma, chroma=chroma)

    def _of_chroma(self, chroma: Chroma) -> Chroma:
        """Turn colour into that of the view, at half its size; right to a px of the picture."""
        x, y, width, height = (side // 2 for side in self.region)
        piece = chroma[:, y : y + max(1, height), x : x + max(1, width)]
        if self.factor == 1:
            return piece
        return np.array([reduced(one, self.factor) for one in piece])

    def in_picture(self, places_px: Floats) -> Floats:
        """Turn places of the view, by x and y, shape (n, 2), into places of the picture."""
        begin = np.add(self.region[:2], (self.factor - 1) / 2)
        return np.asarray(self.factor * places_px + begin, dtype=np.float64)


def view_of(
    footage: Footage, region: Region | None = None, start: int = 0, end: int | None = None
) -> View:
    """View some frames and a part of a clip; all of it where nothing is said.

    Raises
    ------
    UsageError
        If the region does not fit into the picture.
    """
    info = footage.info
    x, y, width, height = region or (0, 0, info.width_px, info.height_px)
    if x < 0 or y < 0 or x + width > info.width_px or y + height > info.height_px:
        raise UsageError(
            f"region {x},{y},{width},{height} does not fit into the picture of "
            f"{info.width_px} x {info.height_px} px; give one that lies inside"
        )
    factor = max(1, -(-max(width, height) // WIDTH_AT_MOST_PX))
    return View(footage, (x, y, width, height), start, end, factor)

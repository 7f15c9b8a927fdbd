"""What the tracker sees: some frames of a clip, a part of the picture, in a handy size."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from count_video.errors import UsageError
from count_video.records import Chroma, Floats, Frame, Luma, WallSide
from count_video.video.pictures import reduced
from count_video.video.reader import Footage

Region = tuple[int, int, int, int]
"""x, y, width, height in px."""

WIDTH_AT_MOST_PX = 2000
"""Wider pictures are reduced by a whole factor: positions are known to a few hundredths of a px,
and bodies that move far from frame to frame are lost."""


@dataclass(frozen=True)
class TrackSettings:
    """What the user may give the tracker; what is not given is found."""

    wall_side: WallSide | None = None
    region: Region | None = None
    """Part of the picture that holds the experiment."""
    start: int = 0
    """First frame to use."""
    end: int | None = None
    """Frame to stop before; None for the clip's end."""


@dataclass(frozen=True)
class View:
    """A clip seen through a region and at reduced size."""

    footage: Footage
    region: Region
    start: int
    end: int | None
    factor: int
    """How many px of the picture one px of the view spans."""

    def frames(self) -> Iterator[Frame]:
        """Stream the clip's frames as they are seen in this view."""
        return map(self.of, self.footage.frames(self.start, self.end, colour=True))

    def of(self, frame: Frame) -> Frame:
        """Turn a frame of the clip into one of the view."""
        chroma = None if frame.chroma is None else self._of_chroma(frame.chroma)
        return replace(frame, luma=self.of_luma(frame.luma), chroma=chroma)

    def of_luma(self, luma: Luma) -> Luma:
        """Turn a picture, shape (height, width), into one of the view; at full size, no copy."""
        x, y, width, height = self.region
        return reduced(luma[y : y + height, x : x + width], self.factor)

    def _of_chroma(self, chroma: Chroma) -> Chroma:
        """Turn colour into that of the view, at half its size; right to a px of the picture."""
        x, y, width, height = (side // 2 for side in self.region)
        piece = chroma[:, y : y + max(1, height), x : x + max(1, width)]
        if self.factor == 1:
            return piece
        return np.array([reduced(one, self.factor) for one in piece])

    def in_picture(self, places: Floats, *, upright: bool) -> Floats:
        """Turn places of the view along x (y where ``upright``) into places of the picture."""
        corner = self.region[1] if upright else self.region[0]
        return np.asarray(self.factor * places + (self.factor - 1) / 2 + corner, dtype=np.float64)


def view_of(footage: Footage, settings: TrackSettings) -> View:
    """View a clip as the settings ask for.

    Raises
    ------
    UsageError
        If the region does not fit into the picture.
    """
    info = footage.info
    x, y, width, height = settings.region or (0, 0, info.width_px, info.height_px)
    if x < 0 or y < 0 or x + width > info.width_px or y + height > info.height_px:
        raise UsageError(
            f"region {x},{y},{width},{height} does not fit into the picture of "
            f"{info.width_px} x {info.height_px} px; give one that lies inside"
        )
    factor = max(1, -(-max(width, height) // WIDTH_AT_MOST_PX))
    return View(footage, (x, y, width, height), settings.start, settings.end, factor)

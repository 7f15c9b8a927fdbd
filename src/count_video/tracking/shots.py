"""Shots of a clip: at a cut the pictures before it have little in common with those after it.

Edited clips have titles, other scenes and enlarged repetitions beside the trial. The pictures are
compared coarsely, as mean levels of a few hundred blocks: bodies that move change few of these, and
a camera that trembles none by much. How alike the means of some pictures before and after a place
are says their correlation, whatever the light; a flash, or one damaged picture, parts no shots.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from count_video.records import Luma
from count_video.signals import correlation
from count_video.tracking.samples import BLOCK_PX
from count_video.video.pictures import reduced

BESIDE = 5
"""So many pictures before a place are compared with as many after it."""
ALIKE_AT_LEAST = 0.75
"""Correlation of pictures of one scene: between neighbours that differ much it is 0.95 and more
where hands come in, frames are lost or a camera is knocked. Of different scenes it is 0.2."""
CHANGE_LEVELS, CHANGE_FACTOR = 8.0, 3.0
"""Pictures of different scenes differ by more (RMS), for in the dark noise is all that pictures
show; and by so many times as much as those on either side, for bodies may fill the picture."""


class Shots:
    """What is kept of a clip's pictures to find its cuts."""

    def __init__(self) -> None:
        self._coarse: list[Luma] = []

    def add(self, thumbnail: Luma) -> None:
        """Take the next picture."""
        self._coarse.append(reduced(thumbnail, BLOCK_PX))

    def longest(self) -> range:
        """Rows of the longest shot: of all pictures where no cut is seen."""
        ends = [0, *self._cuts(), len(self._coarse)]
        shots = [range(first, end) for first, end in pairwise(ends)]
        return max(shots, key=len)

    def _cuts(self) -> list[int]:
        """Rows of the first pictures after cuts."""
        if not self._coarse:
            return []
        levels = np.array(self._coarse, np.float32).reshape(len(self._coarse), -1)
        every = np.ones(levels.shape[1:], np.float32)
        steps = np.sqrt(np.mean(np.diff(levels, axis=0) ** 2, axis=1))
        cuts = [0]
        for row in (1 + np.flatnonzero(steps > CHANGE_LEVELS)).tolist():
            begin, end = max(cuts[-1], row - BESIDE), row + BESIDE
            both = (one for one in (steps[begin : row - 1], steps[row : end - 1]) if len(one))
            usual = max((float(np.median(one)) for one in both), default=0.0)
            alike = correlation(levels[begin:row].mean(axis=0), levels[row:end].mean(axis=0), every)
            if steps[row - 1] > CHANGE_FACTOR * usual and alike < ALIKE_AT_LEAST:
                cuts.append(row)
        return cuts[1:]

"""Find duplicated frames: pictures that are copies of the picture before them.

A copy can be exact, or it went through an encoder once more and differs by a little. The second
sort is distinguished from real frames by how much the picture changes, frame after frame::

    change   9  8  9  0.7  9  8  9        a copy among moving pictures: a single dip
             9  8  9  0.7  0.6  0.7       the motion ends: low, and stays low
             9  9  9  0.7  9  9  9        a bounce that two frames straddle evenly: a dip as well,
                                          but the pictures before and after it retrace each other
             9  1  9  1  9  1  9  1       every picture twice: dips that keep time

Change is the largest mean difference over small blocks of the picture, so one small body that
moves says as much as a noisy background. Where the evidence is thin a frame is not called a copy:
a copy that stays costs a blurred speed, a real frame left out costs a collision.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator

import cv2
import numpy as np

from count_video.records import Chroma, Luma

DIP_SHARE, LONE_DIP_SHARE = 0.5, 0.3
"""A copy changes less than this share of what real frames change: re-encoded copies of filmed and
rendered clips show 0.02 to 0.15 at high quality, 0.2 to 0.5 at low. A single dip must be deeper."""
MOVING_LEVEL = 4.0
"""Below this change (grey levels) nothing moves or rustles enough for a copy to be recognised."""
HISTORY_AT_LEAST = 12
"""Real frames that a single dip has to undercut clearly."""
LONGEST_RUN = 8
"""More dips in a row than this are no copies but calm."""
PERIODS_SEEN = 4
"""A cadence counts after so many periods without an exception."""


Picture = tuple[Luma, Chroma | None]
"""Brightness, and colour where it is asked for."""


def mark_repeats(pictures: Iterable[Picture]) -> Iterator[tuple[Picture, bool]]:
    """Yield every picture and whether it is a copy of the one before; runs one picture behind.

    The last three are kept.
    """
    judge = _Judge()
    window: deque[_Sample] = deque(maxlen=4)
    for picture in pictures:
        window.append(_Sample(picture, window[-1] if window else None))
        if len(window) > 1:
            yield window[-2].picture, judge.is_copy(tuple(window)[:-1], window[-1])
    if window:
        yield window[-1].picture, judge.is_copy(tuple(window)[-3:], None)


class _Sample:
    """One picture, thinned out, and how it differs from the one before."""

    def __init__(self, picture: Picture, before: _Sample | None) -> None:
        self.picture, luma = picture, picture[0]
        # Every body of use spans two of some 60 rows.
        self.rows = np.ascontiguousarray(luma[:: max(1, round(luma.shape[0] / 60))])
        self.brightness = cv2.mean(self.rows)[0]
        self.change, self.flicker = math.inf, 0.0
        if before is not None:
            # If no row differs, a body may still have moved between them.
            self.change = _change(self.rows, before.rows) or _change(luma, before.picture[0])
            self.flicker = abs(self.brightness - before.brightness)


def _change(picture: Luma, before: Luma) -> float:
    """Largest mean difference over blocks of two pictures, in grey levels; 0 only if identical."""
    if picture.shape != before.shape:
        return math.inf
    difference = cv2.absdiff(picture, before)
    if not difference.max():
        return 0.0
    columns, rows = picture.shape[1] // 16, picture.shape[0] // 2
    if not (columns and rows):  # smaller than a block
        return math.inf
    # Means are rounded to quarters of a grey level, and saturate at 64 levels.
    scaled = cv2.convertScaleAbs(difference[: 2 * rows, : 16 * columns], alpha=4)
    largest = int(cv2.resize(scaled, (columns, rows), interpolation=cv2.INTER_AREA).max())
    return max(largest, 1) / 4


class _Judge:
    """Distinguishes copies from real frames by the changes so far and the one that follows."""

    def __init__(self) -> None:
        self._index = 0
        self._real: deque[float] = deque(maxlen=64)
        """Changes of the last real frames."""
        self._flickers = False
        """If the mean brightness takes a large share in the change: then a dip is no copy."""
        self._dips: deque[bool] = deque(maxlen=PERIODS_SEEN * 12)
        self._run = 0
        """Dips in a row."""
        self._period, self._due = 1, frozenset[int]()
        """Cadence: frames from one copy to the next, and which frames of a period are copies."""

    def is_copy(self, samples: tuple[_Sample, ...], after: _Sample | None) -> bool:
        """Whether the last of up to three pictures in a row is a copy of the one before."""
        sample = samples[-1]
        dip = sample.change == 0 or self._is_dip(sample)
        self._dips.append(dip)
        copy = sample.change == 0 or (
            dip and (self._keeps_time() or (len(samples) == 3 and self._is_lone(samples, after)))
        )
        if dip:
            self._run += 1
        else:
            self._remember(sample)
        self._index += 1
        return copy

    def _is_dip(self, sample: _Sample) -> bool:
        if not self._real or self._flickers or self._run >= LONGEST_RUN:
            return False
        return self._real[-1] >= MOVING_LEVEL and sample.change <= DIP_SHARE * self._real[-1]

    def _remember(self, sample: _Sample) -> None:
        """Take note of a real frame."""
        self._run = 0
        if not math.isfinite(sample.change):
            return
        self._real.append(sample.change)
        self._flickers = sample.flicker > 0.25 * sample.change
        if sample.change >= MOVING_LEVEL and self._is_due():
            self._due = frozenset()  # a copy was due, and none came

    def _is_due(self) -> bool:
        return self._index % self._period in self._due

    def _keeps_time(self) -> bool:
        """Whether a copy is due now, by the cadence of the dips up to this one."""
        dips = tuple(self._dips)
        # From every picture twice to one copy among 12; 24 pictures shown as 30 have one among 5.
        for period in range(2, 13):
            recent = dips[-PERIODS_SEEN * period :]
            if len(recent) < PERIODS_SEEN * period:
                break
            if recent[:-period] == recent[period:] and not all(recent):
                self._period = period
                self._due = frozenset(
                    (self._index - k) % period for k in range(period) if dips[-1 - k]
                )
                break
        return self._is_due()

    def _is_lone(self, samples: tuple[_Sample, ...], after: _Sample | None) -> bool:
        """Whether a dip stands alone among moving pictures that do not retrace each other."""
        if after is None or self._run or len(self._real) < HISTORY_AT_LEAST:
            return False
        earlier, before, sample = samples
        if sample.change > LONE_DIP_SHARE * min(*self._real, after.change):
            return False
        # Where a body came back between the two frames, the pictures around them are alike.
        return _change(after.rows, earlier.rows) > 0.8 * max(before.change, after.change)

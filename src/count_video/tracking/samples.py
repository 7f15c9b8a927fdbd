"""Which pictures of a clip show a motion best: those in which things move by a few px.

Edges that move by a part of a block of pixels change the block's brightness by that part of what
they can change it by at most. So the change of a block, over the largest that it ever undergoes, is
a displacement in units of the block, whatever the contrast: a new sample is taken as soon as one
block has changed by more than a set share.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats, Indices, Luma, Mask, Pixels
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.light import Light, gains_of, lights_of
from count_video.tracking.medians import median_picture, quantile_of
from count_video.tracking.shape import Part, marked
from count_video.video.pictures import reduced
from count_video.video.store import PictureStore

THUMBNAIL_BYTES = 60_000_000
"""Thumbnails are kept up to so many bytes, of longer clips every second, fourth and so on."""
BLOCK_PX = 8
"""Side of a block of a thumbnail."""
CHANGE_SHARE = 0.25
"""A sample is taken when a block has changed by this share of what it can change by: edges have
then moved by about two px of a thumbnail."""
SAMPLES_AT_MOST = 240
SAMPLES_AT_LEAST = 24
PAIRS = 200
"""Pairs of thumbnails by which noise and the largest change are measured."""
MOVES_SIGMAS, MOVES_LEVELS = 6.0, 0.7
"""A block in which something moves changes by more than the noise and by more than this, in grey
levels."""
STRONG_SHARE = 0.1
"""Blocks that change by this share of what the strongest does, or more, show where bodies move."""
SURROUNDINGS = 4
"""So many blocks around these are of interest as well, or as many as they are wide or high: bodies
are no larger part of it than a third, and what stands still shows whether the camera does."""
BARS_IN, BAR_LEVELS = 8, 1
"""Bars around a picture vary by so little in grey levels, over so many thumbnails."""
MEDIAN_OF = 31
"""A median is taken of so many pictures."""
REFERENCES = 3
"""Pictures whose corners are followed: bodies hide each other's edges in some, not in all."""
MOVED_SIGMAS = 3.0
SEED = 20260101


@dataclass(frozen=True)
class Samples:
    """Pictures chosen to find motion in."""

    chosen: Indices
    """Which of the thumbnails' pictures, in order of time; empty where nothing moves."""
    lights: list[Light]
    """By how much each is brighter than the mean one."""
    moved: Mask
    """Where the ``references`` among the samples differ from the median of all, in this part of a
    thumbnail, shape (references, height, width)."""
    part: Part
    """Rows and columns of a thumbnail that hold what moves and its surroundings; they have no stop
    where they reach the end of it."""


class Thumbnails:
    """Reduced pictures of a clip by their place in it: of long ones not of all."""

    def __init__(self, at_most_bytes: int = THUMBNAIL_BYTES) -> None:
        self.pictures: dict[int, Luma] = {}
        self._at_most_bytes, self._stride = at_most_bytes, 1

    def add(self, row: int, thumbnail: Luma) -> None:
        """Take the next picture of the clip."""
        if row % self._stride:
            return
        self.pictures[row] = thumbnail
        if len(self.pictures) * thumbnail.size > self._at_most_bytes:
            self._stride *= 2
            self.pictures = {k: one for k, one in self.pictures.items() if k % self._stride == 0}

    def taken(self) -> dict[int, Luma]:
        """Hand the pictures over, and keep none."""
        taken, self.pictures = self.pictures, {}
        return taken


def stored(pictures: Iterable[Luma]) -> tuple[PictureStore, Thumbnails]:
    """Keep pictures that were made of those of a clip, each of shape (height, width)."""
    store, thumbnails = PictureStore(), Thumbnails()
    try:
        for row, picture in enumerate(pictures):
            thumbnails.add(row, store.append(picture))
    except BaseException:
        store.close()
        raise
    return store, thumbnails


def choose_samples(pictures: dict[int, Luma]) -> Samples:
    """Choose samples among two pictures or more of a clip, given thumbnails by their place in it.

    They are made equally bright in their place: copies of all take much memory.
    """
    inside = _within_bars(list(pictures.values()))
    gains = gains_of(one[inside] for one in pictures.values())
    for row, gain in zip(list(pictures), gains.tolist(), strict=True):
        pictures[row] = Light(gain).levelled(pictures[row])
    rows, whole = np.array(list(pictures), dtype=np.intp), list(pictures.values())
    level = [one[inside] for one in whole]
    noise, largest, active = _changes(level)
    if not active.any():
        return Samples(np.empty(0, np.intp), [], np.empty((0, 1, 1), np.bool_), np.s_[0:, 0:])
    share = CHANGE_SHARE
    chosen = _walk(level, noise, largest, share)
    while len(chosen) > SAMPLES_AT_MOST:
        # Where bodies move by more, so many fewer samples are taken, or nearly.
        share *= max(1.1, len(chosen) / SAMPLES_AT_MOST)
        chosen = _walk(level, noise, largest, share)
    even = np.linspace(0, len(level) - 1, min(SAMPLES_AT_LEAST, len(level))).astype(np.intp)
    together = np.union1d(chosen, even)
    alike = [whole[k] for k in together]
    lights = lights_of(alike, gains[together], _middle(alike))
    alike = [Light(1.0, one.waves).levelled(k) for k, one in zip(alike, lights, strict=True)]
    part = _part(largest, inside)
    return Samples(rows[together], lights, _moved(alike, inside)[:, *part], part)


def _within_bars(thumbnails: Sequence[Luma]) -> Part:
    """Rows and columns between the bars of one brightness that players and editors add.

    They hold no noise: what is measured of it would be too small if they counted.
    """
    some = np.array(thumbnails[:: len(thumbnails) // BARS_IN + 1])
    rows = _between(np.ptp(some, axis=(0, 2)))
    return rows, _between(np.ptp(some[:, rows], axis=(0, 1)))


def _between(varies: Luma) -> slice:
    """Rows or columns from the first to the last that vary; all of them if none does."""
    shown = np.flatnonzero(varies > BAR_LEVELS)
    if len(shown) == 0:
        return slice(0, None)
    end = int(shown[-1]) + 1
    return slice(int(shown[0]), end if end < len(varies) else None)


def _part(largest: Floats, inside: Part) -> Part:
    """Rows and columns as in ``Samples``, by the largest change of each block inside of bars."""
    change = np.where(np.isfinite(largest), largest, 0.0)
    strong = np.nonzero(change >= STRONG_SHARE * change.max())
    part = []
    for blocks, count, within in zip(strong, change.shape, inside, strict=True):
        first, end = int(blocks.min()), int(blocks.max()) + 1
        reach = max(end - first, SURROUNDINGS)
        begin = within.start + BLOCK_PX * max(0, first - reach)
        stop = within.start + BLOCK_PX * (end + reach) if end + reach < count else within.stop
        part.append(slice(begin, stop))
    return part[0], part[1]


def differences(pictures: Sequence[Luma], hidden: Sequence[Sequence[Part]] = ()) -> list[Luma]:
    """Take absolute differences of pictures of one brightness from the median of some of them.

    Parts that are ``hidden``, picture by picture, have no share in that.
    """
    middle = _middle(pictures, hidden)
    return [np.asarray(cv2.absdiff(one, middle), np.uint8) for one in pictures]


def _middle(pictures: Sequence[Luma], hidden: Sequence[Sequence[Part]] = ()) -> Luma:
    """Take the median of some pictures, evenly spread."""
    some = np.linspace(0, len(pictures) - 1, min(MEDIAN_OF, len(pictures))).astype(int).tolist()
    shown = [pictures[k] for k in some]
    return median_picture(shown, [marked(hidden[k], shown[0].shape) for k in some if hidden])


def references(count: int) -> list[int]:
    """Which of so many samples show the corners that are followed."""
    return [*map(int, np.unique(np.linspace(0, count - 1, REFERENCES + 2).astype(int)[1:-1]))]


def _moved(level: Sequence[Luma], inside: Part) -> Mask:
    """Mark where the references differ from the median of all thumbnails by more than noise.

    The noise is that of all, ``inside`` of bars. Shape (references, height, width).
    """
    away = differences(level)
    least = MOVED_SIGMAS * (MEDIAN_TO_SIGMA * quantile_of([one[inside] for one in away], 0.5) + 0.5)
    away = [away[k] for k in references(len(level))]
    # Single pixels are noise.
    moved = (cv2.medianBlur((one > least).astype(np.uint8), 3) for one in away)
    return np.stack([one > 0 for one in moved])


def _changes(level: Sequence[Luma]) -> tuple[Floats, Floats, Mask]:
    """Change of each block by noise alone, the largest by motion, and where there is any.

    The largest is infinite in blocks where nothing moves.
    """
    rng = np.random.default_rng(SEED)
    count = len(level)
    near = np.unique(np.linspace(0, count - 2, PAIRS).astype(int))
    neighbours = np.array([_change(level[k], level[k + 1]) for k in near])
    pairs = rng.integers(0, count, (PAIRS, 2))
    distant = np.array([_change(level[a], level[b]) for a, b in pairs])
    noise = np.quantile(neighbours, 0.2, axis=0)
    scatter = MEDIAN_TO_SIGMA * float(np.median(np.abs(neighbours - np.median(neighbours, axis=0))))
    largest = np.quantile(distant, 0.97, axis=0) - noise
    active = largest > max(MOVES_SIGMAS * scatter, MOVES_LEVELS)
    return noise, np.where(active, largest, np.inf), active


def _change(one: Luma, other: Luma) -> Pixels:
    """Mean difference of two thumbnails over blocks, in grey levels."""
    return reduced(cv2.absdiff(one, other).astype(np.float32), BLOCK_PX)


def _walk(level: Sequence[Luma], noise: Floats, largest: Floats, share: float) -> list[int]:
    """Take a picture whenever a block has changed by a share of its largest change."""
    chosen, last = [0], level[0]
    for place in range(1, len(level)):
        change = (_change(level[place], last) - noise) / largest
        if float(change.max()) > share:
            chosen.append(max(place - 1, chosen[-1] + 1))
            last = level[chosen[-1]]
    return chosen

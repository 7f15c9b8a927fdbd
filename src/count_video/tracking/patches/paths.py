"""Patches of many frames joined to the paths of bodies, each taken up by the patch nearest ahead.

A body goes on as it moved, or turns back at a collision: a patch is looked for both where the
path leads and where it last was. Patches that reach the picture's border show only a part of what
they belong to and join no path.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from count_video.records import Floats
from count_video.tracking.patches.blobs import Blob, Sight
from count_video.tracking.patches.merging import Known, parted

LOST_PICTURES = 12
"""A path that finds no patch for so many pictures has ended."""
REACH_SIZES = 1.0
REACH_SPEEDS = 1.6
"""A patch is looked for this many body sizes and this many steps of the last speed away."""
AREA_FACTOR = 1.75
"""Areas of one body in neighbouring pictures differ by less; bodies that touch merge to one."""
SIDE_FACTOR = 2.0
"""And so do the sides of the boxes around it: its shadow may be of its area, but not of its shape.
Bodies are blurred as they move, and turn, but no side doubles at once."""
RECENT = 7
"""The usual area is that of so many sightings."""
KNOWN_SIGHTINGS = 4
AREA_COST = 0.5
YOUNG_COST = 0.5
NO_MATCH = 1e3
SIZE_STRAYS = 0.5
NEIGHBOURS = 4
STRAYING_AT_MOST = 0.3
"""A sighting whose width or height strays from its neighbours' median by more, in its logarithm,
shows a part of the body or something else with it, as long as these are this share of all."""


@dataclass
class Path:
    """One body's patches; grows as frames are added."""

    rows: list[int] = field(default_factory=list)
    """Which pictures show it: places in the list of sights."""
    blobs: list[Blob] = field(default_factory=list)

    def add(self, row: int, blob: Blob) -> None:
        """Take up a patch."""
        self.rows.append(row)
        self.blobs.append(blob)

    @property
    def x_px(self) -> Floats:
        """Places along image x, shape (n,)."""
        return np.array([blob.x_px for blob in self.blobs])

    @property
    def y_px(self) -> Floats:
        """Places along image y, shape (n,)."""
        return np.array([blob.y_px for blob in self.blobs])

    @property
    def recent_area_px(self) -> float:
        """Usual area of the last sightings."""
        return float(np.median([blob.area_px for blob in self.blobs[-RECENT:]]))

    @property
    def recent_sides_px(self) -> tuple[float, float]:
        """Usual width and height of the last sightings."""
        last = self.blobs[-RECENT:]
        width, height = np.median([(blob.width_px, blob.height_px) for blob in last], axis=0)
        return float(width), float(height)

    @property
    def is_known(self) -> bool:
        """Whether the body was seen often enough to know its size."""
        return len(self.rows) >= KNOWN_SIGHTINGS

    @property
    def area_px(self) -> float:
        """Usual area."""
        return float(np.median([blob.area_px for blob in self.blobs]))

    @property
    def size_px(self) -> float:
        """Usual size: the geometric mean of width and height."""
        return float(np.median([np.sqrt(b.width_px * b.height_px) for b in self.blobs]))

    @property
    def sweep_px(self) -> float:
        """How far its places spread: the diagonal of their middle 90 %."""
        across, down = (np.quantile(axis, (0.05, 0.95)) for axis in (self.x_px, self.y_px))
        return float(np.hypot(np.ptp(across), np.ptp(down)))

    @property
    def contrast(self) -> float:
        """Usual difference from the scenery in grey levels."""
        return float(np.median([blob.contrast for blob in self.blobs]))

    @property
    def worth(self) -> float:
        """What speaks for a body: seen often, going far, standing out."""
        return len(self.rows) * self.sweep_px * self.contrast


def join(sights: Sequence[Sight]) -> list[Path]:
    """Join patches to paths, in the order in which these begin."""
    live: list[Path] = []
    ended: list[Path] = []
    for row, sight in enumerate(sights):
        free = [blob for blob in sight.blobs if not blob.at_border]
        taken = _assigned(live, row, free)
        used = {id(blob) for _, blob in taken}
        gone_on = {id(path) for path, _ in taken}
        waiting = [path for path in live if id(path) not in gone_on and path.is_known]
        known = [Known(path.blobs[-1], path.recent_area_px) for path in waiting]
        pieces, whole = parted(known, [blob for blob in free if id(blob) not in used])
        for path, blob in taken + [(waiting[place], piece) for place, piece in pieces]:
            path.add(row, blob)
        ended += [path for path in live if row - path.rows[-1] > LOST_PICTURES]
        live = [path for path in live if row - path.rows[-1] <= LOST_PICTURES]
        used |= {id(blob) for blob in whole}
        live += [Path([row], [blob]) for blob in free if id(blob) not in used]
    return sorted(ended + live, key=lambda path: path.rows[0])


def _assigned(live: Sequence[Path], row: int, free: Sequence[Blob]) -> list[tuple[Path, Blob]]:
    """Patches that go on with paths, so that the costs of all together are least."""
    if not live or not free:
        return []
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415 - slow; most clips need none

    costs = _costs(live, row, free)
    rows, columns = linear_sum_assignment(np.minimum(costs, NO_MATCH))
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return [(live[one], free[two]) for one, two in pairs if costs[one, two] < NO_MATCH]


def _costs(live: Sequence[Path], row: int, free: Sequence[Blob]) -> Floats:
    """How badly each patch goes on with each path, by place and area; inf if not at all.

    Shape (paths, patches).
    """
    state = np.array([_state(path, row) for path in live])[:, :, None]
    last_x, last_y, ahead_x, ahead_y, reach, area, age, width, height = np.moveaxis(state, 1, 0)
    x, y, areas, widths, heights = np.array(
        [[blob.x_px, blob.y_px, blob.area_px, blob.width_px, blob.height_px] for blob in free]
    ).T
    ahead = np.hypot(x - last_x - ahead_x, y - last_y - ahead_y)
    nearer = np.minimum(ahead, np.hypot(x - last_x, y - last_y))
    growth = np.abs(np.log(areas / area))
    shape = np.maximum(np.abs(np.log(widths / width)), np.abs(np.log(heights / height)))
    # A path that has been seen for long comes before one that has just begun.
    costs = nearer / reach + AREA_COST * growth + YOUNG_COST / age
    other_body = (growth > np.log(AREA_FACTOR)) | (shape > np.log(SIDE_FACTOR))
    return np.where((nearer > reach) | other_body, np.inf, costs)


def _state(path: Path, row: int) -> tuple[float, ...]:
    """Last place, motion since then, reach, usual area, number of sightings, and usual sides."""
    last = path.blobs[-1]
    pictures = row - path.rows[-1]
    across, down = (pictures * step for step in _step(path))
    reach = REACH_SIZES * max(last.width_px, last.height_px)
    reach += REACH_SPEEDS * float(np.hypot(across, down))
    usual = path.recent_area_px, len(path.rows), *path.recent_sides_px
    return (last.x_px, last.y_px, across, down, reach, *usual)


def _step(path: Path) -> tuple[float, float]:
    """Motion from one picture to the next, by the last two sightings."""
    if len(path.rows) < 2:
        return 0.0, 0.0
    one, two = path.blobs[-2:]
    pictures = path.rows[-1] - path.rows[-2]
    return (two.x_px - one.x_px) / pictures, (two.y_px - one.y_px) / pictures


def cleaned(path: Path) -> Path:
    """Leave out the sightings of a part of the body, or of more than it; all if these are many."""
    sizes = np.log([[blob.width_px, blob.height_px] for blob in path.blobs])
    good = [
        bool(np.all(np.abs(size - np.median(_around(sizes, place), axis=0)) < SIZE_STRAYS))
        for place, size in enumerate(sizes)
    ]
    if np.mean(good) < 1 - STRAYING_AT_MOST:
        return path
    kept = [place for place, whole in enumerate(good) if whole]
    return Path([path.rows[place] for place in kept], [path.blobs[place] for place in kept])


def _around(sizes: Floats, place: int) -> Floats:
    return sizes[max(0, place - NEIGHBOURS) : place + NEIGHBOURS + 1]

"""Two bodies that come so near each other that they stand out as one patch, told apart again.

Each reaches to one end of the patch they make together, and its size is known from before: so its
centre lies half its size from that end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from count_video.tracking.blobs import Blob

if TYPE_CHECKING:
    from count_video.tracking.paths import Path

KNOWN_SIGHTINGS = 4
"""A body of which fewer have been seen has no known size."""
AREA_FACTOR = 1.4
"""The area of both together, to this factor: the gap between them is bridged, a part may hide."""

Extent = tuple[float, float, float]
"""Of a patch along one axis, in px: where it begins, its centre, where it ends."""


def parted(
    paths: Sequence[Path], blobs: Sequence[Blob]
) -> tuple[list[tuple[Path, Blob]], list[Blob]]:
    """Part the patches that are two bodies each: such paths with their pieces, and the patches.

    ``paths`` are those that no patch goes on with, ``blobs`` the patches that go on with none.
    """
    known = [path for path in paths if len(path.rows) >= KNOWN_SIGHTINGS]
    pieces: list[tuple[Path, Blob]] = []
    whole = []
    for blob in blobs:
        for pair in combinations(known, 2):
            if _make(pair, blob):
                pieces += _pieces(pair, blob)
                whole.append(blob)
                known = [path for path in known if path not in pair]
                break
    return pieces, whole


def _make(pair: tuple[Path, Path], blob: Blob) -> bool:
    """Whether two bodies make up a patch, by their areas and by where they last were."""
    area = sum(path.recent_area_px for path in pair)
    if abs(np.log(blob.area_px / area)) > np.log(AREA_FACTOR):
        return False
    last = [path.blobs[-1] for path in pair]
    return all(
        abs(one.x_px - blob.x_px) < (blob.width_px + one.width_px) / 2
        and abs(one.y_px - blob.y_px) < (blob.height_px + one.height_px) / 2
        for one in last
    )


def _pieces(pair: tuple[Path, Path], blob: Blob) -> list[tuple[Path, Blob]]:
    """Put each body at its end of the patch, along either axis."""
    one, two = (path.blobs[-1] for path in pair)
    x = _centres((_across(one), _across(two)), _across(blob))
    y = _centres((_down(one), _down(two)), _down(blob))
    return [
        (
            path,
            replace(
                last,
                x_px=x[place],
                y_px=y[place],
                left_px=last.left_px + x[place] - last.x_px,
                top_px=last.top_px + y[place] - last.y_px,
            ),
        )
        for place, (path, last) in enumerate(zip(pair, (one, two), strict=True))
    ]


def _across(blob: Blob) -> Extent:
    return blob.left_px, blob.x_px, blob.left_px + blob.width_px


def _down(blob: Blob) -> Extent:
    return blob.top_px, blob.y_px, blob.top_px + blob.height_px


def _centres(bodies: tuple[Extent, Extent], whole: Extent) -> tuple[float, float]:
    """Centres of two bodies that make up a whole: the lower one begins it, the other ends it."""
    (low_one, one, high_one), (low_two, two, high_two) = bodies
    if one <= two:
        return whole[0] + one - low_one, whole[2] - (high_two - two)
    return whole[2] - (high_one - one), whole[0] + two - low_two

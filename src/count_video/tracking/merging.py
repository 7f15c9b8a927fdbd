"""Two bodies that come so near each other that they stand out as one patch, told apart again.

Each reaches to one end of the patch they make together, and its size is known from before: so its
centre lies half its size from that end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from count_video.tracking.blobs import Blob

AREA_FACTOR = 1.4
"""The area of both together, to this factor: the gap between them is bridged, a part may hide."""

Extent = tuple[float, float, float]
"""Of a patch along one axis, in px: where it begins, its centre, where it ends."""


@dataclass(frozen=True)
class Known:
    """A body that was followed until just now."""

    last: Blob
    """Where it was last seen."""
    area_px: float
    """Its usual area."""


def parted(
    bodies: Sequence[Known], blobs: Sequence[Blob]
) -> tuple[list[tuple[int, Blob]], list[Blob]]:
    """Part the patches that two bodies make up together.

    Parameters
    ----------
    bodies
        Those that no patch goes on with.
    blobs
        The patches that go on with no body.

    Returns
    -------
    tuple
        The place of each such body in the list with its piece, and the patches that were parted.
    """
    left = list(range(len(bodies)))
    pieces: list[tuple[int, Blob]] = []
    whole = []
    for blob in blobs:
        for one, two in combinations(left, 2):
            if _make((bodies[one], bodies[two]), blob):
                pieces += zip(
                    (one, two), _pieces((bodies[one].last, bodies[two].last), blob), strict=True
                )
                whole.append(blob)
                left = [place for place in left if place not in (one, two)]
                break
    return pieces, whole


def _make(pair: tuple[Known, Known], blob: Blob) -> bool:
    """Whether two bodies make up a patch, by their areas and by where they last were."""
    area = sum(body.area_px for body in pair)
    if abs(np.log(blob.area_px / area)) > np.log(AREA_FACTOR):
        return False
    return all(
        abs(last.x_px - blob.x_px) < (blob.width_px + last.width_px) / 2
        and abs(last.y_px - blob.y_px) < (blob.height_px + last.height_px) / 2
        for last in (body.last for body in pair)
    )


def _pieces(pair: tuple[Blob, Blob], blob: Blob) -> list[Blob]:
    """Put each body at its end of the patch, along either axis."""
    one, two = pair
    xs = _centres((_across(one), _across(two)), _across(blob))
    ys = _centres((_down(one), _down(two)), _down(blob))
    return [
        replace(
            last,
            x_px=x,
            y_px=y,
            left_px=last.left_px + x - last.x_px,
            top_px=last.top_px + y - last.y_px,
            parted=True,
        )
        for last, x, y in zip(pair, xs, ys, strict=True)
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

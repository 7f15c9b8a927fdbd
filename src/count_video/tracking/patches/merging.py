"""Two bodies that come so near each other that they stand out as one patch, told apart again.

A rigid body keeps its area and the variances of its cover. So the patch that two make up together
has its centre between theirs, as their areas weigh, and is wider than they are by what their
distance adds to the variances,

    V = (A1 V1 + A2 V2) / A + A1 A2 / A^2 d d^T    (the theorem of parallel axes)

which tells the distance d to a fraction of a pixel. Where that leads nowhere, each body reaches to
one end of the patch, and its centre lies half its size from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from count_video.records import Floats
from count_video.tracking.patches.blobs import Blob

AREA_FACTOR = 1.4
"""The area of both together, to this factor: the gap between them is bridged, a part may hide."""

ENDS_TELL_PX = 4.0
"""The ends of a patch tell where the bodies are to a few px: the rims of both are blurred, and the
gap between them is bridged."""

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
    """Put each body at its end of the patch."""
    one, two = pair
    xs = _centres((_across(one), _across(two)), _across(blob))
    ys = _centres((_down(one), _down(two)), _down(blob))
    by_ends = np.array([[xs[0], ys[0]], [xs[1], ys[1]]])
    by_spread = _by_spread(pair, blob, by_ends[1] - by_ends[0])
    strays = np.hypot(*(by_spread - by_ends).T)
    places = by_spread if float(strays.max()) < ENDS_TELL_PX else by_ends
    return [moved_to(last, x, y) for last, (x, y) in zip(pair, places.tolist(), strict=True)]


def moved_to(body: Blob, x_px: float, y_px: float) -> Blob:
    """Move a body to another place."""
    across, down = x_px - body.x_px, y_px - body.y_px
    cover = body.moments
    return replace(
        body,
        x_px=x_px,
        y_px=y_px,
        left_px=body.left_px + across,
        top_px=body.top_px + down,
        moments=replace(cover, x_px=cover.x_px + across, y_px=cover.y_px + down),
    )


def _by_spread(pair: tuple[Blob, Blob], blob: Blob, about_px: Floats) -> Floats:
    """Centres of two bodies, shape (2, 2), by the centre and the variances of their patch.

    ``about_px`` tells in which direction the second lies from the first.
    """
    areas = np.array([body.moments.area_px for body in pair])
    shares = areas / areas.sum()
    known = sum(share * _variances(body) for share, body in zip(shares, pair, strict=True))
    values, axes = np.linalg.eigh(_variances(blob) - known)
    apart = float(np.sqrt(max(float(values[1]), 0.0) / float(shares[0] * shares[1])))
    apart_px = axes[:, 1] * apart * (1.0 if float(axes[:, 1] @ about_px) >= 0 else -1.0)
    middle = np.array([blob.moments.x_px, blob.moments.y_px])
    centres = np.array([middle - shares[1] * apart_px, middle + shares[0] * apart_px])
    # The centre of the cover is not quite that of the patch.
    return np.asarray(centres + [[b.x_px - b.moments.x_px, b.y_px - b.moments.y_px] for b in pair])


def _variances(blob: Blob) -> Floats:
    spread = blob.moments
    return np.array([[spread.xx_px2, spread.xy_px2], [spread.xy_px2, spread.yy_px2]])


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

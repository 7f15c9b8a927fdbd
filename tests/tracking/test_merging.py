from __future__ import annotations

import numpy as np
from drawn import background, paint_disc, to_luma

from count_video.tracking.patches.blobs import Sight, see
from count_video.tracking.patches.merging import Known, moved_to, parted
from count_video.tracking.patches.scenery import learn_scenery

RADIUS_PX = 15.0
PARTED_PX = 0.5
"""Two bodies that touch are told apart to half a pixel."""


def sight_of(places: list[tuple[float, float]]) -> Sight:
    behind = background((90, 200), 5)
    scenery = learn_scenery([to_luma(behind)] * 12, 1)
    canvas = behind.copy()
    for x, y in places:
        paint_disc(canvas, x, y, RADIUS_PX, 230.0)
    return see(0, to_luma(canvas), scenery)


def test_bodies_that_touch_are_parted_by_the_spread_of_their_patch() -> None:
    apart = sight_of([(50.0, 40.0), (120.0, 45.0)])
    truth = np.array([(70.3, 41.2), (99.8, 44.6)])
    touching = sight_of([(float(x), float(y)) for x, y in truth])
    known = sorted(apart.blobs, key=lambda blob: blob.x_px)
    near = [
        Known(moved_to(blob, float(x) - 1.0, float(y)), blob.area_px)
        for blob, (x, y) in zip(known, truth, strict=True)
    ]

    pieces, whole = parted(near, touching.blobs)

    assert len(touching.blobs) == len(whole) == 1
    found = np.array([(piece.x_px, piece.y_px) for _, piece in sorted(pieces, key=lambda p: p[0])])
    assert float(np.abs(found - truth).max()) < PARTED_PX

"""A body that falls into parts before the scenery, put together again.

A stripe across a block may be as bright as what lies behind it. Then some pictures show one patch
and others two, and the larger one's centre is not the body's. The parts of a rigid body keep their
distance, and put together they make up a patch that keeps its area.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from count_video.records import Floats
from count_video.tracking.patches.blobs import Blob, Moments, Sight
from count_video.tracking.patches.choice import SIGHTINGS_AT_LEAST, at_rows, keeps_its_distance
from count_video.tracking.patches.paths import Path

STRAYS = 3.0
OFF_PX = 2.0
"""A part lies where it usually does, to so many times its usual stray and so many px."""


def completed(body: Path, paths: Sequence[Path], sights: Sequence[Sight]) -> Path:
    """Put a body's parts together in the pictures that show it in parts.

    Parameters
    ----------
    body
        Path of the largest part, or of the whole in some pictures.
    paths
        All paths of the clip, those of other parts among them.
    sights
        What each picture shows; paths tell their pictures by places in this list.
    """
    for part in paths:
        apart = _usual_distance(part, body)
        if apart is None:
            continue
        whole = _together(body, apart, sights)
        if _scatter(whole) < _scatter(body):
            body = whole
    return body


def _usual_distance(part: Path, body: Path) -> tuple[Floats, float] | None:
    """How far a part usually is from the rest of a body, shape (2,), and its stray, in px."""
    common = sorted(set(part.rows) & set(body.rows))
    if part is body or len(common) < SIGHTINGS_AT_LEAST:
        return None
    place = at_rows(body, common)
    apart = at_rows(part, common) - place
    if not keeps_its_distance(apart, place, body.size_px + part.size_px):
        return None
    usual = np.median(apart, axis=0)
    return usual, float(np.median(np.hypot(*(apart - usual).T)))


def _together(body: Path, apart: tuple[Floats, float], sights: Sequence[Sight]) -> Path:
    usual, stray = apart
    reach = STRAYS * stray + OFF_PX
    blobs = []
    for row, blob in zip(body.rows, body.blobs, strict=True):
        x, y = blob.x_px + usual[0], blob.y_px + usual[1]
        parts = [
            other
            for other in sights[row].blobs
            if np.hypot(other.x_px - x, other.y_px - y) < reach and not other.at_border
        ]
        blobs.append(_union(blob, parts[0]) if parts else blob)
    return Path(list(body.rows), blobs)


def _scatter(path: Path) -> float:
    """How far the area strays from the usual one, as a share."""
    areas = np.log([blob.area_px for blob in path.blobs])
    return float(np.mean(np.abs(areas - np.median(areas))))


def _union(one: Blob, other: Blob) -> Blob:
    """Make one patch of two and of what lies between them, all of it covered."""
    left, right = _ends((one.left_px, one.width_px), (other.left_px, other.width_px))
    top, bottom = _ends((one.top_px, one.height_px), (other.top_px, other.height_px))
    width, height = right - left, bottom - top
    # Parts of a block fill their boxes, and the stripe between them does.
    shares = [blob.area_px / (blob.width_px * blob.height_px) for blob in (one, other)]
    area = width * height * float(np.mean(shares))
    x, y = left + (width - 1) / 2, top + (height - 1) / 2
    moments = Moments(area, x, y, width**2 / 12, 0.0, height**2 / 12)
    contrast = max(one.contrast, other.contrast)
    return Blob(x, y, left, top, width, height, area, contrast, False, moments)


def _ends(one: tuple[float, float], other: tuple[float, float]) -> tuple[float, float]:
    return min(one[0], other[0]), max(sum(one), sum(other))

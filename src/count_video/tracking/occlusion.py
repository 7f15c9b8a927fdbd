"""What one body hides of another: those pixels have no say where the other is registered.

Bodies are solid, but a template may hold more than the solid: a shadow that moves with the ball is
covered by the cylinder that comes up to it, and a hand passes in front of both. Where the inner
parts of two templates overlap, the one that explains the picture better is in front.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import permutations

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.signals import interpolated
from count_video.tracking.cutting import EDGE_PX
from count_video.tracking.following import Again, Clip, Followed, follow
from count_video.tracking.registration import Hides
from count_video.tracking.template import Pixels

COMPARED = 12
"""Who is in front is judged in so many of the pictures in which two bodies overlap."""


@dataclass(frozen=True)
class _Solid:
    """A body, and what of its template is more than the blurred edges around it."""

    held: NDArray[np.bool_]
    """Where the template is, in its shape."""
    inner: NDArray[np.bool_]
    """Where the solid is."""
    appearance: Pixels
    corners_px: Floats
    """Top left pixel of the template in each of n pictures, by x and y, shape (n, 2); between the
    pictures that show it interpolated."""
    seen: NDArray[np.bool_]
    """Which pictures show it, shape (n,)."""


def unhidden(clip: Clip, followed: Sequence[Followed]) -> list[Followed]:
    """Find bodies again where others are in front of them, by what is left to be seen."""
    solids = [_solid(clip, seen) for seen in followed]
    front: dict[int, list[_Solid]] = {}
    hidden = np.zeros((len(followed), len(clip.frames)), np.bool_)
    for one, other in permutations(range(len(followed)), 2):
        near = _near(solids[one], solids[other])
        if near.any() and _is_in_front(clip, solids[other], solids[one], near):
            front.setdefault(one, []).append(solids[other])
            hidden[one] |= near
    return [
        follow(clip, seen.body, Again(seen, hidden[k], partial(_hides, front[k])))
        if k in front
        else seen
        for k, seen in enumerate(followed)
    ]


def _solid(clip: Clip, seen: Followed) -> _Solid:
    held = (seen.body.template.weight > 0).astype(np.uint8)
    kernel = np.ones((2 * EDGE_PX + 1, 2 * EDGE_PX + 1), np.uint8)
    inner = cv2.erode(held, kernel, borderType=cv2.BORDER_CONSTANT, borderValue=0) > 0
    known = np.isfinite(seen.x_px)
    corners = np.stack([interpolated(place) for place in (seen.x_px, seen.y_px)], axis=1)
    return _Solid(
        held > 0, np.asarray(inner), seen.body.template.appearance, corners + clip.shift_px, known
    )


def _near(one: _Solid, other: _Solid) -> NDArray[np.bool_]:
    """Which pictures show the second where the first is, or is between two sightings."""
    away = other.corners_px - one.corners_px
    beyond = np.array([body.inner.shape[::-1] for body in (other, one)]) + EDGE_PX
    return np.asarray(((away > -beyond[0]) & (away < beyond[1])).all(axis=1) & other.seen)


def _shared(one: _Solid, other: _Solid, row: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Rows and columns of two templates that lie upon each other in a picture."""
    corners = [np.round(body.corners_px[row, ::-1]).astype(int) for body in (one, other)]
    low = np.maximum(*corners)
    ends = [c + body.inner.shape for c, body in zip(corners, (one, other), strict=True)]
    high = np.maximum(np.minimum(*ends), low)
    mine, its = (
        tuple(slice(int(a), int(b)) for a, b in zip(low - c, high - c, strict=True))
        for c in corners
    )
    return mine, its


def _is_in_front(clip: Clip, one: _Solid, other: _Solid, near: NDArray[np.bool_]) -> bool:
    """Whether the first explains better what both overlap in some of these pictures."""
    left_over = np.zeros(2)
    shown = np.flatnonzero(near & one.seen & other.seen)
    for row in shown[:: len(shown) // COMPARED + 1].tolist():
        mine, its = _shared(one, other, row)
        both = one.inner[mine] & other.inner[its]
        y, x = (
            places + part.start + round(corner)
            for places, part, corner in zip(
                np.nonzero(both), mine, one.corners_px[row, ::-1].tolist(), strict=True
            )
        )
        picture = clip.pictures[int(clip.frames[row])]
        inside = (y >= 0) & (x >= 0) & (y < picture.shape[0]) & (x < picture.shape[1])
        seen = picture[y[inside], x[inside]].astype(np.float32)
        for k, expected in enumerate((one.appearance[mine][both], other.appearance[its][both])):
            left_over[k] += float(np.abs(seen - expected[inside]).sum())
    return bool(left_over[0] < left_over[1])


def _hides(front: Sequence[_Solid], row: int) -> Hides:
    """Mark what bodies in front cover of a picture, their blurred edges included."""

    def hides(x: NDArray[np.intp], y: NDArray[np.intp]) -> NDArray[np.bool_]:
        marked = np.zeros(len(x), np.bool_)
        for body in front:
            left, top = np.round(body.corners_px[row]).astype(int)
            u, v = x - left, y - top
            within = (u >= 0) & (v >= 0) & (u < body.held.shape[1]) & (v < body.held.shape[0])
            marked[within] |= body.held[v[within], u[within]]
        return marked

    return hides

"""What a body hides of a picture: a box around it, or its pixels, by the place of the body."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats, Luma, Mask, Pixels, Point
from count_video.video.pictures import reduced

Box = tuple[float, float, float, float]
"""Left, top, right, bottom in px."""
Part = tuple[slice, slice]
"""Rows and columns of a picture."""

MOSTLY = 0.5
"""A px of a reduced body is its own if so much of it is."""
MARGIN_PX = 3.0
"""So far around its outline a body hides what lies behind it."""
DIFFERENT_PX, DIFFERENT_SHARE = 2.0, 0.02
"""Paths whose distance varies by less, as a standard deviation, may be those of one body, or by
less than this share of its way: what polished metal mirrors creeps over it as it moves."""


def size_of(box: Box) -> Point:
    """Width and height of a box."""
    return box[2] - box[0], box[3] - box[1]


@dataclass(frozen=True, eq=False)
class Shape:
    """A box that moves."""

    path_px: Floats
    """Image x and y of a point that moves with it, in each sample, shape (samples, 2); NaN where it
    is not seen."""
    box: Box
    """From that point."""
    appearance: tuple[Pixels, Mask] | None = None
    """Its brightness, and which of these pixels are its own, with that point at the top left; None
    where it is not known."""

    def reduced(self, scale: int) -> Shape:
        """Reduce it, for pictures that are reduced alike."""
        left, top, right, bottom = (edge / scale for edge in self.box)
        appearance = None
        if self.appearance is not None:
            share = reduced(self.appearance[1].astype(np.float32), scale)
            appearance = reduced(self.appearance[0], scale), share > MOSTLY
        return Shape(self.path_px / scale, (left, top, right, bottom), appearance)

    def paint(self, piece: Pixels, sample: int, corner: Point) -> Mask:
        """Paint the body over what lies behind it in a piece of a picture, in place.

        ``corner`` is where the piece's top left pixel lies. Returns where the body is, shape
        (height, width).
        """
        covered = np.zeros(piece.shape, np.bool_)
        x, y = (self.path_px[sample] - corner).tolist()
        if math.isnan(x) or self.appearance is None:
            return covered
        levels, held = self.appearance
        height, width = levels.shape
        left, top = max(0, math.floor(x)), max(0, math.floor(y))
        part = (
            slice(top, max(top, math.ceil(y) + height)),
            slice(left, max(left, math.ceil(x) + width)),
        )
        under = piece[part]
        if under.size == 0:
            return covered
        shift = np.array([[1.0, 0.0, x - left], [0.0, 1.0, y - top]])
        size, edge = under.shape[::-1], cv2.BORDER_REPLICATE
        own = cv2.warpAffine(held.astype(np.uint8), shift, size, flags=cv2.INTER_NEAREST)
        covered[part] = own > 0
        seen = cv2.warpAffine(levels, shift, size, borderMode=edge)
        np.copyto(under, seen, where=covered[part])
        return covered

    def part(self, sample: int, corner: Point = (0.0, 0.0), scale: int = 1) -> Part:
        """Rows and columns of a picture that lie within the box; none if it is not there.

        ``corner`` is where the picture's top left pixel lies, ``scale`` how many px one of its
        holds.
        """
        x, y = (self.path_px[sample] - corner).tolist()
        if math.isnan(x):
            return slice(0, 0), slice(0, 0)
        left, top, right, bottom = self.box
        low_x, low_y = (max(0, round((v - MARGIN_PX) / scale)) for v in (x + left, y + top))
        high_x, high_y = (max(0, round((v + MARGIN_PX) / scale)) for v in (x + right, y + bottom))
        return slice(low_y, high_y), slice(low_x, high_x)

    def holds(self, other: Shape) -> bool:
        """Whether it covers the middle of another in most of the samples that show both."""
        left, top, right, bottom = self.box
        middle = (other.box[0] + other.box[2]) / 2, (other.box[1] + other.box[3]) / 2
        x, y = known_of(other.path_px + middle - self.path_px).T
        inside = (x > left) & (x < right) & (y > top) & (y < bottom)
        return len(x) > 0 and bool(inside.mean() > 0.5)

    def moves_with(self, other: Shape) -> bool:
        """Whether two boxes may be parts of one body; true if no sample shows both."""
        apart = known_of(other.path_px - self.path_px)
        if len(apart) == 0:
            return True
        way = float(np.ptp(known_of(self.path_px), axis=0).max())
        return bool(np.std(apart, axis=0).max() < max(DIFFERENT_PX, DIFFERENT_SHARE * way))


def share_within(path_px: Floats, shape: tuple[int, ...], picture: tuple[int, ...]) -> Floats:
    """Share of a box that pictures show, with its top left pixel on a path, shape (..., 2)."""
    shown = np.minimum(path_px + shape[::-1], picture[::-1]) - np.maximum(path_px, 0.0)
    return np.asarray(np.prod(np.maximum(shown, 0.0) / shape[::-1], axis=-1))


def known_of(path_px: Floats) -> Floats:
    """Places of a path, shape (samples, 2), in the samples that show it, shape (n, 2)."""
    return np.asarray(path_px[np.isfinite(path_px[:, 0])])


def hidden(shapes: Sequence[Shape], sample: int, corner: Point, size: tuple[int, ...]) -> Luma:
    """Mark what shapes cover of a piece of a picture, shape (height, width)."""
    return marked([shape.part(sample, corner) for shape in shapes], size)


def marked(parts: Sequence[Part], size: tuple[int, ...]) -> Luma:
    """Mark parts of a picture of this size with ones."""
    marks = np.zeros(size, np.uint8)
    for part in parts:
        marks[part] = 1
    return marks

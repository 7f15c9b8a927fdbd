"""Which two bodies does the clip show? From runs of frames to the learnt appearance of both.

A candidate pair of moving patches is believed when both bodies are found again all over the clip,
always side by side in the same order, and move on their own: a mirror image in the clear wall also
moves opposite to the ball, but so exactly that the sum of the two places never changes, and of two
parts of one body the difference never does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Frame
from count_video.tracking.looks.learning import Body, learn
from count_video.tracking.looks.sightings import Box, Seed
from count_video.tracking.pairs.features import MovingFeatures
from count_video.tracking.pairs.seeds import (
    Patch,
    PatchPair,
)

WIDTH_OVER_HEIGHT = 1.3
"""Of a long body only the part next to its neighbour is learnt, by the height that both share. That
is too little of a body without a pattern beside one that shows only a print: it takes its own."""
BEYOND_FEATURES = 0.2
"""Corner features lie within the outline: the box is larger by this share of its height."""
CORE_MARGIN_PX = 4
BODY_BEYOND_FEATURES = 0.9
ALONE_BEYOND_FEATURES = 0.45
"""A body's outline is not further from its features than this share of its height; the second
towards a neighbour whose place in the same picture is not known."""
OVERLAP_SHARE = 0.25
"""Outlines may overlap by this share of the left one's width: bodies are round, views oblique."""
ORDERED_SHARE = 0.75
"""Share of the common sightings in which the order must hold; the others were mistaken."""
MIRROR_SHARE = 0.05
"""Places whose sum varies by less than this share of their difference are mirror images; where it
is the difference that hardly varies, they are parts of one body."""


@dataclass(frozen=True)
class Bodies:
    """The two bodies, the left one first, and the line they move on."""

    left: Body
    right: Body
    tilt_deg: float
    """Direction of motion in the picture that was searched."""
    upright: bool
    """True if that picture was transposed because the bodies move up and down."""
    seen_as: PatchPair
    """The moving patches from which they were learnt."""

    def swept(self) -> list[Box]:
        """Boxes (left, top, right, bottom) in px of the picture that the bodies pass over.

        They reach as far as the bodies were seen when they were learnt.
        """
        boxes = [_swept(body) for body in (self.left, self.right) if body.sightings]
        if not self.upright:
            return boxes
        return [(top, left, bottom, right) for left, top, right, bottom in boxes]


def _swept(body: Body) -> Box:
    x, y = np.array(list(body.sightings.values())).T
    left, right = float(x.min()) + body.left_edge_px, float(x.max()) + body.right_edge_px
    return left, float(y.min()), right, float(y.max()) + body.sprite.shape[0]


@dataclass(frozen=True)
class NotFound:
    """Why no pair of bodies was found, in words for the user."""

    reason: str


def learn_pair(
    runs: Sequence[Sequence[Frame]], pair: PatchPair, tilt_deg: float, *, wide: bool
) -> tuple[Body, Body] | None:
    """Learn both bodies of a pair, the left one first; None where they cannot be found again."""
    learnt = learn(runs, _seeds(runs, pair, wide=wide), tilt_deg)
    if learnt is None or not _side_by_side(*learnt):
        return None
    left, right = learnt
    return left, right


def _seeds(
    runs: Sequence[Sequence[Frame]], pair: PatchPair, *, wide: bool = False
) -> tuple[Seed, Seed]:
    """Boxes for both patches of a pair, on rows that they share.

    Seen in the same run, neither body reaches to the features of the other.
    """
    rows = (
        max(pair.left.top_px, pair.right.top_px),
        min(pair.left.bottom_px, pair.right.bottom_px),
    )
    height = rows[1] - rows[0]
    far, near = BODY_BEYOND_FEATURES * height, ALONE_BEYOND_FEATURES * height
    if pair.left.frame == pair.right.frame:
        left_ends, right_begins = pair.right.left_px, pair.left.right_px
    else:
        left_ends, right_begins = pair.left.right_px + near, pair.right.left_px - near
    left = Seed(
        _nearest_frame(runs, pair.left.frame),
        _box(pair.left, rows, 1, wide=wide),
        _core(pair.left),
        pair.left.speed_px_frame,
        (pair.left.left_px - far, left_ends),
    )
    right = Seed(
        _nearest_frame(runs, pair.right.frame),
        _box(pair.right, rows, -1, wide=wide),
        _core(pair.right),
        pair.right.speed_px_frame,
        (right_begins, pair.right.right_px + far),
    )
    return left, right


def _nearest_frame(runs: Sequence[Sequence[Frame]], frame: float) -> int:
    every = np.array([seen.index for run in runs for seen in run])
    return int(every[np.argmin(np.abs(every - frame))])


def _box(patch: Patch, rows: tuple[float, float], toward: int, *, wide: bool) -> Box:
    """Box for a patch, its rows shared with its neighbour; ``toward`` 1: that is on the right."""
    top, bottom = rows
    margin = BEYOND_FEATURES * (bottom - top) + 2
    left, right = patch.left_px, patch.right_px
    widest = WIDTH_OVER_HEIGHT * (patch.height_px if wide else bottom - top)
    if right - left > widest:
        left, right = (right - widest, right) if toward > 0 else (left, left + widest)
    return left - margin / 2, top - margin, right + margin / 2, bottom + margin


def _core(patch: Patch) -> Box:
    """Box that just holds the patch's features and the windows they were followed by."""
    margin = CORE_MARGIN_PX
    return (
        patch.left_px - margin,
        patch.top_px - margin,
        patch.right_px + margin,
        patch.bottom_px + margin,
    )


def _side_by_side(left: Body, right: Body) -> bool:
    """Check the order where both were seen, and that each moves on its own."""
    both = sorted(set(left.sightings) & set(right.sightings))
    if len(both) < 4:
        return False
    a = np.array([left.sightings[index][0] for index in both]) + left.right_edge_px
    b = np.array([right.sightings[index][0] for index in both]) + right.left_edge_px
    overlap = OVERLAP_SHARE * (left.right_edge_px - left.left_edge_px)
    ordered = b - a > -overlap
    if np.mean(ordered) < ORDERED_SHARE:
        return False
    return on_their_own(a[ordered], b[ordered])


def on_their_own(one_px: Floats, other_px: Floats) -> bool:
    """Whether two bodies move each on its own, by their places in the same pictures, shape (n,)."""
    together, apart = float(np.std(one_px + other_px)), float(np.std(one_px - other_px))
    return min(together, apart) > MIRROR_SHARE * max(together, apart)


def differ(learnt: tuple[Body, Body], tried: Sequence[Bodies]) -> bool:
    """Whether one of the two is another body than in each of the pairs tried."""
    return all(
        _apart(learnt[0], bodies.left) or _apart(learnt[1], bodies.right) for bodies in tried
    )


def _apart(one: Body, other: Body) -> bool:
    """Whether two bodies are at different places in the pictures that show both."""
    both = sorted(set(one.sightings) & set(other.sightings))
    if not both:
        return True
    middles, widths = [], []
    for body in (one, other):
        middle = (body.left_edge_px + body.right_edge_px) / 2
        middles.append(np.array([body.sightings[index][0] for index in both]) + middle)
        widths.append(body.right_edge_px - body.left_edge_px)
    return float(np.median(np.abs(middles[0] - middles[1]))) > min(widths) / 2


def transposed(frame: Frame) -> Frame:
    """Swap x and y of a frame."""
    return replace(frame, luma=_flip(frame.luma))


def _flip(luma: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.ascontiguousarray(luma.T)


def features_transposed(run: MovingFeatures) -> MovingFeatures:
    """Swap the features' places along and across the rows."""
    return replace(
        run,
        x_px=run.y_px,
        y_px=run.x_px,
        speed_x_px_frame=run.speed_y_px_frame,
        speed_y_px_frame=run.speed_x_px_frame,
    )

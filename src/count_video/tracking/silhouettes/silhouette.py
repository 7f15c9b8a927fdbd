"""Bodies as silhouettes before what stands still: a look that no turning mark changes.

The markings of a ball that spins pass over its face, and where a light one and a dark one take
turns at the rim, even the rim's contrast changes its sign. What stays is where the ball hides the
backdrop. A silhouette is 1 where a picture differs from the backdrop and 0 where it does not:

    |difference|       ____                    silhouette     _________
                      |    |__                               |         |
                   ___|       |___                        ___|         |___

Each difference is divided by the largest nearby, so that an edge of any contrast and of either
sign falls from 1 to 0 alike, and half way down lies the edge itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Frame
from count_video.tracking.patches.blobs import disc
from count_video.tracking.patches.scenery import (
    PICTURES,
    SHOWN_AT_LEAST,
    Luma,
    Scenery,
    difference,
    evenly_lit,
    scenery_of,
)

STACK_BYTES = 70_000_000
"""The pictures that tell the backdrop are held at once; so much may they take."""
SEAM_PX = 5
"""Between a part lighter than the backdrop and one darker the difference passes through zero:
over a px or two, for the lens and both smoothings blur by 1.3 px. Such seams are closed."""
EDGE_PX = 7
"""An edge blurred by 1.3 px has risen to 99 % within half of this."""
FAINT_FACTOR = 2.0
"""What differs by less than this many thresholds of the backdrop's noise is shown fainter."""
LIT, DARK = 220.0, 20.0
"""Grey levels of a silhouette and of what lies around it: the noise of neither is cut off."""
QUIET_FACTOR, QUIET_LEVELS = 2.0, 3.0
"""A pixel is quiet when its values spread by no more than this many times what most pixels' do, and
so many grey levels."""
NORMAL_SPAN = 2.56
"""Standard deviations of normal noise between the quantiles of 10 % and 90 %."""
NEAREST_SHARE = 0.2
"""What hides a pixel may do so in all pictures but this share."""
REACHED_SHARE = 0.05
"""A window tells a mean when this share of it is known."""
NEAR_FACE_PX = 6.0
"""What lies this near to the steady body's face is blurred with it."""


@dataclass(frozen=True)
class Beside:
    """The part of every picture that lies on one side of a body which is known already."""

    edge_px: Mapping[int, float]
    """Frame index -> image x of that body's edge."""
    toward: int
    """1 if the part lies at greater x than the edge, -1 if at smaller."""

    def hidden(self, frame: int, shape: tuple[int, ...], margin_px: float = 0.0) -> slice:
        """Columns that do not belong to the part, widened by a margin."""
        edge = self.edge_px[frame] + self.toward * margin_px
        if self.toward > 0:
            return slice(0, int(np.clip(np.ceil(edge), 0, shape[1])))
        return slice(int(np.clip(np.floor(edge) + 1, 0, shape[1])), shape[1])


@dataclass(frozen=True)
class Backdrop:
    """What stands still in the part of the pictures beside a body."""

    scenery: Scenery
    beside: Beside

    def silhouette(self, frame: int, luma: Luma) -> Luma:
        """Show what is before the backdrop, shape (height, width); all else is dark."""
        away = np.abs(difference(luma, self.scenery))
        away = cv2.morphologyEx(away, cv2.MORPH_CLOSE, disc(SEAM_PX))
        most = cv2.blur(cv2.dilate(away, disc(EDGE_PX)), (3, 3))
        share = away / np.maximum(most, FAINT_FACTOR * self.scenery.threshold)
        share[:, self.beside.hidden(frame, luma.shape)] = 0.0
        return np.asarray(np.clip(DARK + (LIT - DARK) * share, 0, 255), dtype=np.uint8)


def learn_backdrop(
    frames: Sequence[Frame], beside: Beside, boxes: Mapping[int, tuple[int, int, int, int]]
) -> Backdrop:
    """Learn what stands still from frames spread over the clip.

    ``boxes`` tells left, top, right and bottom of what else is known to hide it, by frame.
    """
    pixels = frames[0].luma.size
    count = max(1, min(PICTURES, len(frames), STACK_BYTES // (4 * pixels)))
    some = [frames[place * len(frames) // count] for place in range(count)]
    hidden = []
    for seen in some:
        mask = np.zeros(seen.luma.shape, dtype=np.uint8)
        mask[:, beside.hidden(seen.index, mask.shape, NEAR_FACE_PX)] = 1
        if seen.index in boxes:
            left, top, right, bottom = boxes[seen.index]
            mask[max(0, top) : max(0, bottom), max(0, left) : max(0, right)] = 1
        hidden.append(mask)
    return Backdrop(_scenery([seen.luma for seen in some], np.array(hidden) > 0), beside)


def _scenery(pictures: Sequence[Luma], hidden: NDArray[np.bool_]) -> Scenery:
    """Tell what stands still by the pictures that show each pixel.

    A body that rests, or swings to and fro, hides some pixels nearly always. Those values are taken
    that are nearest to what the quiet surroundings lead to expect.
    """
    stack = evenly_lit(pictures)
    stack[hidden] = np.nan
    ordered = np.sort(stack, axis=0)  # NaN last
    shown = np.isfinite(ordered).sum(axis=0)
    low, middle, high = (_quantile(ordered, shown, share) for share in (0.1, 0.5, 0.9))
    known = shown >= SHOWN_AT_LEAST
    usual = float(np.median((high - low)[known])) if known.any() else 0.0
    quiet = known & (high - low < QUIET_FACTOR * usual + QUIET_LEVELS)
    expected = _filled(middle, quiet)
    away = np.sort(np.abs(stack - expected), axis=0)
    near = _quantile(away, shown, NEAREST_SHARE)
    stack[~(np.abs(stack - expected) <= near)] = np.nan
    ordered = np.sort(stack, axis=0)
    nearest = _quantile(ordered, np.isfinite(ordered).sum(axis=0), 0.5)
    luma = np.where(quiet, middle, np.where(known, nearest, expected))
    return scenery_of(luma, np.where(quiet, (high - low) / NORMAL_SPAN, usual / NORMAL_SPAN), 1)


def _quantile(
    ordered: NDArray[np.float32], shown: NDArray[np.intp], share: float
) -> NDArray[np.float32]:
    """Quantile of each pixel's first ``shown`` values, shape (height, width)."""
    place = np.round(share * np.maximum(shown - 1, 0)).astype(np.intp)
    return np.asarray(np.take_along_axis(ordered, place[None], axis=0)[0])


def _filled(luma: NDArray[np.float32], known: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Fill what is not known by means over windows, each as small as reaches what is known."""
    filled = np.where(known, luma, np.float32(0.0))
    missing = ~known
    size = 3
    while missing.any() and size < 2 * max(luma.shape):
        weight = cv2.blur(known.astype(np.float32), (size, size))
        mean = cv2.blur(np.where(known, luma, np.float32(0.0)), (size, size))
        reached = missing & (weight > REACHED_SHARE)
        filled[reached] = mean[reached] / weight[reached]
        missing &= ~reached
        size = 2 * size + 1
    return np.asarray(filled, dtype=np.float32)


def edges_by_frame(frames: Floats, edge_px: Floats) -> dict[int, float]:
    """Edge of a body in every frame, shape (n,) each; where it is not seen, as it was nearby."""
    seen = np.isfinite(edge_px)
    known = np.interp(frames, frames[seen], edge_px[seen])
    return dict(zip(frames.astype(int).tolist(), known.tolist(), strict=True))

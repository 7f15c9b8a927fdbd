"""The camera's own motion: parts of the background, followed as bodies are.

Where the camera stands still what is measured is noise, and nothing is corrected by it: the tracks
stay as they are. Where it moves, by more than that noise and by more than a small part of a pixel,
the shift is taken from every position, and its uncertainty is added.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.footage.pictures import reduced
from count_video.records import Floats
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.background import ROUNDING, Background
from count_video.tracking.following import Clip, follow, was_followed
from count_video.tracking.learning import Body
from count_video.tracking.registration import register
from count_video.tracking.shape import Box
from count_video.tracking.template import make_template, piece_at

Luma = NDArray[np.uint8]
Places = NDArray[np.intp]

PARTS, PARTS_AT_LEAST = 4, 2
"""The background is followed in so many parts, each of its own: they have to agree."""
BLOCK_PX, BLOCKS = 8, 16
"""A part is so many square blocks of this side with the clearest slopes by x, and as many by y:
together they hold as many pixels as a registration takes."""
BODIES = 2
MEASURED_OF = 16
"""What is scenery, and how well a part is found again, is measured in so many pictures."""
TREMBLE_AT_MOST_PX, CHANGED_SHARE = 4.0, 0.8
"""By the slope of its edges times the camera's tremble a block of scenery changes: by so much at
most in this share of the pictures. The changes by a body that comes and goes are larger, as it
fills a block."""
ALIKE_SIGMAS, ALIKE_PX = 3.0, 0.02
"""Parts scatter about their joint path by at most so many times as much as the steadiest one, or
as this: what scatters more moves by itself."""
STRAY_PX = 0.5
"""A part that strays so far from the others in one picture was taken for another one like it."""
SCATTER_AT_MOST_PX = 0.15
"""Parts of one rigid scene scatter by some hundredths of a pixel, by a tenth where they are faint
or compressed. Where all scatter more, they show no such scene."""
MOVED_AT_LEAST_PX = 0.35
"""Compression moves still scenery by up to 0.2 px."""
MOVED_SIGMAS = 8.0


@dataclass(frozen=True)
class Motion:
    """How the picture moved, one row a frame; NaN where it could not be measured."""

    shift_px: Floats
    """By x and y, shape (n, 2)."""
    sigma_px: Floats
    """Standard uncertainties, shape (n, 2)."""

    def turned(self) -> Motion:
        """Swap x and y."""
        return Motion(self.shift_px[:, ::-1], self.sigma_px[:, ::-1])


def scenery(
    pictures: Mapping[int, Luma], background: Background, swept: Sequence[Box]
) -> list[Body]:
    """Parts of the background that show where a picture lies; empty if nothing does.

    Parameters
    ----------
    pictures
        Frame index -> luma, shape (height, width), for some pictures.
    background
        What stands still in them, and how far the camera has roughly moved them.
    swept
        Boxes that what may be bodies passes over, the likeliest first.
    """
    known = sorted(background.shift_px)
    some = [known[k] for k in np.linspace(0, len(known) - 1, MEASURED_OF).astype(int)]
    seen = {frame: pictures[frame] for frame in some}
    changes = [
        _of_blocks(cv2.absdiff(background.as_it_stands(one, frame), background.luma))
        for frame, one in seen.items()
    ]
    change = np.quantile(changes, CHANGED_SHARE, axis=0)
    parts: list[Body] = []
    # What trembles with the scenery is among what may be a body; and where bodies pass over
    # everything, they hide it in some pictures only.
    for free_of in (swept, swept[:BODIES], ()):
        if len(parts) < PARTS_AT_LEAST:
            blocks = _clear_blocks(background, change, free_of)
            found = (_part(seen, background, among) for among in blocks)
            parts = [one for one in found if one is not None]
    return parts


def camera_motion(
    parts: Sequence[Body], pictures: Mapping[int, Luma], frames: NDArray[np.intp]
) -> Motion | None:
    """Measure how the camera moved; None where it stood still or nothing shows it.

    Parameters
    ----------
    parts
        Parts of the background.
    pictures
        Frame index -> luma, shape (height, width).
    frames
        Indices of those to measure it in, in order of time, shape (n,).
    """
    if len(parts) < PARTS_AT_LEAST:
        return None
    nothing = Background(np.zeros_like(pictures[int(frames[0])]), {}, {})
    clip = Clip(pictures, frames, nothing, np.zeros((len(frames), 2)))
    seen = [follow(clip, one) for one in parts]
    seen = [one for one in seen if was_followed(one.x_px)]
    if len(seen) < PARTS_AT_LEAST:
        return None
    noise = float(np.median([np.nanmedian(one.sigma_px) for one in seen]))
    joint = [
        _joint(np.array(along), noise)
        for along in ([one.x_px for one in seen], [one.y_px for one in seen])
    ]
    place, sigma = (np.stack(one, axis=1) for one in zip(*joint, strict=True))
    moves = _moves(place, sigma)
    if not moves.any():
        return None
    # A direction in which it stands is often one in which the scenery shows little.
    return Motion(np.where(moves, place, 0.0), np.where(moves, sigma, 0.0))


def _clear_blocks(background: Background, change: Floats, swept: Sequence[Box]) -> list[Places]:
    """Columns and rows of the blocks of each part, shape (n, 2) each.

    Those with the clearest slopes are taken of the blocks that are scenery beside what is swept,
    and not what bodies leave behind in the background. Along a straight edge nothing shows a shift,
    so those by x and those by y are parted each: the left half from the right one, and these by
    their rows.
    """
    luma = background.luma
    rows, columns = (size // BLOCK_PX for size in luma.shape)
    far = np.abs(np.array(list(background.shift_px.values()))).max(axis=0) + 1
    right, down = (1 + int(edge) // BLOCK_PX for edge in far)
    free = np.zeros((rows, columns), np.bool_)
    free[down : rows - down, right : columns - right] = True
    for box in swept:
        left, top, end, bottom = (max(0, int(edge)) // BLOCK_PX for edge in box)
        free[top : bottom + 1, left : end + 1] = False
    parts: list[list[Places]] = [[] for _ in range(PARTS)]
    for axis in (0, 1):
        slope = _of_blocks(np.abs(cv2.Sobel(luma, cv2.CV_32F, 1 - axis, axis, scale=1 / 8)))
        scenery = np.flatnonzero(free & (change < TREMBLE_AT_MOST_PX * slope + ROUNDING))
        best = scenery[np.argsort(-slope.ravel()[scenery], kind="stable")[: PARTS * BLOCKS]]
        y, x = np.divmod(best, max(columns, 1))
        order = np.argsort(x, kind="stable")
        halves = np.array_split(order, PARTS // 2)
        quarters = [q for half in halves for q in np.array_split(half[np.argsort(y[half])], 2)]
        for part, among in zip(parts, quarters, strict=True):
            part.append(BLOCK_PX * np.stack([x[among], y[among]], axis=1))
    return [np.unique(np.concatenate(part), axis=0) for part in parts]


def _of_blocks(picture: cv2.typing.MatLike) -> Floats:
    """Mean of each block, shape (rows, columns)."""
    return np.asarray(reduced(picture.astype(np.float32), BLOCK_PX), np.float64)


def _part(pictures: Mapping[int, Luma], background: Background, blocks: Places) -> Body | None:
    """Take blocks of the background for a body; None if pictures hardly show its place."""
    if len(blocks) == 0:
        return None
    corner = blocks.min(axis=0)
    width, height = blocks.max(axis=0) - corner + BLOCK_PX
    weight = np.zeros((height, width), np.float32)
    for left, top in blocks - corner:
        weight[top : top + BLOCK_PX, left : left + BLOCK_PX] = 1.0
    place = float(corner[0]), float(corner[1])
    template = make_template(piece_at(background.luma, *place, weight.shape), weight)
    roughly = {k: (place[0] + x, place[1] + y) for k, (x, y) in background.shift_px.items()}
    fits = [register(picture, template, roughly[k]) for k, picture in pictures.items()]
    sigma = [np.inf if fit is None else fit.sigma_x_px for fit in fits]
    if not np.median(sigma) < SCATTER_AT_MOST_PX:
        return None
    typical = float(np.median([fit.agreement for fit in fits if fit is not None]))
    return Body(
        template, 0.0, float(width), (0.0, float(height)), False, roughly, tuple(pictures), typical
    )


def _joint(paths: Floats, noise_px: float) -> tuple[Floats, Floats]:
    """Joint path of parts by one axis, and its standard uncertainty; shape (n,) each.

    ``paths`` has shape (parts, n). The uncertainty comes from their scatter about the joint path;
    by the noise alone it would be too small, for encoders move each part by itself. Parts that
    share no path show no motion.
    """
    known = np.isfinite(paths).any(axis=0)
    moved = paths[:, known]
    for _ in range(2):  # the offset of each part from the others, at last
        away = moved - np.nanmedian(moved, axis=0)
        moved = moved - np.nanmedian(away, axis=1, keepdims=True)
    away = np.abs(moved - np.nanmedian(moved, axis=0))
    scatter = MEDIAN_TO_SIGMA * np.nanmedian(away, axis=1)
    steady = scatter <= ALIKE_SIGMAS * max(float(scatter.min()), ALIKE_PX)
    kept = steady[:, None] & (away < STRAY_PX)
    count = kept.sum(axis=0)
    total = np.where(kept, moved, 0.0).sum(axis=0)
    shown = (count >= PARTS_AT_LEAST) & (2 * count > steady.sum())
    if not shown.any() or scatter.min() > SCATTER_AT_MOST_PX:
        return np.zeros(paths.shape[1]), np.zeros(paths.shape[1])
    rows = np.flatnonzero(known)[shown]
    place, sigma = (np.full(paths.shape[1], np.nan) for _ in range(2))
    place[rows] = total[shown] / count[shown]
    noise = max(float(np.sqrt(np.mean(scatter[steady] ** 2))), noise_px)
    sigma[rows] = noise / np.sqrt(count[shown])
    return place - np.nanmedian(place), sigma


def _moves(place: Floats, sigma: Floats) -> NDArray[np.bool_]:
    """Whether the picture was ever displaced for two of three neighbouring frames, by x and y."""
    away = np.abs(place - np.nanmedian(place, axis=0))
    lasting = np.median(np.stack([away[:-2], away[1:-1], away[2:]]), axis=0)
    noise = MOVED_SIGMAS * np.nanmedian(sigma, axis=0)
    return np.asarray(np.any(lasting > np.maximum(MOVED_AT_LEAST_PX, noise), axis=0))

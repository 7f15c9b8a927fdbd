"""The camera's own motion: parts of the background, found in every picture by x and by y apart.

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
from count_video.tracking.registration import Fit, register
from count_video.tracking.shape import Box, Place
from count_video.tracking.template import Template, make_template, piece_at

Luma = NDArray[np.uint8]
Places = NDArray[np.intp]

PARTS, PARTS_AT_LEAST = 4, 2
"""The background is followed in so many parts by x, and by y, each of its own: they have to
agree. Along a straight edge, as that of a wall, nothing shows a shift."""
BLOCK_PX, BLOCKS = 8, 16
"""A part is so many square blocks of this side with the clearest slopes."""
BODIES = 2
MEASURED_OF = 16
"""What is scenery, and how well a part is found again, is measured in so many pictures."""
TREMBLE_AT_MOST_PX, CHANGED_SHARE = 4.0, 0.8
"""By the slope of its edges times the camera's tremble a block of scenery changes: by so much at
most in this share of the pictures. The changes by a body that comes and goes are larger, as it
fills a block."""
ACROSS_RATIO = 3.0
"""A part with slopes so many times as steep along its axis as across it shows shifts along it."""
AROUND_PX = 3.0, -3.0
"""Parts that a tremble moves further than a registration reaches are sought so far around."""
UNSURE_FACTOR = 4.0
"""What is so many times as unsure as usual is something else."""
SEEN_AT_LEAST = 0.5
"""A part is found in this share of the pictures."""
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
class Part:
    """A part of the background."""

    template: Template
    place: Place
    """Of its top left pixel, by image x and y, freed of the camera's motion."""
    axis: int
    """By which it shows a shift: x (0) or y (1)."""
    sigma_px: float
    """Median standard uncertainty of its shift in some pictures."""


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
) -> list[Part]:
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
    parts: list[Part] = []
    # What trembles with the scenery is among what may be a body; and where bodies pass over
    # everything, they hide it in some pictures only.
    for free_of in (swept, swept[:BODIES], ()):
        if len(parts) < PARTS_AT_LEAST:
            blocks = _clear_blocks(background, change, free_of)
            found = (
                _part(seen, background, among, axis)
                for axis, parted in enumerate(blocks)
                for among in parted
            )
            parts = [one for one in found if one is not None]
    return parts


def camera_motion(
    parts: Sequence[Part],
    pictures: Mapping[int, Luma],
    frames: NDArray[np.intp],
    roughly: Mapping[int, Place],
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
    roughly
        Frame index -> how far it moved some of them, by x and y, right to some px.
    """
    if len(parts) < PARTS_AT_LEAST:
        return None
    known = sorted(roughly)
    guesses = np.stack(
        [np.interp(frames, known, [roughly[k][axis] for k in known]) for axis in (0, 1)], axis=1
    )
    along = [[one for one in parts if one.axis == axis] for axis in (0, 1)]
    seen = [np.full((len(some), len(frames), 2), np.nan) for some in along]
    away = [0.0, 0.0]
    for row, frame in enumerate(frames.tolist()):
        picture = pictures[frame]
        for axis, some in enumerate(along):
            seen[axis][:, row] = found = _shifts(some, picture, guesses[row], away[axis])
            if np.isfinite(found[:, 0]).any():
                away[axis] = float(np.nanmedian(found[:, 0])) - guesses[row, axis]
    joint = [_joint(one[np.isfinite(one[:, :, 0]).mean(axis=1) > SEEN_AT_LEAST]) for one in seen]
    place, sigma = (np.stack(one, axis=1) for one in zip(*joint, strict=True))
    moves = _moves(place, sigma)
    if not moves.any():
        return None
    # A direction in which it stands is often one in which the scenery shows little.
    return Motion(np.where(moves, place, 0.0), np.where(moves, sigma, 0.0))


def _shifts(parts: Sequence[Part], picture: Luma, guess: Floats, away: float) -> Floats:
    """How far parts of one axis are moved along it, and the uncertainties, shape (parts, 2).

    A registration reaches a few px only: where most parts are not found, they are sought around,
    and ``away`` from the guess, where they were before.
    """
    best = np.full((len(parts), 2), np.nan)
    for step in (0.0, away, *AROUND_PX):
        found = np.full((len(parts), 2), np.nan)
        for number, one in enumerate(parts):
            place = guess + one.place
            place[one.axis] += step
            fit = register(picture, one.template, (float(place[0]), float(place[1])))
            shift = _along(fit, one.axis, one.place) if fit is not None else (np.nan, np.inf)
            if shift[1] < UNSURE_FACTOR * one.sigma_px:
                found[number] = shift
        best = max(best, found, key=lambda some: int(np.isfinite(some[:, 0]).sum()))
        if 2 * np.isfinite(best[:, 0]).sum() > len(parts):
            break
    return best


def _along(fit: Fit, axis: int, place: Place) -> tuple[float, float]:
    """Shift from a place along an axis, and its uncertainty."""
    if axis == 0:
        return fit.x_px - place[0], fit.sigma_x_px
    return fit.y_px - place[1], fit.sigma_y_px


def _clear_blocks(
    background: Background, change: Floats, swept: Sequence[Box]
) -> list[list[Places]]:
    """Columns and rows of the blocks of each part by x, and by y, shape (n, 2) each.

    Those with the clearest slopes are taken of the blocks that are scenery beside what is swept,
    and not what bodies leave behind in the background. The left half is parted from the right one,
    and these by their rows.
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
    parts: list[list[Places]] = [[], []]
    for axis in (0, 1):
        slope = _of_blocks(np.abs(cv2.Sobel(luma, cv2.CV_32F, 1 - axis, axis, scale=1 / 8)))
        scenery = np.flatnonzero(free & (change < TREMBLE_AT_MOST_PX * slope + ROUNDING))
        best = scenery[np.argsort(-slope.ravel()[scenery], kind="stable")[: PARTS * BLOCKS]]
        y, x = np.divmod(best, max(columns, 1))
        order = np.argsort(x, kind="stable")
        for half in np.array_split(order, PARTS // 2):
            for among in np.array_split(half[np.argsort(y[half], kind="stable")], 2):
                parts[axis].append(BLOCK_PX * np.stack([x[among], y[among]], axis=1))
    return parts


def _of_blocks(picture: cv2.typing.MatLike) -> Floats:
    """Mean of each block, shape (rows, columns)."""
    return np.asarray(reduced(picture.astype(np.float32), BLOCK_PX), np.float64)


def _part(
    pictures: Mapping[int, Luma], background: Background, blocks: Places, axis: int
) -> Part | None:
    """Make a part of blocks of the background; None if pictures hardly show its place."""
    if len(blocks) == 0:
        return None
    corner = blocks.min(axis=0)
    width, height = blocks.max(axis=0) - corner + BLOCK_PX
    weight = np.zeros((height, width), np.float32)
    for left, top in blocks - corner:
        weight[top : top + BLOCK_PX, left : left + BLOCK_PX] = 1.0
    place = float(corner[0]), float(corner[1])
    piece = piece_at(background.luma, *place, weight.shape)
    template = make_template(piece, weight)
    if not _shows_both(template, axis):
        template = make_template(piece, weight, axis)
    shifts = background.shift_px
    fits = [
        register(picture, template, (place[0] + shifts[k][0], place[1] + shifts[k][1]))
        for k, picture in pictures.items()
    ]
    sigma = np.median([np.inf if fit is None else _along(fit, axis, place)[1] for fit in fits])
    return Part(template, place, axis, float(sigma)) if sigma < SCATTER_AT_MOST_PX else None


def _shows_both(template: Template, axis: int) -> bool:
    """Whether a part shows shifts across its axis as well, nearly as clearly."""
    slopes = np.square(template.model.design[:2]) @ template.model.weight
    return bool(slopes[1 - axis] * ACROSS_RATIO**2 > slopes[axis])


def _joint(seen: Floats) -> tuple[Floats, Floats]:
    """Joint path of parts by one axis, and its standard uncertainty; shape (n,) each.

    ``seen`` has the shifts of the parts and their uncertainties, shape (parts, n, 2). The joint
    uncertainty comes from their scatter about the joint path; by the noise alone it would be too
    small, for encoders move each part by itself. Parts that share no path show no motion.
    """
    nothing = np.zeros(seen.shape[1]), np.zeros(seen.shape[1])
    if len(seen) < PARTS_AT_LEAST:
        return nothing
    paths, noise_px = seen[:, :, 0], float(np.nanmedian(seen[:, :, 1]))
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
    clear = steady / np.nanmedian(seen[:, :, 1], axis=1) ** 2
    shown = (count >= PARTS_AT_LEAST) & (2 * clear @ kept >= clear.sum())
    if not shown.any() or scatter.min() > SCATTER_AT_MOST_PX:
        return nothing
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

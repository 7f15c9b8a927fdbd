"""Templates of bodies, and pieces of pictures smoothed alike, at a fraction of a pixel.

A template is the mean appearance of a body, smoothed by a Gaussian. A picture is smoothed by the
same Gaussian *shifted by the fraction of a pixel that is asked for*: a Gaussian of 0.8 px holds
almost nothing beyond the sampling frequency, so this interpolates and smooths in one exact step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Indices, Luma, Mask, Pixels

SMOOTHING_PX = 0.8
REACH_PX = 3
"""Half width of the smoothing kernel, nearly four standard deviations: what lies beyond has less
than a ten-thousandth of the weight of the middle."""
SLOPE_WEIGHTS = np.array([-1, 9, -45, 0, 45, -9, 1], dtype=np.float32) / 60
"""Weights of neighbours from -3 to 3 px: exact for polynomials up to the sixth degree."""
INFORMATIVE_PIXELS = 2000
"""More pixels than this cost time and add little: the best are taken."""
FLAT_SHARE = 1e-15
"""Smaller eigenvalues, as a share of the largest, are rounding."""
BLOCKS, BLOCK_PX = 16, 32
"""Of a template with many times as many pixels as so many blocks of this side, they are taken from
the best ones alone: what lies between them is then not read."""
LARGE_PIXELS = 4 * BLOCKS * BLOCK_PX**2
KERNEL_STEPS = 4096
"""Fractions of a pixel are distinguished to 0.00012 px at worst, far below any noise."""


@dataclass(frozen=True)
class Template:
    """Appearance of one body; pixel (0, 0) is the top left corner of the box around it."""

    appearance: Pixels
    """Mean smoothed luma, shape (height, width)."""
    weight: Pixels
    """Inverse variance of each pixel in 1 / grey level squared; 0 where it is not the body."""
    model: Model
    """The linearised template, at the pixels that take part in the registration."""

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in px."""
        height, width = self.appearance.shape
        return height, width

    @property
    def shift_variance(self) -> float:
        """Variance of a shift by x in px squared, by the noise of the template's pixels."""
        return float(self.model.inverse[0, 0]) * self.model.correlation


@dataclass(frozen=True)
class Tile:
    """A part of the template's box that holds chosen pixels; what is between tiles is not read."""

    left: int
    top: int
    """Column and row of the template at which it begins, with the kernel's reach around it."""
    shape: tuple[int, int]
    """Height and width in px."""
    pixels: Indices
    """Flat indices of the chosen pixels in it."""


@dataclass(frozen=True)
class Model:
    """Brightness of n chosen pixels, linear in shift x, shift y, gain and offset."""

    chosen: Indices
    """Flat indices of the pixels within the template, shape (n,), tile by tile."""
    tiles: tuple[Tile, ...]
    """Where these pixels lie, in their order."""
    design: Pixels
    """Shape (4, n): minus the slopes by x and y, the centred appearance, ones."""
    products: Pixels
    """Those of its rows with each other, shape (n, 16)."""
    weight: Pixels
    """Shape (n,)."""
    inverse: NDArray[np.float64]
    """Of the normal equations for all weights as given, shape (4, 4)."""
    correlation: float
    """Variance of the shift by x over that which independent pixels would give."""


def make_template(appearance: Pixels, weight: Pixels, across: float = 0.1) -> Template:
    """Complete a template; slopes by y count so many times as much as those by x."""
    slope_x, slope_y = _slopes(appearance)
    worth = (slope_x**2 + across * slope_y**2) * weight
    usable = np.flatnonzero((weight > 0) & _best_blocks(worth))
    if len(usable) > INFORMATIVE_PIXELS:
        best = np.argpartition(-worth.ravel()[usable], INFORMATIVE_PIXELS)[:INFORMATIVE_PIXELS]
        usable = np.sort(usable[best])
    tiles, order = tiles_of(usable, appearance.shape)
    usable = usable[order]
    flat = appearance.ravel()[usable]
    rows = [
        -slope_x.ravel()[usable],
        -slope_y.ravel()[usable],
        flat - flat.mean(),  # centred, so that gain and offset do not mix
        np.ones_like(flat),
    ]
    design = np.stack(rows).astype(np.float32)
    products = np.ascontiguousarray((design[:, None] * design).reshape(16, -1).T)
    chosen_weight = weight.ravel()[usable].astype(np.float32)
    inverse = inverse_of(design, chosen_weight)
    shift_x = np.asarray(inverse[0] @ (design * chosen_weight), np.float32)
    correlation = _correlation_factor(usable, shift_x, appearance.shape)
    return Template(
        appearance=np.ascontiguousarray(appearance, np.float32),
        weight=np.ascontiguousarray(weight, np.float32),
        model=Model(usable, tiles, design, products, chosen_weight, inverse, correlation),
    )


def _slopes(appearance: Pixels) -> tuple[Pixels, Pixels]:
    """Slopes of a smoothed picture by x and y, in grey levels per px.

    Differences of the next neighbours alone flatten an edge of this sharpness by a tenth. Every
    step of the registration would then go a tenth too far, and its last one stays uncorrected.
    """
    along, across = SLOPE_WEIGHTS, np.ones(1, dtype=np.float32)
    edge = cv2.BORDER_REPLICATE
    slope_x = cv2.sepFilter2D(appearance, cv2.CV_32F, along, across, borderType=edge)
    slope_y = cv2.sepFilter2D(appearance, cv2.CV_32F, across, along, borderType=edge)
    return np.asarray(slope_x, dtype=np.float32), np.asarray(slope_y, dtype=np.float32)


def _best_blocks(worth: Pixels) -> Mask:
    """Mark the pixels of the blocks that are worth most; all of them if the template is small."""
    if worth.size <= LARGE_PIXELS:
        return np.ones(worth.shape, np.bool_)
    total = worth
    for axis, size in enumerate(worth.shape):
        total = np.add.reduceat(total, range(0, size, BLOCK_PX), axis=axis)
    best = np.zeros(total.shape, np.bool_)
    best.flat[np.argsort(-total.ravel(), kind="stable")[:BLOCKS]] = True
    for axis, size in enumerate(worth.shape):
        best = best.repeat(BLOCK_PX, axis=axis).take(range(size), axis=axis)
    return best


def tiles_of(chosen: Indices, shape: tuple[int, ...]) -> tuple[tuple[Tile, ...], Indices]:
    """Cover chosen pixels of a template by a box, or by one a block where the template is large.

    Returns the tiles, and the order in which they hold the chosen pixels.
    """
    row, column = np.divmod(chosen, shape[1])
    large = shape[0] * shape[1] > LARGE_PIXELS
    block = large * (row // BLOCK_PX * shape[1] + column // BLOCK_PX)
    order, tiles = np.argsort(block, kind="stable"), []
    for inside in np.split(order, np.flatnonzero(np.diff(block[order])) + 1):
        if len(inside):
            y, x = row[inside], column[inside]
            top, left = int(y.min()) - REACH_PX, int(x.min()) - REACH_PX
            size = int(y.max()) - top + 1 + REACH_PX, int(x.max()) - left + 1 + REACH_PX
            tiles.append(Tile(left, top, size, (y - top) * size[1] + x - left))
    return tuple(tiles), order


def inverse_of(design: Pixels, weight: Pixels) -> NDArray[np.float64]:
    """Pseudo-inverse of the weighted normal equations, shape (4, 4)."""
    weighted = (design * weight).astype(np.float64)
    values, vectors = np.linalg.eigh(weighted @ design.T.astype(np.float64))
    good = values > FLAT_SHARE * values[-1]
    # Five times faster than numpy's for four by four.
    return np.asarray((vectors[:, good] / values[good]) @ vectors[:, good].T)


def _correlation_factor(chosen: Indices, combination: Pixels, shape: tuple[int, ...]) -> float:
    """How much a combination of pixels gains in variance because smoothing made them share noise.

    White noise of variance v, smoothed by a kernel g, has the variance v sum(g^2) in each pixel;
    a combination c of its pixels has v sum((c * g)^2) instead of v sum(g^2) sum(c^2).
    """
    picture = np.zeros((shape[0] + 2 * REACH_PX, shape[1] + 2 * REACH_PX), dtype=np.float32)
    row, column = np.divmod(chosen, shape[1])
    picture[row + REACH_PX, column + REACH_PX] = combination
    power, shared = (cv2.norm(one, cv2.NORM_L2SQR) for one in (picture, smooth(picture, 0.0, 0.0)))
    return shared / power / cv2.norm(_kernel(0.0), cv2.NORM_L2SQR) ** 2 if power else 1.0


def piece_at(picture: Luma, x_px: float, y_px: float, shape: tuple[int, int]) -> Pixels:
    """Cut out a smoothed piece of the picture at a fractional place.

    Returns shape ``shape``: the piece whose top left pixel lies at (``x_px``, ``y_px``). Beyond
    the picture's border its last row or column goes on.
    """
    left, top = round(x_px), round(y_px)
    around = shape[0] + 2 * REACH_PX, shape[1] + 2 * REACH_PX
    piece = cut(picture, left - REACH_PX, top - REACH_PX, around)
    return smooth(piece, x_px - left, y_px - top)[REACH_PX:-REACH_PX, REACH_PX:-REACH_PX]


def pixels_at(picture: Luma, x_px: float, y_px: float, tiles: tuple[Tile, ...]) -> Pixels:
    """Read the chosen pixels of a template at a fractional place, smoothed as by `piece_at`.

    Returns shape (n,), tile by tile.
    """
    left, top = round(x_px), round(y_px)
    seen = []
    for tile in tiles:
        piece = cut(picture, left + tile.left, top + tile.top, tile.shape)
        part = smooth(piece, x_px - left, y_px - top)
        seen.append(part.ravel()[tile.pixels])
    return np.concatenate(seen)


def cut(picture: Luma, left: int, top: int, shape: tuple[int, int]) -> Luma:
    """Cut out a box; beyond the picture's border its last row or column goes on."""
    height, width = shape
    rows, columns = picture.shape
    if left >= 0 and top >= 0 and left + width <= columns and top + height <= rows:
        return picture[top : top + height, left : left + width]
    # Of what lies wholly beyond the border the nearest row or column is all that is read.
    top, left = min(max(top, 1 - height), rows - 1), min(max(left, 1 - width), columns - 1)
    low_y, high_y = max(top, 0), min(top + height, rows)
    low_x, high_x = max(left, 0), min(left + width, columns)
    beyond = low_y - top, top + height - high_y, low_x - left, left + width - high_x
    shown = picture[low_y:high_y, low_x:high_x]
    return np.asarray(cv2.copyMakeBorder(shown, *beyond, cv2.BORDER_REPLICATE), np.uint8)


def smooth(piece: Luma | Pixels, fraction_x: float, fraction_y: float) -> Pixels:
    """Smooth as templates are, shifted by fractions of a pixel from -0.5 to 0.5."""
    if piece.strides[1] != piece.itemsize:  # OpenCV takes rows with gaps between, not within
        return smooth(piece.copy(), fraction_x, fraction_y)
    smoothed = cv2.sepFilter2D(piece, cv2.CV_32F, _kernel(fraction_x), _kernel(fraction_y))
    return np.asarray(smoothed, dtype=np.float32)


def _kernel(fraction: float) -> Pixels:
    """Gaussian sampled about ``fraction``, from -0.5 to 0.5, normalised."""
    return _kernel_about(round(fraction * KERNEL_STEPS))


@cache
def _kernel_about(steps: int) -> Pixels:
    taps = np.arange(-REACH_PX, REACH_PX + 1) - steps / KERNEL_STEPS
    bell = np.exp(-0.5 * (taps / SMOOTHING_PX) ** 2)
    return np.asarray(bell / bell.sum(), dtype=np.float32)

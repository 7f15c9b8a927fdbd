"""How the light changes from picture to picture: lamps that flicker, soft shadows that move.

A picture is the background times the light, except where bodies are. The logarithm of the light is
smooth: a sum of few cosines, fitted to the means of blocks of pixels. Those that a body changes are
left out (M-estimates with Tukey's biweight, found by modified residuals: Huber, Robust Statistics,
1981, section 7.8).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats, Luma, Pixels, Point
from count_video.signals import MEDIAN_TO_SIGMA

CHANGE_AT_LEAST = 0.01
"""Smaller changes of brightness, as a share of it, are left as they are."""
ROUNDING = 0.001
"""Of bytes, in the logarithm of a block's mean."""
NEIGHBOURS = 9
"""What is left open in so many blocks side by side is one thing: a body, or an edge."""
BLOCKS = 24
"""Blocks to the longer side of a picture by whose means the light is measured."""
HALF_WAVES = 5
"""The light has at most so many half waves to the longer side: bodies are smaller."""
DARK_LEVELS = 4.0
"""Is added to the means of blocks, in grey levels: the ratio of two dark ones is mostly noise."""
TUKEY, NOISE_AT_LEAST = 4.685, 0.004
"""Blocks are left out that stray by so many standard deviations (Tukey's constant: 95 % efficient
for normal noise), and a standard deviation of the logarithm that all have at least."""
STEPS, STEP_AT_LEAST = 20, CHANGE_AT_LEAST / 100
"""Of the iteration at most, none of which makes the fit worse, and the least that is worth another:
the smallest change of light is a hundred times as large."""
FITS = 2
"""The blocks are fitted so often; the second fit has the noise that the first one left over."""
RIDGE = 1e-6
"""Amplitudes that no block shows are none, by so small a share of what the others weigh."""


@dataclass(frozen=True)
class Light:
    """By how much one picture is brighter than the mean one."""

    gain: float = 1.0
    """Factor everywhere."""
    waves: Floats | None = None
    """The logarithm of a factor that varies over the picture: amplitudes of half waves by their
    number down and across it, shape (rows, columns). None where it is 1."""

    def turned(self) -> Light:
        """Swap x and y."""
        return self if self.waves is None else Light(self.gain, self.waves.T)

    def over(self, place: Point, shape: tuple[int, int], size: Sequence[float]) -> Pixels:
        """Brightness over a piece of a picture, of the piece's shape; shape () if it is all one.

        The piece begins at a place; ``shape`` and ``size`` are those of piece and picture.
        """
        if self.waves is None:
            return np.asarray(np.float32(self.gain))
        axes = zip(place[::-1], shape, size, self.waves.shape, strict=True)
        down, across = (
            _cosines((begin + 0.5 + np.arange(length, dtype=np.float64)) / whole, count)
            for begin, length, whole, count in axes
        )
        logarithm = (down @ self.waves).astype(np.float32) @ across.T.astype(np.float32)
        return np.asarray(np.float32(self.gain) * np.exp(logarithm))

    def levelled(
        self,
        piece: Luma,
        stretch: float = 1.0,
        place: Point = (0.0, 0.0),
        size: Sequence[float] = (),
    ) -> Luma:
        """Bring a piece of a picture to the mean brightness, times a factor.

        ``place`` and ``size`` are those of :meth:`over`; by default it is the whole picture.
        """
        if self.waves is not None:
            shape = piece.shape[0], piece.shape[1]
            factor = np.float32(stretch) / self.over(place, shape, size or shape)
            return np.asarray(cv2.multiply(piece, factor, dtype=cv2.CV_8U), np.uint8)
        alpha = stretch / self.gain
        return piece if alpha == 1.0 else np.asarray(cv2.convertScaleAbs(piece, alpha=alpha))

    def unless_faint(self) -> Light:
        """Leave small changes as they are."""
        faint = self.waves is None and abs(1 / self.gain - 1) <= CHANGE_AT_LEAST
        return Light() if faint else self


def gains_of(pictures: Iterable[Luma]) -> Floats:
    """Brightness of n pictures over that of all, shape (n,)."""
    brightness = np.array([cv2.mean(one)[0] for one in pictures]) + 1e-6
    return np.asarray(brightness / brightness.mean())


def lights_of(pictures: Sequence[Luma], gains: Floats, median: Luma) -> list[Light]:
    """Measure the light of small pictures, given that their mean brightness is already alike.

    It varies over the pictures of a clip if that is worth its parameters, by the Bayesian
    information criterion. What it leaves open has Laplace's law, whose scale is the median: bodies
    have no say in it while they fill less than half of a picture. Where it leaves open what hangs
    together (a body, an edge too sharp for waves), few blocks say something of their own.
    Where it leaves open more than the smallest change of light, as where a camera pans, the
    pictures are not those of one scene in another light. ``gains`` is by how much brighter each
    was, shape (pictures,), ``median`` that of the pictures.
    """
    height, width = median.shape
    shape = _share(height, width), _share(width, height)
    before = _logarithms(median, shape)
    ratio = np.array([_logarithms(one, shape) - before for one in pictures])
    basis = [_cosines((np.arange(side) + 0.5) / side, _waves(side, shape)) for side in shape]
    waves = _fitted(ratio, basis)
    field = np.einsum("ai,nij,bj->nab", basis[0], waves, basis[1], optimize=True)
    even = np.median(ratio, axis=(1, 2), keepdims=True)
    scales = [np.median(np.abs(ratio - one), axis=(1, 2)) + ROUNDING for one in (even, field)]
    gain = float(np.log(scales[0] / scales[1]).mean())
    count = ratio[0].size / NEIGHBOURS
    varies = float(np.median(np.ptp(field, axis=(1, 2)))) / 2 > CHANGE_AT_LEAST
    still = float(np.median(scales[1])) < CHANGE_AT_LEAST
    if not (varies and still) or count * gain < waves[0].size / 2 * np.log(count):
        return [Light(gain) for gain in gains.tolist()]
    return [Light(gain, one) for gain, one in zip(gains.tolist(), waves, strict=True)]


def _share(side: int, other: int) -> int:
    """How many blocks one side of a picture has."""
    return max(2, round(BLOCKS * side / max(side, other)))


def _waves(side: int, shape: tuple[int, int]) -> int:
    return 1 + round(HALF_WAVES * side / max(shape))


def _cosines(place: Floats, count: int) -> Floats:
    """So many half waves, from none on, at places from 0 to 1, shape (places, count)."""
    return np.asarray(np.cos(np.pi * place.clip(0, 1)[:, None] * np.arange(count)))


def _logarithms(picture: Luma, shape: tuple[int, int]) -> Floats:
    """Logarithm of the mean of each block, of this shape."""
    means = cv2.resize(picture.astype(np.float32), shape[::-1], interpolation=cv2.INTER_AREA)
    return np.asarray(np.log(means + DARK_LEVELS), np.float64)


def _fitted(ratio: Floats, basis: Sequence[Floats]) -> Floats:
    """Fit waves to logarithms of n pictures over their median, shape (n, rows, columns) of blocks.

    Returns amplitudes, shape (n, waves down, waves across).
    """
    count = len(ratio)
    waves = np.einsum("ai,bj->abij", *basis)
    flat, values = waves.reshape(ratio[0].size, -1), ratio.reshape(count, -1)
    found = np.zeros((count, flat.shape[1]))
    found[:, 0] = np.median(values, axis=1)
    for _ in range(FITS):
        noise = MEDIAN_TO_SIGMA * np.median(np.abs(values - found @ flat.T), axis=1)
        noise = np.maximum(noise, NOISE_AT_LEAST)
        found = _m_estimates(flat, values, TUKEY * noise, found)
    return found.reshape(count, *waves.shape[2:])


def _m_estimates(design: Floats, values: Floats, limit: Floats, start: Floats) -> Floats:
    """Fit many sets of values by one design, shape (sets, parameters); limits are the sets'."""
    moments = design.T @ design
    ridge = RIDGE * np.trace(moments) / len(moments) * np.eye(len(moments))
    solve = np.linalg.solve(moments + ridge, design.T)
    found = start
    for _ in range(STEPS):
        left = values - found @ design.T
        share = np.minimum((left / limit[:, None]) ** 2, 1.0)
        step = (left * (1 - share) ** 2) @ solve.T
        found = found + step
        if np.abs(step).max() < STEP_AT_LEAST:
            break
    return found

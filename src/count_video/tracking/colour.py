"""Colour: where bodies show better by it than by brightness, pictures are a mixture of both.

A ball as bright as the wall behind it may have another colour, and colour has no shadows and little
noise. What is followed is one value a pixel, so a mixture takes the place of the luma Y:

    P = Y + c . (C - C0),     |c| = 1,

with the chroma C = (U, V) and its mean C0 over the clip. A mixture shows the more, the more pixels
differ from the background in it, and the more clearly: the sum of log(d / sqrt((k s)^2 + t^2)),
where that is positive, with the difference d, its noise s, and the number k of standard deviations
from which on a pixel is seen to differ. The texture t is the standard deviation of the background
about its surroundings: among grey stones a grey body is lost that differs from each by less. Only
pixels count that colour shows: grey bodies differ alike in all.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from count_video.records import Chroma, Floats, Luma
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.light import Light, gains_of
from count_video.tracking.regions import AREA_SHARE, NOISE_SIGMAS
from count_video.tracking.samples import Thumbnails, stored
from count_video.video.store import PictureStore

MIDDLE = 128
"""The level of U and V where there is no colour."""
GREY_LEVELS = 3
"""Pictures are grey in which U and V vary by less: conversions round."""
MEMORY_BYTES = 24_000_000
"""Colour up to so many bytes stays in memory: it is half as much as the brightness."""
PICTURES, THUMBNAIL_BYTES = 60, 12_000_000
"""Mixtures are compared in so many pictures, of those that are kept reduced, in so many bytes."""
DIRECTIONS = np.arange(16) * np.pi / 8
"""Colours that are added, as angles in the plane of U and V."""
LEVELS_SIGMA = 0.5
"""Rounding to whole levels, by the encoder and by us, is noise of about this standard deviation."""
SURROUNDINGS_PX = 15
"""Texture is what varies within so many px of these pictures: a change of the light is wider."""
WORTH = 2.0
"""A mixture has to show so many times as much as brightness: colour is stored at half size, and
encoders smear it."""


class Mixture(NamedTuple):
    """How pictures are mixed."""

    chroma: tuple[float, float]
    """Parts of U and V."""
    mean: tuple[float, float]
    """Of U and V in the clip."""

    def of(self, luma: Luma, chroma: Luma) -> Luma:
        """Mix a picture, shape (height, width), with U above V at half size."""
        half = len(chroma) // 2
        (by_u, by_v), (u, v) = self.chroma, self.mean
        level = -by_u * u - by_v * v
        colour = cv2.addWeighted(chroma[:half], by_u, chroma[half:], by_v, level, None, cv2.CV_32F)
        colour = cv2.resize(colour, luma.shape[::-1], interpolation=cv2.INTER_LINEAR)
        mixed = cv2.addWeighted(luma, 1.0, colour, 1.0, 0.0, None, cv2.CV_8U)
        return np.asarray(mixed, np.uint8)


class Colours:
    """The colour of a clip's pictures; nothing is kept of grey ones before the first coloured."""

    def __init__(self) -> None:
        self._pictures = PictureStore(MEMORY_BYTES)
        self._thumbnails = Thumbnails(THUMBNAIL_BYTES)
        self._grey = 0

    def close(self) -> None:
        """Forget all, and release what is on disk."""
        self._pictures.close()

    def add(self, chroma: Chroma | None) -> None:
        """Take the colour of the next picture, shape (2, rows, columns), if it has any."""
        if len(self._pictures) == 0:
            if chroma is None or int(np.ptp(chroma)) < GREY_LEVELS:
                self._grey += 1
                return
            nothing = np.full_like(chroma.reshape(-1, chroma.shape[2]), MIDDLE)
            for _ in range(self._grey):
                self._keep(nothing)
        if chroma is None:
            self._keep(np.full_like(self._pictures[0], MIDDLE))
        else:
            self._keep(chroma.reshape(-1, chroma.shape[2]))

    def _keep(self, picture: Luma) -> None:
        self._thumbnails.add(len(self._pictures), self._pictures.append(picture))

    def of_shot(self, shot: range) -> Colours:
        """Keep the pictures of a shot alone."""
        kept = Colours()
        try:
            for row in shot if len(self._pictures) else ():
                kept._keep(self._pictures[row])
        except BaseException:
            kept.close()
            raise
        self.close()
        return kept

    def mixture(self, brightness: Thumbnails) -> Mixture | None:
        """Choose the mixture that shows most; None where brightness does as well, or nearly."""
        rows = sorted(brightness.pictures.keys() & self._thumbnails.pictures.keys())
        if len(rows) < 2:
            return None
        some = [rows[k] for k in np.unique(np.linspace(0, len(rows) - 1, PICTURES).astype(int))]
        first = brightness.pictures[some[0]]
        size = max(1, first.shape[1] // 2), max(1, first.shape[0] // 2)
        luma = [_reduced_to(brightness.pictures[row], size) for row in some]
        gains = gains_of(luma).tolist()
        luma = [Light(gain).levelled(one) for one, gain in zip(luma, gains, strict=True)]
        both = [np.array_split(self._thumbnails.pictures[row], 2) for row in some]
        u, v = ([_reduced_to(one[k], size) for one in both] for k in (0, 1))
        return _best([np.array(luma), np.array(u), np.array(v)])

    def mixed(self, pictures: PictureStore, mixture: Mixture) -> tuple[PictureStore, Thumbnails]:
        """Mix all pictures; what was kept of brightness is forgotten."""
        mixed = stored(map(mixture.of, pictures, self._pictures))
        pictures.close()
        return mixed


def _reduced_to(picture: Luma, size: tuple[int, int]) -> Luma:
    """Reduce a picture to a width and a height."""
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def _best(channels: list[Luma]) -> Mixture | None:
    """Choose the best mixture of brightness, U and V, each of shape (pictures, rows, columns)."""
    behind = [np.median(one, axis=0).astype(np.float32) for one in channels]
    away = [one - still for one, still in zip(channels, behind, strict=True)]
    noise = MEDIAN_TO_SIGMA * np.array([np.median(np.abs(one)) for one in away])
    least = NOISE_SIGMAS * np.hypot(noise, LEVELS_SIGMA)
    coloured = (np.abs(away[1]) > least[1]) | (np.abs(away[2]) > least[2])
    if coloured.mean() < AREA_SHARE[0]:
        return None
    moving = np.array([one[coloured] for one in away])
    around = (SURROUNDINGS_PX, SURROUNDINGS_PX)
    texture = np.array([one - cv2.blur(one, around) for one in behind])

    def shown(parts: Floats) -> float:
        sigma = np.sqrt(np.sum((parts * noise) ** 2) + LEVELS_SIGMA**2)
        rough = MEDIAN_TO_SIGMA * np.median(np.abs(np.tensordot(parts, texture, 1)))
        ratio = np.abs(parts @ moving) / np.hypot(NOISE_SIGMAS * sigma, rough)
        return float(np.log(np.maximum(ratio, 1.0)).sum())

    plain = shown(np.array([1.0, 0.0, 0.0]))
    tried = [np.array([1.0, np.cos(angle), np.sin(angle)]) for angle in DIRECTIONS]
    worth = [shown(parts) for parts in tried]
    best = int(np.argmax(worth))
    if worth[best] <= WORTH * plain:
        return None
    _, by_u, by_v = tried[best].tolist()
    return Mixture((by_u, by_v), (float(channels[1].mean()), float(channels[2].mean())))

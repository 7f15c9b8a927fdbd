"""The camera's own motion: the background is registered in every picture, as bodies are.

Of the background those blocks take part that have the clearest slopes and hardly change from
picture to picture but for these. How well they show where a picture lies is what two halves of them
say of the same pictures: along straight edges only the noise of codecs has slopes, and both halves
find any place in it.

Where the camera stands still what is measured is noise, and nothing is corrected by it: the tracks
stay as they are. Where it moves, by more than that noise and by more than a small part of a pixel,
the shift is taken from every position, and its uncertainty is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from count_video.records import Floats, Indices, Mask, Pixels
from count_video.signals import interpolated
from count_video.tracking.background import ROUNDING, Background
from count_video.tracking.paths import only
from count_video.tracking.registration import register_all
from count_video.tracking.sequences import Lumas, chosen
from count_video.tracking.shape import Box
from count_video.tracking.template import Template, make_template, piece_at
from count_video.video.pictures import reduced

BLOCK_PX, BLOCKS, BLOCKS_AT_LEAST = 8, 64, 6
"""Square blocks of this side: so many with the clearest slopes by x, and by y."""
BODIES = 2
MEASURED_OF = 16
"""What is scenery, and how well it is found again, is measured in so many pictures."""
TREMBLE_PX, CHANGED_SHARE = 4.0, 0.8
"""The camera is expected to tremble by so much about its rough path. By the slope of its edges
times that a block of scenery changes at most in this share of the pictures. The changes by a body
that comes and goes are larger, as it fills a block."""
AROUND_PX = (0.0, 0.0), (3.0, 0.0), (-3.0, 0.0), (0.0, 3.0), (0.0, -3.0)
"""Scenery that a tremble moves further than the steps lead is sought so far around."""
AGREEMENT_AT_LEAST, SEEN_AT_LEAST = 0.5, 0.5
"""A picture that agrees less shows something else; at least this share of all shows the scenery."""
SIGMA_AT_MOST_PX = 0.15
"""A rigid scene is found to some hundredths of a pixel, to a tenth where it is faint. Halves of
what is none, or shows one direction only, lie half a pixel apart and more."""
NORMAL_QUANTILE = 1.2816
"""Of the distance from the mean in standard deviations, for ``CHANGED_SHARE``."""
MOVED_AT_LEAST_PX, MOVED_SIGMAS = 0.35, 8.0
"""Compression moves still scenery by up to 0.2 px. A place less sure than the least motion is none.
"""


@dataclass(frozen=True)
class Scenery:
    """What of the background shows where a picture lies."""

    template: Template
    sigma_px: Floats
    """Of a place by x and by y, shape (2,); infinite where it shows none."""


@dataclass(frozen=True)
class Motion:
    """How the picture moved, one row a frame; NaN where it could not be measured."""

    shift_px: Floats
    """By x and y, shape (n, 2)."""
    sigma_px: Floats
    """Standard uncertainties, shape (n, 2)."""

    @property
    def everywhere_px(self) -> Floats:
        """Shift with what could not be measured interpolated, shape (n, 2)."""
        return np.stack([interpolated(shift) for shift in self.shift_px.T], axis=1)

    def smoothed_px(self, width: int) -> Floats:
        """Take the mean of the shift over so many pictures, shape (n, 2)."""
        mean = cv2.blur(self.everywhere_px, (1, width), borderType=cv2.BORDER_REFLECT)
        return np.asarray(mean, np.float64)


def scenery(pictures: Lumas, background: Background, swept: Sequence[Box]) -> Scenery | None:
    """Blocks of the background that show where a picture lies; None if nothing does.

    ``pictures`` are the samples, ``swept`` boxes that what may be bodies passes over, the likeliest
    first.
    """
    luma, guesses = background.luma, background.shift_px
    some = np.unique(np.linspace(0, len(guesses) - 1, MEASURED_OF).astype(int))
    stands = (background.as_it_stands(pictures[k], k) for k in some.tolist())
    changes = [_of_blocks(cv2.absdiff(one, luma)) for one in stands]
    change = np.quantile(changes, CHANGED_SHARE, axis=0)
    whole = np.ascontiguousarray(piece_at(luma, 0.0, 0.0, (luma.shape[0], luma.shape[1])))
    # Threads swing above the bodies; what trembles with the scenery is among what may be a body;
    # and where bodies pass over everything, they hide it in some pictures only.
    threads = [(box[0], 0.0, box[2], box[3]) for box in swept]
    for free_of in (threads, swept, swept[:BODIES], ()):
        clear = _clear_blocks(background, change, free_of)
        if len(clear) < BLOCKS_AT_LEAST:
            continue
        halves = (_made(whole, part, change.shape) for part in (clear[::2], clear[1::2]))
        found = [_places(half, chosen(pictures, some), guesses[some])[0] for half in halves]
        apart = np.subtract(*found)
        if np.isnan(apart).any(axis=1).mean() > 0.5:
            continue
        # A median of pictures that moved holds one part as some of them show it and another part as
        # others do: all places by a part are off by the same. The mean of two errors is half their
        # difference.
        strays = np.abs(apart - np.nanmedian(apart, axis=0))
        sigma = np.nanquantile(strays, CHANGED_SHARE, axis=0) / 2 / NORMAL_QUANTILE
        shown = sigma < SIGMA_AT_MOST_PX
        if shown.any():
            return Scenery(_made(whole, clear, change.shape), np.where(shown, sigma, np.inf))
    return None


def camera_motion(parts: Scenery | None, pictures: Lumas, roughly_px: Floats) -> Motion | None:
    """Measure how the camera moved; None where it stood still or nothing shows it.

    ``pictures`` are in order of time, n of them, and ``roughly_px`` is how far it moved them, by x
    and y, right to some px, shape (n, 2).
    """
    if parts is None:
        return None
    place, unsure = _places(parts.template, pictures, roughly_px)
    if not np.isfinite(place).any():
        return None
    # By x and y apart: edges along one of them may be lost where those along the other are not.
    # Pictures that an encoder left as they were agree better than any can: they are no measure.
    usual = np.maximum(np.nanmedian(unsure, axis=0), parts.sigma_px)
    sigma = parts.sigma_px * np.maximum(unsure / usual, 1.0)
    place -= np.nanmedian(place, axis=0)
    place[~(sigma < MOVED_AT_LEAST_PX)] = np.nan
    known = np.isfinite(place)
    seen = known.mean(axis=0) >= SEEN_AT_LEAST
    moves = seen & _moves(place, parts.sigma_px)
    if not moves.any():
        return None
    # A direction in which it stands is often one in which the scenery shows little.
    sigma = np.where(known, sigma, np.nan)
    return Motion(np.where(moves, place, 0.0), np.where(moves, sigma, 0.0))


def _places(template: Template, pictures: Lumas, guesses_px: Floats) -> tuple[Floats, Floats]:
    """Find a template near to guesses: its places by x and y and their sigmas, shape (n, 2)."""
    place, sigma = (np.full(guesses_px.shape, np.nan) for _ in range(2))
    for around in AROUND_PX:
        left = np.flatnonzero(np.isnan(place[:, 0]))
        fits = register_all(pictures, template, only(guesses_px + around, left))
        good = fits.agreement > AGREEMENT_AT_LEAST
        place[good], sigma[good] = fits.places_px[good], fits.sigmas_px[good]
    return place, sigma


def _clear_blocks(background: Background, change: Floats, swept: Sequence[Box]) -> Indices:
    """Flat indices of the blocks with the clearest slopes by x or by y.

    They are taken of those that are scenery beside what is swept, and not what bodies leave behind
    in the background.
    """
    rows, columns = change.shape
    far = np.abs(background.shift_px).max(axis=0) + 1
    right, down = (1 + int(edge) // BLOCK_PX for edge in far)
    free = np.zeros((rows, columns), np.bool_)
    free[down : rows - down, right : columns - right] = True
    for box in swept:
        left, top, end, bottom = (max(0, int(edge)) // BLOCK_PX for edge in box)
        free[top : bottom + 1, left : end + 1] = False
    best = []
    for axis in (0, 1):
        steep = cv2.Sobel(background.luma, cv2.CV_32F, 1 - axis, axis, scale=1 / 8)
        slope = _of_blocks(np.abs(steep, out=steep))
        clear = np.flatnonzero(free & (slope > 0) & (change < TREMBLE_PX * slope + ROUNDING))
        best.append(clear[np.argsort(-slope.ravel()[clear], kind="stable")[:BLOCKS]])
    return np.unique(np.concatenate(best))


def _made(whole: Pixels, blocks: Indices, shape: tuple[int, ...]) -> Template:
    """Make a template of some blocks of the background."""
    marks = np.zeros(shape, np.float32)
    marks.flat[blocks] = 1.0
    weight = np.zeros(whole.shape, np.float32)
    grown = marks.repeat(BLOCK_PX, axis=0).repeat(BLOCK_PX, axis=1)
    weight[: grown.shape[0], : grown.shape[1]] = grown
    return make_template(whole, weight, across=1.0)


def _of_blocks(picture: cv2.typing.MatLike) -> Floats:
    """Mean of each block, shape (rows, columns)."""
    return np.asarray(reduced(np.asarray(picture, np.float32), BLOCK_PX), np.float64)


def _moves(place: Floats, sigma: Floats) -> Mask:
    """Whether the picture was ever displaced for two of three neighbouring frames, by x and y."""
    away = np.abs(place)
    lasting = np.median(np.stack([away[:-2], away[1:-1], away[2:]]), axis=0)
    return np.asarray(np.any(lasting > np.maximum(MOVED_AT_LEAST_PX, MOVED_SIGMAS * sigma), axis=0))

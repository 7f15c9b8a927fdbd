"""The camera's own motion: blocks of the background, found together in every picture.

All blocks are moved by one shift. It is found by Gauss and Newton's steps, in which blocks that lie
elsewhere than most have no weight (Tukey's biweight). Its covariance comes from what the blocks
leave over, each by itself (Liang and Zeger's sandwich), for encoders move blocks on their own.

Where the camera stands still what is measured is noise, and nothing is corrected by it: the tracks
stay as they are. Where it moves, by more than that noise and by more than a small part of a pixel,
the shift is taken from every position, and its uncertainty is added.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.signals import interpolated
from count_video.tracking.background import ROUNDING, Background
from count_video.tracking.shape import Box, Place
from count_video.tracking.template import REACH_PX, Pixels, smooth
from count_video.video.pictures import reduced

Luma = NDArray[np.uint8]
Places = NDArray[np.intp]

BLOCK_PX, BLOCKS, BLOCKS_AT_LEAST = 8, 64, 6
"""Square blocks of this side: so many with the clearest slopes by x, and by y."""
BODIES = 2
MEASURED_OF = 16
"""What is scenery, and how well it is found again, is measured in so many pictures."""
TREMBLE_PX, CHANGED_SHARE = 4.0, 0.8
"""The camera is expected to tremble by so much about its rough path. By the slope of its edges
times that a block of scenery changes at most in this share of the pictures. The changes by a body
that comes and goes are larger, as it fills a block."""
AROUND_PX = (3.0, 0.0), (-3.0, 0.0), (0.0, 3.0), (0.0, -3.0)
"""Blocks that a tremble moves further than the steps lead are sought so far around."""
STEPS, SETTLED_PX = 8, 0.005
TINY = 1e-9
STRAY_PX = 0.5
"""Blocks that show most of a picture's place lie no further from where it puts them."""
UNSURE_FACTOR, SEEN_AT_LEAST = 4.0, 0.5
"""A picture that is so many times as unsure as usual shows something else; this share does not."""
SIGMA_AT_MOST_PX = 0.15
"""A rigid scene is found to some hundredths of a pixel, to a tenth where it is faint. Halves of
what is none, or shows one direction only, lie half a pixel apart and more."""
NORMAL_QUANTILE = 1.2816
"""Of the distance from the mean in standard deviations, for ``CHANGED_SHARE``."""
MOVED_AT_LEAST_PX, MOVED_SIGMAS = 0.35, 8.0
"""Compression moves still scenery by up to 0.2 px."""


@dataclass(frozen=True)
class Scenery:
    """Blocks of the background that show where a picture lies, n of them."""

    places: Places
    """Image x and y of their top left pixels, freed of the camera's motion, shape (n, 2)."""
    appearance: Pixels
    """Smoothed, less the mean of each block, shape (n, pixels)."""
    slopes: Pixels
    """By x and y, shape (2, n, pixels)."""
    shown: NDArray[np.bool_]
    """Whether they show where a picture lies by x and y, shape (2,)."""

    def half(self, first: int) -> Scenery:
        """Every other block, from the first or second on."""
        every = slice(first, None, 2)
        return replace(
            self,
            places=self.places[every],
            appearance=self.appearance[every],
            slopes=self.slopes[:, every],
        )


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

    def turned(self) -> Motion:
        """Swap x and y."""
        return Motion(self.shift_px[:, ::-1], self.sigma_px[:, ::-1])


def scenery(
    pictures: Mapping[int, Luma], background: Background, swept: Sequence[Box]
) -> Scenery | None:
    """Blocks of the background that show where a picture lies; None if nothing does.

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
    changes = [
        _of_blocks(cv2.absdiff(background.as_it_stands(pictures[k], k), background.luma))
        for k in some
    ]
    change = np.quantile(changes, CHANGED_SHARE, axis=0)
    # Threads swing above the bodies; what trembles with the scenery is among what may be a body;
    # and where bodies pass over everything, they hide it in some pictures only.
    for free_of in ([_with_threads(box) for box in swept], swept, swept[:BODIES], ()):
        blocks = _made(background.luma, _clear_blocks(background, change, free_of))
        if len(blocks.places) < BLOCKS_AT_LEAST:
            continue
        starts = {k: np.array(background.shift_px[k]) for k in some}
        one, other = (
            [_fit(blocks.half(first), pictures[k], start)[0] for k, start in starts.items()]
            for first in (0, 1)
        )
        # Along straight edges only the noise of codecs has slopes, and both halves find any place
        # in it. The mean of two errors is half their difference.
        apart = np.quantile(np.abs(np.subtract(one, other)), CHANGED_SHARE, axis=0)
        shown = apart / 2 / NORMAL_QUANTILE < SIGMA_AT_MOST_PX
        if shown.any():
            return replace(blocks, shown=shown)
    return None


def _with_threads(box: Box) -> Box:
    """Extend a box that a body passes over by what its threads do, up to the picture's border."""
    return box[0], 0.0, box[2], box[3]


def camera_motion(
    blocks: Scenery | None,
    pictures: Mapping[int, Luma],
    frames: NDArray[np.intp],
    roughly: Mapping[int, Place],
) -> Motion | None:
    """Measure how the camera moved; None where it stood still or nothing shows it.

    Parameters
    ----------
    blocks
        Of the background.
    pictures
        Frame index -> luma, shape (height, width).
    frames
        Indices of those to measure it in, in order of time, shape (n,).
    roughly
        Frame index -> how far it moved some of them, by x and y, right to some px.
    """
    if blocks is None:
        return None
    known = sorted(roughly)
    guesses = np.stack(
        [np.interp(frames, known, [roughly[k][axis] for k in known]) for axis in (0, 1)], axis=1
    )
    place, sigma = (np.full((len(frames), 2), np.nan) for _ in range(2))
    away = np.zeros(2)
    for row, frame in enumerate(frames.tolist()):
        for step in ((0.0, 0.0), away, *AROUND_PX):
            found, unsure, share = _fit(blocks, pictures[frame], guesses[row] + step)
            if share > 0.5:
                place[row], sigma[row] = found, unsure
                away = found - guesses[row]
                break
    if not np.isfinite(place).any():
        return None
    # By x and y apart: edges along one of them may be lost where those along the other are not.
    place[sigma > UNSURE_FACTOR * np.nanmedian(sigma, axis=0)] = np.nan
    place -= np.nanmedian(place, axis=0)
    known = np.isfinite(place)
    # Few blocks show one picture's scatter badly: all pictures together show it.
    usual = np.sqrt(np.square(sigma).sum(axis=0, where=known) / known.sum(axis=0))
    seen = blocks.shown & (known.mean(axis=0) >= SEEN_AT_LEAST)
    moves = seen & _moves(place, usual)
    if not moves.any():
        return None
    # A direction in which it stands is often one in which the scenery shows little.
    sigma = np.where(known, usual, np.nan)
    return Motion(np.where(moves, place, 0.0), np.where(moves, sigma, 0.0))


def _clear_blocks(background: Background, change: Floats, swept: Sequence[Box]) -> Places:
    """Image x and y of the blocks with the clearest slopes by x or by y, shape (n, 2).

    They are taken of those that are scenery beside what is swept, and not what bodies leave behind
    in the background.
    """
    luma = background.luma
    rows, columns = change.shape
    far = np.abs(np.array(list(background.shift_px.values()))).max(axis=0) + 1
    right, down = (1 + int(edge) // BLOCK_PX for edge in far)
    free = np.zeros((rows, columns), np.bool_)
    free[down : rows - down, right : columns - right] = True
    for box in swept:
        left, top, end, bottom = (max(0, int(edge)) // BLOCK_PX for edge in box)
        free[top : bottom + 1, left : end + 1] = False
    best = []
    for axis in (0, 1):
        slope = _of_blocks(np.abs(cv2.Sobel(luma, cv2.CV_32F, 1 - axis, axis, scale=1 / 8)))
        clear = np.flatnonzero(free & (slope > 0) & (change < TREMBLE_PX * slope + ROUNDING))
        best.append(clear[np.argsort(-slope.ravel()[clear], kind="stable")[:BLOCKS]])
    y, x = np.divmod(np.unique(np.concatenate(best)), columns)
    return BLOCK_PX * np.stack([x, y], axis=1)


def _of_blocks(picture: cv2.typing.MatLike) -> Floats:
    """Mean of each block, shape (rows, columns)."""
    return np.asarray(reduced(picture.astype(np.float32), BLOCK_PX), np.float64)


def _made(luma: Luma, places: Places) -> Scenery:
    """Make scenery of the blocks at these places."""
    appearance, slopes = _blocks_at(luma, places)
    return Scenery(places, appearance, slopes, np.ones(2, np.bool_))


def _blocks_at(picture: Luma, places: Floats | Places) -> tuple[Pixels, Pixels]:
    """Smoothed blocks at places that have one fraction of a pixel, less their means, and slopes.

    Returns shapes (n, pixels) and (2, n, pixels). Beyond the picture's border its last row or
    column goes on.
    """
    if len(places) == 0:
        return np.empty((0, BLOCK_PX**2), np.float32), np.empty((2, 0, BLOCK_PX**2), np.float32)
    corners = np.rint(places).astype(np.intp)
    around = np.arange(-REACH_PX, BLOCK_PX + REACH_PX)
    x, y = (
        (corners[:, axis, None] + around).clip(0, picture.shape[1 - axis] - 1) for axis in (0, 1)
    )
    whole = picture[y[:, :, None], x[:, None, :]]
    fraction_x, fraction_y = (places[0] - corners[0]).tolist()
    pieces = smooth(whole.reshape(-1, len(around)), fraction_x, fraction_y).reshape(whole.shape)
    shape, inner = (len(places), BLOCK_PX**2), slice(REACH_PX, -REACH_PX)
    after, before = slice(REACH_PX + 1, 1 - REACH_PX), slice(REACH_PX - 1, -REACH_PX - 1)
    along = (pieces[:, inner, after] - pieces[:, inner, before]).reshape(shape) / 2
    across = (pieces[:, after, inner] - pieces[:, before, inner]).reshape(shape) / 2
    blocks = pieces[:, inner, inner].reshape(shape)
    return blocks - blocks.mean(axis=1, keepdims=True), np.stack([along, across])


def _fit(blocks: Scenery, picture: Luma, start: Floats) -> tuple[Floats, Floats, float]:
    """Shift of a picture by x and y, its standard uncertainty, and the share that agrees in it.

    The share is that of the blocks, each as much as it shows. The shift is expected about the start
    as far as a camera trembles: along a straight edge nothing else shows it.
    """
    place, weight = np.array(start, np.float64), np.ones(len(blocks.places))
    shows = np.square(blocks.slopes).sum(axis=(0, 2), dtype=np.float64)
    for _ in range(STEPS):
        seen, slopes = _blocks_at(picture, blocks.places + place)
        gain = float(weight @ (seen * blocks.appearance).sum(axis=1))
        gain /= float(weight @ np.square(blocks.appearance).sum(axis=1)) + TINY
        if gain <= 0:
            return place, np.full(2, np.inf), 0.0
        left = blocks.appearance - seen / gain
        score = np.einsum("inp,np->in", blocks.slopes, left, dtype=np.float64)
        # By the slopes of both: noise in those of one alone would make it too large.
        response = np.einsum("inp,jnp->ijn", blocks.slopes, slopes / gain, dtype=np.float64)
        expected = float(weight @ np.square(left).mean(axis=1)) / weight.sum() / TREMBLE_PX**2
        prior = (expected + TINY) * np.eye(2)
        inverse = np.linalg.inv(response @ weight + prior)
        step = inverse @ (score @ weight - prior @ (place - start))
        place += step
        over = score - np.einsum("ijn,j->in", response, step)
        stray = np.hypot(*over) / shows
        weight = (1 - np.square(stray / STRAY_PX).clip(0, 1)) ** 2
        if np.hypot(*step) < SETTLED_PX:
            break
    # As if each block had no say in the fit: one that shows much draws it to itself.
    alone = over * weight / (1 - shows * weight / (shows @ weight + TINY)).clip(TINY)
    scatter = alone @ alone.T + prior
    sigma = np.sqrt(np.diag(inverse @ scatter @ inverse.T))
    return place, sigma, float(shows[stray < STRAY_PX].sum() / shows.sum())


def _moves(place: Floats, sigma: Floats) -> NDArray[np.bool_]:
    """Whether the picture was ever displaced for two of three neighbouring frames, by x and y."""
    away = np.abs(place)
    lasting = np.median(np.stack([away[:-2], away[1:-1], away[2:]]), axis=0)
    return np.asarray(np.any(lasting > np.maximum(MOVED_AT_LEAST_PX, MOVED_SIGMAS * sigma), axis=0))

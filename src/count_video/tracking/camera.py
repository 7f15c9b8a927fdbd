"""The camera's own motion: some windows of the background, followed as bodies are.

Where the camera stands still what is measured is noise, and nothing is corrected by it: the tracks
stay as they are. Where it moves, by more than that noise and by more than a small part of a pixel,
the shift is taken from every position, and its uncertainty is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.signals import MEDIAN_TO_SIGMA
from count_video.tracking.background import Background
from count_video.tracking.following import Surroundings, follow, was_followed
from count_video.tracking.learning import Body
from count_video.tracking.registration import register
from count_video.tracking.shape import Box
from count_video.tracking.template import make_template, piece_at

Luma = NDArray[np.uint8]

WINDOWS, WINDOWS_AT_LEAST, WINDOW_PX = 5, 2, 24
"""So many windows of this side are followed, if there are so many: those with clear slopes in
all directions."""
CLEAR_SHARE = 0.1
"""A window's slopes in the direction that shows least are at least this share of the clearest."""
KNOWN_PX = 0.1
"""By its noise a window shows the shift of one picture as well as this."""
MEASURED_OF = 16
"""How well a window is found again is measured in so many pictures."""
ALIKE_SIGMAS, ALIKE_PX = 3.0, 0.02
"""Windows scatter about their joint path by at most so many times as much as the steadiest one, or
as this: what scatters more moves by itself."""
STRAY_PX = 0.5
"""A window that strays so far from the others in one picture was taken for another one like it."""
SCATTER_AT_MOST_PX = 0.15
"""Windows of one rigid scene scatter by some hundredths of a pixel, by a tenth where they are faint
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


def camera_motion(
    pictures: Sequence[Luma],
    frames: NDArray[np.intp],
    background: Background,
    swept: Sequence[Box],
) -> Motion | None:
    """Measure how the camera moved; None where it stood still or nothing shows it.

    Parameters
    ----------
    pictures
        Lumas in order of time, n of them, each of shape (height, width).
    frames
        Frame index of each, shape (n,).
    background
        What stands still, and how far the camera has roughly moved some of the pictures.
    swept
        Boxes that bodies pass over.
    """
    windows: list[Body] = []
    for free_of in (swept, ()):  # where bodies pass over everything, they hide it in some pictures
        if len(windows) < WINDOWS_AT_LEAST:
            places = _clear_places(background, free_of)
            found = (_window(pictures, frames, background, place) for place in places)
            windows = [one for one in found if one is not None]
    around = Surroundings(np.zeros_like(background.luma), np.zeros((len(frames), 2)))
    seen = [follow(pictures, frames, one, around) for one in windows]
    seen = [one for one in seen if was_followed(one.x_px)]
    if len(seen) < WINDOWS_AT_LEAST:
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


def _clear_places(background: Background, swept: Sequence[Box]) -> list[tuple[int, int]]:
    """Columns and rows of windows with clear slopes, the clearest first, beside what is swept."""
    luma = background.luma
    side = min(WINDOW_PX, min(luma.shape) // 3)
    # The smaller eigenvalue of the slopes' products, summed over the window (Shi and Tomasi 1994).
    clear = cv2.cornerMinEigenVal(np.ascontiguousarray(luma), side)
    far = np.abs(np.array(list(background.shift_px.values()))).max(axis=0) + side / 2 + 1
    right, down = (int(np.ceil(one)) for one in far)
    score = np.zeros_like(clear)
    score[down:-down, right:-right] = clear[down:-down, right:-right]
    for box in swept:
        left, top, end, bottom = (max(0, round(edge)) for edge in box)
        half = side // 2
        score[max(0, top - half) : bottom + half, max(0, left - half) : end + half] = 0
    places: list[tuple[int, int]] = []
    least = CLEAR_SHARE**2 * float(score.max())
    while len(places) < WINDOWS and score.max() > least:
        y, x = np.unravel_index(int(np.argmax(score)), score.shape)
        places.append((int(x) - side // 2, int(y) - side // 2))
        score[max(0, y - side) : y + side, max(0, x - side) : x + side] = 0
    return places


def _window(
    pictures: Sequence[Luma],
    frames: NDArray[np.intp],
    background: Background,
    place: tuple[int, int],
) -> Body | None:
    """Take a window of the background for a body; None if pictures hardly show its place."""
    side = min(WINDOW_PX, min(background.luma.shape) // 3)
    appearance = piece_at(background.luma, *place, (side, side))
    template = make_template(appearance, np.ones_like(appearance))
    roughly = {k: (place[0] + x, place[1] + y) for k, (x, y) in background.shift_px.items()}
    known = sorted(roughly)
    some = [known[k] for k in np.linspace(0, len(known) - 1, MEASURED_OF).astype(int)]
    rows = np.searchsorted(frames, some)
    fits = [
        register(pictures[row], template, roughly[k]) for row, k in zip(rows, some, strict=True)
    ]
    sigma = [np.inf if fit is None else fit.sigma_x_px for fit in fits]
    if not np.median(sigma) < KNOWN_PX:
        return None
    typical = float(np.median([fit.agreement for fit in fits if fit is not None]))
    return Body(template, 0.0, float(side), False, roughly, tuple(some), typical)


def _joint(paths: Floats, noise_px: float) -> tuple[Floats, Floats]:
    """Joint path of windows by one axis, and its standard uncertainty; shape (n,) each.

    ``paths`` has shape (windows, n). The uncertainty comes from their scatter about the joint path;
    by the noise alone it would be too small, for encoders move each window by itself. Windows that
    share no path show no motion.
    """
    known = np.isfinite(paths).any(axis=0)
    moved = paths[:, known]
    for _ in range(2):  # the offset of each window from the others, at last
        away = moved - np.nanmedian(moved, axis=0)
        moved = moved - np.nanmedian(away, axis=1, keepdims=True)
    away = np.abs(moved - np.nanmedian(moved, axis=0))
    scatter = MEDIAN_TO_SIGMA * np.nanmedian(away, axis=1)
    steady = scatter <= ALIKE_SIGMAS * max(float(scatter.min()), ALIKE_PX)
    kept = steady[:, None] & (away < STRAY_PX)
    count = kept.sum(axis=0)
    total = np.where(kept, moved, 0.0).sum(axis=0)
    shown = count >= WINDOWS_AT_LEAST
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

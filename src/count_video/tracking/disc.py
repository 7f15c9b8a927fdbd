"""Where in a picture is a ball whose surface changes? Its outline, laid by what it hides.

A ball of two colours that spins shows another surface in every picture, and no template fits it.
What stays is its outline: a circle of one radius, inside which the picture differs from the
background, and outside of which it does not. Along each radius the edge is where the difference
falls to half of what it is a little further inside, be the ball brighter or darker there.

The circle is laid by whole px first, where most radii show an edge, and then by least squares on
where their edges are. Edges of the surface lie inside of the outline, and what hides the ball or
touches it lies outside: such radii are outliers (Tukey's biweight).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Indices, Luma, Pixels
from count_video.signals import QUARTILE
from count_video.tracking.regions import NOISE_LEVELS, NOISE_SIGMAS
from count_video.tracking.registration import Fits
from count_video.tracking.sequences import Lumas, moved_back
from count_video.tracking.shape import Box, share_within
from count_video.tracking.template import piece_at

DIFFERS, THINNED = np.uint8(100), 4
"""Level of pixels that differ, where a picture is searched; the noise is measured in every fourth
pixel of every fourth row."""
MARGIN_PX = 2
"""The box around a circle begins so far outside of it."""
RAY_PX, STEP_PX = 2.5, 0.5
"""Rays lie so far apart on the circle that smoothing gives neighbours little noise in common, and
are sampled in such steps."""
REACH_PX, REACH_SHARE = 6.0, 0.4
"""A guess may be wrong by so much, and by this share of the radius."""
INSIDE_PX, BLUR_PX = 4.0, 1.5
"""A ray shows an edge by the difference up to so far inside of it; so far to both sides of it the
edge is blurred."""
CUTS_PX = 2.0, 1.2, 0.9, 0.9
"""Radii whose edges lie further from the circle than this are left out, round by round; of several
edges on a radius that are nearer, the outermost is the outline's."""
RAYS_AT_LEAST, ROUND_AT_LEAST = 8, 0.02
"""So many rays must show the outline, and in directions that leave no shift open: the smaller
eigenvalue of the mean of their squares is so much at least."""
HARMONICS = 2, 3, 4, 5
"""What the surface does to the edges varies slowly around the circle: the shift has about as much
of it as the next harmonics have."""
SURFACE_PX = 0.25
"""Standard uncertainty that the surface leaves, where shading or a mark blurs the outline: so much
the places of seven spinning balls of rendered clips stray (root of the median square)."""


@dataclass(frozen=True)
class Disc:
    """A circle of unknown surface in a box; pixel (0, 0) is the top left corner of the box."""

    radius_px: float
    shift_variance: float = 0.0
    """Median variance of its places by x in px squared."""

    @property
    def middle_px(self) -> float:
        """Column and row of the centre."""
        return float(math.ceil(self.radius_px) + MARGIN_PX)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the box in px."""
        side = 2 * round(self.middle_px) + 1
        return side, side

    @property
    def appearance(self) -> Pixels:
        """What it looks like in a picture of what differs from the background."""
        y, x = np.indices(self.shape) - self.middle_px
        return np.where(np.hypot(x, y) < self.radius_px, np.float32(DIFFERS), np.float32(0))

    @property
    def weight(self) -> Pixels:
        """All of its box counts alike."""
        return np.ones(self.shape, np.float32)

    @property
    def box(self) -> Box:
        """Left, top, right and bottom end of the circle."""
        low, high = self.middle_px - self.radius_px, self.middle_px + self.radius_px
        return low, low, high, high


def register_discs(
    pictures: Lumas, behind: Luma, shift_px: Floats, disc: Disc, guesses_px: Floats
) -> Fits:
    """Place a disc in the pictures for which there is a guess.

    ``behind`` is the background, which the camera has moved in each of n pictures by ``shift_px``.
    ``guesses_px`` is image x and y of the box's top left pixel, right to some px, NaN where there
    is none; both have shape (n, 2). The agreement is the square root of the share of the outline
    that shows.
    """
    found = np.full((len(guesses_px), 6), np.nan)
    for number in np.flatnonzero(np.isfinite(guesses_px[:, 0])).tolist():
        seen = pictures[number], behind, shift_px[number]
        fit = _registered(*seen, disc, guesses_px[number])
        if fit is not None:
            found[number] = fit
    return Fits(found[:, :2], found[:, 2:4], *found[:, 4:].T)


def differing(picture: Luma, behind: Luma, shift_px: Floats) -> Luma:
    """Show what differs from the background, which the camera has moved so far, as discs look."""
    behind = moved_back(behind, -shift_px)
    few = (slice(None, None, THINNED), slice(None, None, THINNED))
    gain = float(np.median(picture[few] / np.maximum(behind[few], np.float32(1.0))))
    away = cv2.absdiff(np.ascontiguousarray(picture), cv2.convertScaleAbs(behind, alpha=gain))
    least = difference_at_least(away[few].astype(np.float32))
    differs = cv2.convertScaleAbs(away, alpha=float(DIFFERS) / least)
    return np.minimum(differs, DIFFERS)


def difference_at_least(away: Pixels) -> float:
    """Least difference from the background that is no noise, in grey levels.

    In a quarter of these differences at least there must be nothing else.
    """
    return max(NOISE_SIGMAS * float(np.quantile(away, 0.25)) / QUARTILE, NOISE_LEVELS)


@dataclass(frozen=True)
class _Rays:
    """Rays of a circle, m of them, sampled at k places each from inside to outside."""

    directions: Floats
    """Shape (m, 2)."""
    waves: NDArray[np.complex128]
    """Harmonics around the circle, shape (m, len(HARMONICS))."""
    half_px: int
    """Half the side of the box in which they lie."""
    maps: tuple[Pixels, Pixels]
    """Columns and rows of that box that are sampled, shape (m, k)."""
    on_circle: int
    """Which of the k places lies on the circle."""
    shifts_px: Floats
    """Shifts of the circle that are tried, by x and y, shape (s, 2)."""
    columns: Indices
    """Which place of each ray the circle meets then, shape (s, m)."""


@lru_cache
def _rays(radius_px: float) -> _Rays:
    reach = min(REACH_PX, REACH_SHARE * radius_px)
    angle = np.linspace(0, 2 * np.pi, round(2 * math.pi * radius_px / RAY_PX), endpoint=False)
    directions = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    on_circle = math.ceil((reach + INSIDE_PX) / STEP_PX)
    places = radius_px + STEP_PX * np.arange(-on_circle, on_circle + 1)
    half = math.ceil(places[-1]) + 1
    x, y = ((half + along[:, None] * places).astype(np.float32) for along in directions.T)
    whole = np.arange(-math.floor(reach), math.floor(reach) + 1)
    shifts = np.stack(np.meshgrid(whole, whole), axis=-1).reshape(-1, 2).astype(np.float64)
    shifts = shifts[np.hypot(*shifts.T) <= reach]
    columns = np.rint(shifts @ directions.T / STEP_PX).astype(np.intp) + on_circle
    waves = np.exp(1j * angle[:, None] * np.array(HARMONICS))
    return _Rays(directions, waves, half, (x, y), on_circle, shifts, columns)


def _registered(
    picture: Luma, behind: Luma, shift_px: Floats, disc: Disc, guess: Floats
) -> list[float] | None:
    """Place a disc in one picture: what ``Fits`` hold of it."""
    rays = _rays(disc.radius_px)
    inside = float(share_within(guess, disc.shape, picture.shape))
    if inside == 0:
        return None
    begin = guess + disc.middle_px - rays.half_px
    away = _differences(picture, behind, rays, (begin, shift_px))
    shown, at = _edges(away, rays.on_circle)
    scores = shown[np.arange(len(away)), rays.columns].mean(axis=1)
    found = _laid(shown, at, rays, rays.shifts_px[int(np.argmax(scores))])
    if found is None:
        return None
    shift, sigma = found
    ends = np.rint(rays.directions @ shift / STEP_PX).astype(np.intp) + rays.on_circle
    share = shown[np.arange(len(away)), ends.clip(0, away.shape[1] - 1)].mean()
    return [*(guess + shift).tolist(), *sigma.tolist(), math.sqrt(share), inside]


def _differences(picture: Luma, behind: Luma, rays: _Rays, place: tuple[Floats, Floats]) -> Pixels:
    """How much a picture differs from the background along rays, in grey levels, shape (m, k).

    ``place`` is the top left pixel of their box, and the camera's shift. The background is as
    bright as the picture at the outer ends of most rays.
    """
    begin, shift = place
    side = 2 * rays.half_px + 1
    pieces = (
        piece_at(one, float(corner[0]), float(corner[1]), (side, side))
        for one, corner in ((picture, begin), (behind, begin - shift))
    )
    seen, back = (cv2.remap(piece, *rays.maps, cv2.INTER_CUBIC) for piece in pieces)
    outer = slice(-round(INSIDE_PX / STEP_PX), None)
    gain = np.median(seen[:, outer] / np.maximum(back[:, outer], 1.0))
    return np.asarray(np.abs(seen - gain * back), np.float32)


def _edges(away: Pixels, on_circle: int) -> tuple[Pixels, Floats]:
    """Where each ray may meet the outline; both arrays have shape (m, k).

    Returns how clearly it would show at each place, 0 to 1, and how far outside of the circle the
    difference falls to half of the largest one inside of it, between there and the next place, in
    px; infinite where it does not.
    """
    inner, blur = round(INSIDE_PX / STEP_PX), round(BLUR_PX / STEP_PX)
    outer = away[:, -inner:]
    # The largest difference from so far inside of each place up to it, and beyond its blur.
    most = cv2.dilate(away, np.ones((1, inner + 1), np.uint8), anchor=(inner, 0))
    padded = np.pad(away, [(0, 0), (blur, inner)], mode="edge")
    beyond = cv2.dilate(padded, np.ones((1, inner - blur + 1), np.uint8), anchor=(0, 0))
    falls = padded[:, : away.shape[1]] - beyond[:, 2 * blur : 2 * blur + away.shape[1]]
    clear = most > difference_at_least(outer)
    shown = np.where(clear, np.clip(falls / np.maximum(most, NOISE_LEVELS), 0, 1), 0)
    after = np.concatenate([away[:, 1:], away[:, -1:]], axis=1)
    half = most / 2
    part = (away - half) / np.maximum(away - after, 1e-3)
    at = STEP_PX * (np.arange(away.shape[1]) + part - on_circle)
    return shown.astype(np.float32), np.where((away >= half) & (after < half) & clear, at, np.inf)


def _laid(shown: Pixels, at: Floats, rays: _Rays, shift: Floats) -> tuple[Floats, Floats] | None:
    """Lay the circle by least squares; its shift and its standard uncertainty, by x and y."""
    ray = np.arange(len(rays.directions))
    weight, left_over, inverse = np.zeros(len(ray)), np.zeros(len(ray)), np.eye(2)
    for cut in CUTS_PX:
        expected = rays.directions @ shift
        near = np.abs(at - expected[:, None]) < cut
        nearest = at.shape[1] - 1 - np.argmax(near[:, ::-1], axis=1)
        left_over = at[ray, nearest] - expected
        seen = near.any(axis=1)
        if np.count_nonzero(seen) < RAYS_AT_LEAST:
            return None
        left_over = np.where(seen, left_over, 0.0)
        weight = seen * np.square(1 - (left_over / cut) ** 2) * shown[ray, nearest]
        normal = (rays.directions * weight[:, None]).T @ rays.directions
        if np.linalg.eigvalsh(normal)[0] < ROUND_AT_LEAST * len(ray):
            return None
        inverse = np.linalg.inv(normal)
        shift = shift + inverse @ (rays.directions.T @ (weight * left_over))
    white = float(weight @ left_over**2) / max(1, int(np.count_nonzero(weight)) - 2)
    waves = 2 * (weight * left_over) @ rays.waves / weight.sum()
    variance = white * np.diag(inverse) + np.mean(np.abs(waves) ** 2) / 2 + SURFACE_PX**2
    return shift, np.sqrt(variance)

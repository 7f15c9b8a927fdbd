"""Find a template in a picture when nothing is known of its place, or only roughly.

Normalised cross-correlation of the template with the picture, at reduced size: a place right to a
few pixels is all that the registration needs. Pixels count by their weight in the template, for the
corners of its box show what lies behind the body, which is another thing at every place. At so low
a resolution a plain body is confused with what is like it in the scenery: the best few places
are to be registered.
"""

from __future__ import annotations

import cv2
import numpy as np

from count_video.records import Luma, Pixels, Point
from count_video.signals import peak_of
from count_video.tracking.disc import Disc
from count_video.tracking.template import Template, cut

COARSE_HEIGHT_PX = 28
"""The template is reduced until it is about this high."""
FOUND_AT_LEAST = 0.45
"""Correlation below which nothing is said to be found."""
PLACES = 4
"""So many places are registered."""
APART_SHARE = 0.25
"""Places lie this share of the template's width and height apart at least."""
BEYOND_SHARE = 0.65
"""Bodies that come in or go out are searched for while they stick out of the picture so far."""
ROUNDING = 0.01
"""Correlations are sums of single precision: by so little they may exceed 1."""


def likely_places(
    picture: Luma, pattern: Template | Disc, near: Point, reach_px: Point
) -> list[Point]:
    """Places of the pattern's top left pixel, right to a few px, the likeliest first.

    It is sought so far, along x and along y, from where it once was. For a disc the picture shows
    what differs from the background.
    """
    height, width = pattern.appearance.shape
    left, right = _span(near[0], width, reach_px[0], picture.shape[1])
    top, bottom = _span(near[1], height, reach_px[1], picture.shape[0])
    if right - left < width or bottom - top < height:
        return []
    scale = max(1.0, min(height, width) / COARSE_HEIGHT_PX)
    scene = cut(picture, left, top, (bottom - top, right - left))
    small = _reduce(scene, scale)
    step_y, step_x = (full / few for full, few in zip(scene.shape, small.shape, strict=True))
    scores = _scores(small, pattern, scale)
    size = round(height / scale), round(width / scale)
    return [(left + x * step_x, top + y * step_y) for x, y in _peaks(scores, size)]


def _scores(scene: Pixels, pattern: Template | Disc, scale: float) -> Pixels:
    """Weighted correlation of the reduced pattern with a scene reduced alike; -1 where unknown."""
    # A few pixels that hardly vary would outweigh all the others.
    most = float(np.median(pattern.weight[pattern.weight > 0]))
    weight = _reduce(np.minimum(pattern.weight / most, np.float32(1.0)), scale)
    mask = weight if weight.min() < 1.0 else None  # one that masks nothing takes ten times the time
    appearance = _reduce(pattern.appearance, scale)
    scores = cv2.matchTemplate(scene, appearance, cv2.TM_CCOEFF_NORMED, mask=mask)
    # Where the scene is flat, the correlation is rounding over next to nothing.
    return np.where(np.abs(scores) <= 1.0 + ROUNDING, scores, np.float32(-1.0))


def _span(near: float, size: int, reach: float, end: int) -> tuple[int, int]:
    """First and last px of what is searched along one axis: the body may stick out at both ends."""
    beyond = int(BEYOND_SHARE * size)
    return int(max(-beyond, near - reach)), int(min(end + beyond, near + size + reach))


def _peaks(scores: Pixels, shape: tuple[int, int]) -> list[tuple[float, float]]:
    """Columns and rows of the highest scores that lie apart from each other, highest first."""
    rest = scores.copy()
    away_y, away_x = (max(1, round(APART_SHARE * size)) for size in shape)
    found = []
    for _ in range(PLACES):
        _, best, _, (x, y) = cv2.minMaxLoc(rest)
        if best < FOUND_AT_LEAST:
            break
        found.append((peak_of(scores[y, :], x), peak_of(scores[:, x], y)))
        rest[max(0, y - away_y) : y + away_y + 1, max(0, x - away_x) : x + away_x + 1] = -1.0
    return found


def _reduce(picture: Luma | Pixels, scale: float) -> Pixels:
    if scale <= 1.0:
        return picture.astype(np.float32)
    size = (max(1, round(picture.shape[1] / scale)), max(1, round(picture.shape[0] / scale)))
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.float32)

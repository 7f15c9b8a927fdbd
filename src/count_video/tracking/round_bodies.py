"""Is a body a ball, whatever its surface? Its outline in single pictures says so.

The template of a body is the mean of many pictures, in which a ball of two colours that spins shows
a part of itself at best. Each single picture shows its outline: a circle through the edges of what
differs from the background. A body is a ball if most of some samples show a circle of one radius
that holds most of what moves there.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from count_video.records import Floats, Indices, Luma, Mask, Pixels
from count_video.tracking.circle import Circle, Edges, circle_through, placed, steepest
from count_video.tracking.composite import Source
from count_video.tracking.disc import Disc, difference_at_least, register_discs
from count_video.tracking.learning import Body
from count_video.tracking.outline import BEYOND_OUTLINE_PX
from count_video.tracking.paths import only
from count_video.tracking.shape import Box

SAMPLES, FIRST = 12, 4
"""Circles are sought in so many samples, the first of them spread over all: if these show too few,
the others are not asked."""
PLACED = 60
"""In no more than so many samples the ball is placed; between them it moves by few px."""
SAME_SHARE = 0.75
"""So many of them, as a share, show the outline of a ball, ..."""
SAME_RADIUS, SAME_PX = 0.03, 0.7
"""... and its radius varies by no more than this share of it, or so many px."""
RADIUS_SOUGHT = (0.15, 0.7)
"""Radius of a ball as a share of the height in which it is sought, with its threads and shadow."""
AROUND_PX = 8
"""Circles are sought in the box of a body and so far around it."""
BESIDE_SHARE = 0.35
"""In a quarter of the samples no more of what hangs together with a ball lies outside of its
outline, as a share: a wheel is a part of its cart."""
THREAD_PX, EDGE_PX = 3, 5
"""What differs from the background and is narrower than the first is a thread; edges lie within
half of the second around the rest."""
SLOPE_AT_LEAST = 1.0
"""Edges are steeper than so many grey levels per px."""
SHOWN_AT_LEAST = 0.35
"""So much of a ball's outline shows at least, in half of the samples."""
AGREEMENT_SHARE = 0.75
"""Samples that agree less than this share of the median are dropped."""
NO_SIGHTINGS: Floats = np.empty((0, 5))


def find_ball(source: Source, path_px: Floats, box: Box) -> Body | None:
    """Find a ball by its outline in single samples; None where few show one and the same circle.

    ``path_px`` is image x and y of a point that moves roughly as the body does, shape (samples, 2),
    NaN where it is not seen, and ``box`` is around the body, from that point.
    """
    seen = np.flatnonzero(np.isfinite(path_px[:, 0]))
    found = _sightings(source, path_px, seen, box) if len(seen) >= FIRST else NO_SIGHTINGS
    if len(found) == 0 or np.quantile(found[:, 4], 0.25) > BESIDE_SHARE:
        return None
    disc = Disc(float(np.median(found[:, 3])))
    guesses = only(_guesses(found, path_px) - disc.middle_px, seen[:: -(-len(seen) // PLACED)])
    scene = source.pictures, source.background.luma, source.background.shift_px
    fits = register_discs(*scene, disc, guesses)
    agreement = fits.agreement[np.isfinite(fits.agreement)]
    typical = float(np.median(agreement)) if len(agreement) >= FIRST else 0.0
    if typical < SHOWN_AT_LEAST**0.5:
        return None
    good = np.flatnonzero(fits.agreement > AGREEMENT_SHARE * typical)
    disc = replace(disc, shift_variance=float(np.nanmedian(fits.sigmas_px[:, 0] ** 2)))
    path = only(fits.places_px, good)
    return Body(disc, disc.box, True, path, good, typical)


def _sightings(source: Source, path_px: Floats, seen: Indices, box: Box) -> Floats:
    """Find circles of one radius in some of the samples; none where too few show one.

    Returns rows of sample, x, y, radius, and share of what hangs together with the circle that lies
    outside of it.
    """
    some = np.unique(seen[np.linspace(0, len(seen) - 1, min(SAMPLES, len(seen))).astype(int)])
    found: list[tuple[float, ...]] = []
    first = some[:: -(-len(some) // FIRST)]
    for number, sample in enumerate([*first.tolist(), *np.setdiff1d(some, first).tolist()]):
        found += _sighting(source, sample, path_px[sample], box)
        asked = len(first) if number < len(first) else len(some)
        if number + 1 - len(found) > (1 - SAME_SHARE) * asked:
            return NO_SIGHTINGS
    rows = np.array(sorted(found))
    usual = float(np.median(rows[:, 3]))
    same = rows[np.abs(rows[:, 3] - usual) < max(SAME_RADIUS * usual, SAME_PX)]
    return same if len(same) >= SAME_SHARE * len(some) else NO_SIGHTINGS


def _guesses(found: Floats, path_px: Floats) -> Floats:
    """Guess the centre in all samples, shape (samples, 2), by where it is on the path in some."""
    some, every = found[:, 0].astype(int), np.arange(len(path_px))
    away = [np.interp(every, some, along) for along in (found[:, 1:3] - path_px[some]).T]
    return np.asarray(path_px + np.stack(away, axis=1))


def _sighting(source: Source, sample: int, place: Floats, box: Box) -> list[tuple[float, ...]]:
    """Find a circle about a place of one sample: its row, or nothing."""
    picture, background = source.pictures[sample], source.background
    begin = np.maximum(np.floor(place + box[:2]).astype(int) - AROUND_PX, 0)
    end = np.minimum(np.ceil(place + box[2:]).astype(int) + AROUND_PX, picture.shape[::-1])
    (left, top), (width, height) = begin.tolist(), (end - begin).tolist()
    if min(width, height) < 2 * AROUND_PX:
        return []
    piece = background.levelled(picture, sample, (left, top), (height, width))
    behind = background.behind(sample, (left, top), (height, width))
    for one in source.known:
        one.paint(behind, sample, (left, top))
    away = np.abs(piece - behind)
    differs = (away > difference_at_least(away)).astype(np.uint8)
    differs = np.asarray(cv2.morphologyEx(differs, cv2.MORPH_OPEN, _square(THREAD_PX)), np.uint8)
    edges = _edges(piece, cv2.dilate(differs, _square(EDGE_PX)) > 0)
    circle = circle_through(edges, height, RADIUS_SOUGHT)
    if circle is None:
        return []
    circle = placed(circle, edges)
    there = circle.x_px + left, circle.y_px + top, circle.radius_px
    return [(sample, *there, _beside(circle, differs))]


def _square(side: int) -> Luma:
    return np.ones((side, side), np.uint8)


def _beside(circle: Circle, differs: Luma) -> float:
    """Share of what hangs together with a circle that lies outside of it."""
    outside = circle.away_px(differs.shape) > BEYOND_OUTLINE_PX
    _, labels = cv2.connectedComponents(differs)
    own = np.isin(labels, np.setdiff1d(labels[~outside], 0))
    return float(own[outside].sum() / max(1, own.sum()))


def _edges(piece: Pixels, own: Mask) -> Edges:
    """Places of a picture that are steepest among their neighbours in the row or in the column."""
    return _edges_in_rows(piece, own).beside(_edges_in_rows(piece.T, own.T))


def _edges_in_rows(piece: Pixels, own: Mask) -> Edges:
    slope = np.where(own, np.abs(np.gradient(piece, axis=1)), 0)
    places, pixels = steepest(slope)
    clarity = slope[pixels].astype(np.float64)
    steep = clarity > SLOPE_AT_LEAST
    return Edges(places[steep], clarity[steep])

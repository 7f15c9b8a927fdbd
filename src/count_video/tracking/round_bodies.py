"""Is a body a ball, whatever its surface? Its outline in single pictures says so.

The template of a body is the mean of many pictures, in which a ball of two colours that spins shows
a part of itself at best. Each single picture shows its outline: a circle through the edges of what
differs from the background. A body is a ball if most of some samples show a circle of one radius
that holds most of what moves there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from count_video.records import Floats, Indices, Luma, Mask, Pixels
from count_video.tracking.background import Background
from count_video.tracking.circle import Circle, Edges, circle_through, placed, steepest
from count_video.tracking.disc import Disc, WithBackground, difference_at_least, register_discs
from count_video.tracking.learning import Body
from count_video.tracking.outline import BEYOND_OUTLINE_PX
from count_video.tracking.paths import only
from count_video.tracking.sequences import Lumas
from count_video.tracking.shape import Box, Shape

SAMPLES, FIRST = 12, 4
"""Circles are sought in so many samples, the first of them spread over all: if these show too few,
the others are not asked."""
PLACED = 60
"""In no more than so many samples the ball is placed; between them it moves by few px."""
SAME_SHARE = 0.75
"""So many of them, as a share, show the outline of a ball, ..."""
SAME_RADIUS, SAME_PX = 0.03, 0.7
"""... and its radius varies by no more than this share of it, or so many px."""
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


@dataclass(frozen=True)
class _Sighting:
    """A circle in one sample."""

    sample: int
    circle: Circle
    beside: float
    """Share of what hangs together with it that lies outside of it."""


def find_ball(
    source: tuple[Lumas, Background], path_px: Floats, box: Box, known: Sequence[Shape]
) -> Body | None:
    """Find a ball by its outline in single samples.

    Parameters
    ----------
    source
        Samples, each of shape (height, width), and what stands still in them.
    path_px
        Image x and y of a point that moves roughly as the body does, shape (samples, 2); NaN where
        it is not seen.
    box
        Around the body, from that point.
    known
        Bodies that are known already.

    Returns
    -------
    Body or None
        None where few samples show one and the same circle.
    """
    pictures, background = source
    seen = np.flatnonzero(np.isfinite(path_px[:, 0]))
    found = _sightings(source, path_px, seen, (box, known)) if len(seen) >= FIRST else []
    if not found or np.quantile([one.beside for one in found], 0.25) > BESIDE_SHARE:
        return None
    disc = Disc(float(np.median([one.circle.radius_px for one in found])))
    scene = WithBackground(pictures, background.luma, background.shift_px)
    guesses = _guesses(found, path_px) - disc.middle_px
    fits = register_discs(scene, disc, only(guesses, seen[:: -(-len(seen) // PLACED)]))
    agreement = fits.agreement[np.isfinite(fits.agreement)]
    typical = float(np.median(agreement)) if len(agreement) >= FIRST else 0.0
    if typical < SHOWN_AT_LEAST**0.5:
        return None
    good = np.flatnonzero(fits.agreement > AGREEMENT_SHARE * typical)
    left, top, right, bottom = disc.box
    disc = replace(disc, shift_variance=float(np.nanmedian(fits.sigmas_px[:, 0] ** 2)))
    path = only(fits.places_px, good)
    return Body(disc, left, right, (top, bottom), True, path, good, typical)


def _sightings(
    source: tuple[Lumas, Background],
    path_px: Floats,
    seen: Indices,
    what: tuple[Box, Sequence[Shape]],
) -> list[_Sighting]:
    """Find circles of one radius in some of the samples; none where too few show one."""
    some = np.unique(seen[np.linspace(0, len(seen) - 1, min(SAMPLES, len(seen))).astype(int)])
    first = some[:: -(-len(some) // FIRST)]
    found: list[_Sighting] = []
    for number, sample in enumerate([*first.tolist(), *np.setdiff1d(some, first).tolist()]):
        one = _sighting(source, sample, path_px[sample], what)
        if one is not None:
            found.append(one)
        asked = len(first) if number < len(first) else len(some)
        if number + 1 - len(found) > (1 - SAME_SHARE) * asked:
            return []
    same = _of_one_radius(found)
    return same if len(same) >= SAME_SHARE * len(some) else []


def _of_one_radius(found: list[_Sighting]) -> list[_Sighting]:
    """Keep circles of about the usual radius, in order of time."""
    usual = float(np.median([one.circle.radius_px for one in found]))
    varies = max(SAME_RADIUS * usual, SAME_PX)
    same = [one for one in found if abs(one.circle.radius_px - usual) < varies]
    return sorted(same, key=lambda one: one.sample)


def _guesses(found: Sequence[_Sighting], path_px: Floats) -> Floats:
    """Guess the centre in all samples, shape (samples, 2), by where it is on the path in some."""
    some = np.array([one.sample for one in found])
    centres = np.array([(one.circle.x_px, one.circle.y_px) for one in found])
    every = np.arange(len(path_px))
    away = [np.interp(every, some, along) for along in (centres - path_px[some]).T]
    return np.asarray(path_px + np.stack(away, axis=1))


def _sighting(
    source: tuple[Lumas, Background],
    sample: int,
    place: Floats,
    what: tuple[Box, Sequence[Shape]],
) -> _Sighting | None:
    """Find a circle about a place of one sample."""
    (pictures, background), (box, known) = source, what
    picture = pictures[sample]
    begin = np.maximum(np.floor(place + box[:2]).astype(int) - AROUND_PX, 0)
    end = np.minimum(np.ceil(place + box[2:]).astype(int) + AROUND_PX, picture.shape[::-1])
    (left, top), (width, height) = begin.tolist(), (end - begin).tolist()
    if min(width, height) < 2 * AROUND_PX:
        return None
    piece = background.levelled(picture, sample, (left, top), (height, width))
    behind = background.behind(sample, (left, top), (height, width))
    for one in known:
        one.paint(behind, sample, (left, top))
    away = np.abs(piece - behind)
    differs = (away > difference_at_least(away)).astype(np.uint8)
    differs = np.asarray(cv2.morphologyEx(differs, cv2.MORPH_OPEN, _square(THREAD_PX)), np.uint8)
    edges = _edges(piece, cv2.dilate(differs, _square(EDGE_PX)) > 0)
    circle = circle_through(edges, height)
    if circle is None:
        return None
    circle = placed(circle, edges)
    there = Circle(circle.x_px + left, circle.y_px + top, circle.radius_px, circle.sectors)
    return _Sighting(sample, there, _beside(circle, differs))


def _square(side: int) -> Luma:
    return np.ones((side, side), np.uint8)


def _beside(circle: Circle, differs: Luma) -> float:
    """Share of what hangs together with a circle that lies outside of it."""
    y, x = np.indices(differs.shape)
    outside = np.hypot(x - circle.x_px, y - circle.y_px) > circle.radius_px + BEYOND_OUTLINE_PX
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

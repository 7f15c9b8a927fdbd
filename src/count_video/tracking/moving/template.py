"""The template of a body: its mean appearance over many pictures, with a weight for each pixel.

Pieces of pictures are laid upon each other where the body's corners were followed to, averaged, and
registered to their mean; the mean of the registered pieces is the template. What is not the body
varies from picture to picture and gets little weight. Pictures count by how rare they are: those in
which a body rests, or two move along side by side, are many and show nothing new.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.looks.outline import Mean, Outline, find_outline
from count_video.tracking.looks.register import register
from count_video.tracking.looks.sprite import Pixels, Sprite, look, make_sprite

Luma = NDArray[np.uint8]
Place = tuple[float, float]
Box = tuple[float, float, float, float]
"""Left, top, right, bottom in px."""

SURROUNDINGS = 0.6
"""The surroundings that are averaged too, on either side, as a share of the box's height."""
NOISE_FLOOR = 1.0
"""Variance in grey levels squared that every pixel has at least (rounding, compression)."""
LEVEL_STRIDE = 4
"""Brightness is measured on every fourth pixel of every fourth row."""
PICTURES, PICTURES_AT_LEAST, PIXELS = 40, 12, 2_000_000
"""A template is the mean of so many pictures; of large bodies of fewer, so that all pieces together
have no more pixels than this."""
NEIGHBOURHOOD_PX, COVERED_RATIO = 5, 1.5
"""A pixel moves with the body if the pieces differ from what lies behind it by this many times the
variance that they have among each other, over a neighbourhood of this side."""
ROUND_HEIGHT = 0.87, 1.15
"""Height of the rows at least half as wide as a ball's outline, over its width."""
ROUNDS = 3
SIGHTINGS_AT_LEAST = 4
AGREEMENT_AT_LEAST = 0.5
"""Correlation below which a piece is not taken for the body."""
AGREEMENT_SHARE = 0.9
"""Pieces that agree less than this share of the median are dropped."""
INSIDE_AT_LEAST = 0.7
"""Share of the template that must lie within a picture to learn from it."""
PLACE_BIN_PX = 3.0
"""Pictures with the same bin of places, or of distances to the neighbour, are alike."""


@dataclass(frozen=True)
class Rough:
    """A body as its corners show it; positions are those of a point that moves with it."""

    path_px: Mapping[int, Place]
    """Frame index -> image x and y of that point."""
    box: Box
    """Around the corners, from that point."""
    fence: tuple[float, float]
    """Image x, from that point, beyond which the neighbours' corners begin."""
    blurred: bool = False
    """Whether the path is that of a region, right to some px only."""
    patterned: bool = True
    """Whether many corners show it."""


@dataclass(frozen=True)
class Background:
    """What stands still behind the bodies."""

    luma: Luma
    """Median of some pictures, freed of the camera's motion, shape (height, width)."""
    shift_px: Mapping[int, Place]
    """Frame index -> how far the camera has moved the picture, by x and y."""

    def behind(self, frame: int, place: Place, shape: tuple[int, int]) -> Pixels:
        """Cut out what lies behind a piece of a picture."""
        x, y = self.shift_px.get(frame, (0.0, 0.0))
        return look(self.luma, place[0] - x, place[1] - y, shape)


@dataclass(frozen=True)
class Body:
    """A template with its outline; x is measured from the template's left column."""

    sprite: Sprite
    left_edge_px: float
    right_edge_px: float
    """Where the outline's outermost points are."""
    round_: bool
    """Whether the outline is a circle, or as high as one of its width."""
    sightings: dict[int, Place]
    """Frame index -> (x, y) of the template's top left pixel, roughly where it was not learnt."""
    learnt: tuple[int, ...]
    """Frames of the pictures it was learnt from, in which it was registered."""
    typical_agreement: float
    """Median correlation with the pictures it was learnt from."""


def learn(
    pictures: Mapping[int, Luma],
    background: Background,
    rough: Rough,
    others: Sequence[Mapping[int, Place]],
) -> Body | None:
    """Learn the template of a body that is roughly known.

    Parameters
    ----------
    pictures
        Frame index -> luma, shape (height, width).
    background
        What stands still in them.
    rough
        The body as its corners show it.
    others
        Paths of the other bodies, by which pictures are told to be alike.

    Returns
    -------
    Body or None
        None where the pieces show no outline, or too few agree with their mean.
    """
    left, top, right, bottom = (round(edge) for edge in rough.box)
    margin = round(SURROUNDINGS * (bottom - top))
    shape = bottom - top, right - left + 2 * margin
    corner = left - margin, top
    rarity = _rarity(rough.path_px, others)
    chosen = _some(rarity, shape)
    if len(chosen) < len(rarity):  # chosen by their rarity, they count alike
        rarity = dict.fromkeys(chosen, 1.0)
    places = {k: _plus(rough.path_px[k], corner) for k in chosen if k in pictures}
    fence = rough.fence[0] - corner[0], rough.fence[1] - corner[0]
    outline, agreement = None, 0.0
    if rough.blurred:
        places = _aligned(pictures, places, (shape, margin))
    for _ in range(ROUNDS):
        if len(places) < SIGHTINGS_AT_LEAST:
            return None
        outline = find_outline(_average((pictures, background), places, rarity, shape), fence)
        if outline is None:
            return None
        places, agreement = _registered(pictures, places, outline)
    if outline is None or len(places) < SIGHTINGS_AT_LEAST:
        return None
    return _body(outline, rough.path_px, places, (corner, agreement))


def _aligned(
    pictures: Mapping[int, Luma], places: Mapping[int, Place], extent: tuple[tuple[int, int], int]
) -> dict[int, Place]:
    """Places that are right to some px, made better by registration to one of the pieces."""
    (height, width), margin = extent
    if not places:
        return {}
    weight = np.zeros((height, width), dtype=np.float32)
    y, x = np.indices(weight.shape)
    across, along = (height - 1) / 2, (width - 1) / 2
    weight[((y - across) / across) ** 2 + ((x - along) / (along - margin)) ** 2 < 1] = 1.0
    best: dict[int, Place] = {}
    for first in sorted(places)[len(places) // 4 :: max(1, len(places) // 4)]:
        sprite = make_sprite(look(pictures[first], *places[first], (height, width)), weight)
        fits = {k: register(pictures[k], sprite, place) for k, place in places.items()}
        good = {
            k: (fit.x_px, fit.y_px)
            for k, fit in fits.items()
            if fit is not None and fit.agreement > AGREEMENT_AT_LEAST
        }
        best = max(best, good, key=len)
    return best


def _body(
    outline: Outline,
    path: Mapping[int, Place],
    places: Mapping[int, Place],
    corner_and_agreement: tuple[tuple[int, int], float],
) -> Body:
    corner, agreement = corner_and_agreement
    away = np.array([np.subtract(places[k], _plus(path[k], corner)) for k in places])
    drift = np.median(away, axis=0)
    rough = {
        k: _plus(place, (corner[0] + drift[0], corner[1] + drift[1])) for k, place in path.items()
    }
    sightings = {k: (x + outline.begin_px, y) for k, (x, y) in (rough | dict(places)).items()}
    return Body(
        outline.sprite,
        outline.left_px,
        outline.right_px,
        outline.round_ or _as_high_as_wide(outline),
        sightings,
        tuple(sorted(places)),
        agreement,
    )


def _as_high_as_wide(outline: Outline) -> bool:
    """Whether the rows at least half as wide as the outline are as many as a circle has.

    A circle's chords are longer than its radius over 0.87 of its diameter; the edge's blur, which
    the template holds as well, adds some px. Threads are narrow and add none.
    """
    held = outline.sprite.weight > 0
    last = held.shape[1] - np.argmax(held[:, ::-1], axis=1)
    wide = np.where(held.any(axis=1), last - np.argmax(held, axis=1), 0)
    width = outline.right_px - outline.left_px
    high = float(np.count_nonzero(wide >= 0.5 * width))
    return ROUND_HEIGHT[0] * width < high < ROUND_HEIGHT[1] * width


def _plus(place: Place, corner: tuple[float, float]) -> Place:
    return place[0] + corner[0], place[1] + corner[1]


def _some(rarity: Mapping[int, float], shape: tuple[int, int]) -> list[int]:
    """Pictures to learn from, evenly spread over the clip by their rarity."""
    count = int(np.clip(PIXELS // (shape[0] * shape[1]), PICTURES_AT_LEAST, PICTURES))
    frames = sorted(rarity)
    if len(frames) <= count:
        return frames
    share = np.cumsum([rarity[frame] for frame in frames])
    picked = np.searchsorted(share, (np.arange(count) + 0.5) / count * share[-1])
    return [frames[place] for place in np.unique(picked)]


def _rarity(path: Mapping[int, Place], others: Sequence[Mapping[int, Place]]) -> dict[int, float]:
    """Weight of each picture: rare places and rare distances from other bodies count more."""
    bins = [{k: round(x / PLACE_BIN_PX) for k, (x, _) in path.items()}]
    for other in others:
        apart = {k: other[k][0] - x for k, (x, _) in path.items() if k in other}
        bins.append({k: round(x / PLACE_BIN_PX) for k, x in apart.items()})
    counts = [Counter(binned.values()) for binned in bins]
    return {
        k: float(np.prod([1 / c[b[k]] for b, c in zip(bins, counts, strict=True) if k in b]))
        for k in path
    }


def _average(
    pictures_and_background: tuple[Mapping[int, Luma], Background],
    places: Mapping[int, Place],
    rarity: Mapping[int, float],
    shape: tuple[int, int],
) -> Mean:
    """Weighted mean and variance of pieces of pictures at these places."""
    pictures, background = pictures_and_background
    pieces = np.array([look(pictures[k], x, y, shape) for k, (x, y) in places.items()])
    behind = np.array([background.behind(k, place, shape) for k, place in places.items()])
    # Lamps flicker: every piece is brought to the common mean brightness first.
    level = np.median(pieces[:, ::LEVEL_STRIDE, ::LEVEL_STRIDE], axis=(1, 2))
    pieces *= (np.median(level) / (level + 1e-6))[:, None, None]
    weight = np.array([rarity[k] for k in places])
    share = (weight / weight.sum()).astype(np.float32)
    mean = np.tensordot(share, pieces, axes=1)
    variance = np.tensordot(share, (pieces - mean) ** 2, axes=1) + NOISE_FLOOR
    covered = np.tensordot(share, (pieces - behind) ** 2, axes=1) + NOISE_FLOOR
    size = NEIGHBOURHOOD_PX, NEIGHBOURHOOD_PX
    moving = cv2.blur(covered, size) > COVERED_RATIO * cv2.blur(variance, size)
    return Mean(mean.astype(np.float32), variance.astype(np.float32), np.asarray(moving))


def _registered(
    pictures: Mapping[int, Luma], places: Mapping[int, Place], outline: Outline
) -> tuple[dict[int, Place], float]:
    """Places of the pieces, registered to their mean, and the median agreement."""
    fits = {
        k: register(pictures[k], outline.sprite, (x + outline.begin_px, y))
        for k, (x, y) in places.items()
    }
    good = {
        k: fit
        for k, fit in fits.items()
        if fit and fit.agreement >= AGREEMENT_AT_LEAST and fit.inside >= INSIDE_AT_LEAST
    }
    if not good:
        return {}, 0.0
    typical = float(np.median([fit.agreement for fit in good.values()]))
    kept = {k: fit for k, fit in good.items() if fit.agreement > AGREEMENT_SHARE * typical}
    return {k: (fit.x_px - outline.begin_px, fit.y_px) for k, fit in kept.items()}, typical


def line_tilt_deg(paths: Sequence[Floats]) -> float:
    """Find the common direction of paths, shape (n, 2) each, in (-90, 90] degrees from image x."""
    moments = np.zeros((2, 2))
    for path in paths:
        known = path[np.isfinite(path[:, 0])]
        away = known - known.mean(axis=0)
        moments += away.T @ away
    return float(np.degrees(0.5 * np.arctan2(2 * moments[0, 1], moments[0, 0] - moments[1, 1])))

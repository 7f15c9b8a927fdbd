"""From a box in one picture to the appearance of a body, learnt from many pictures.

Each box is found again in pictures spread over the clip, and the pieces are laid upon each other
and averaged. To smear out what is not the body, pictures count by how rare they are: those in
which a body rests, or two move along side by side, are many and show nothing new.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Frame
from count_video.tracking.outline import Mean, Outline, find_outline
from count_video.tracking.register import Fit, register
from count_video.tracking.search import search
from count_video.tracking.sprite import Sprite, look, make_sprite

Box = tuple[float, float, float, float]
"""Left, top, right, bottom in px."""

SURROUNDINGS = 0.6
"""The surroundings that are averaged too, on either side, as a share of the box's height."""
AGREEMENT_AT_LEAST = 0.5
"""Correlation below which a piece is not taken for the body."""
AGREEMENT_SHARE = 0.9
"""Sightings that agree less than this share of the median are dropped."""
INSIDE_AT_LEAST = 0.7
"""Share of the sprite that must lie within a picture to learn from it."""
NOISE_FLOOR = 1.0
"""Variance in grey levels squared that every pixel has at least (rounding, compression)."""
LEVEL_STRIDE = 4
"""Brightness is told by every fourth pixel of every fourth row."""
ROUNDS = 2
FRAMES_OF_A_RUN = 4
"""Of a run of frames only so many are used: neighbours show almost the same."""
SIGHTINGS_AT_LEAST = 4
NEAR_FRAMES = 6
SPEED_SLACK = 0.05
"""px per frame; features tell a velocity to about this."""
PLACE_BIN_PX = 3.0
"""Pictures with the same bin of places, or of distances to the neighbour, are alike."""


@dataclass(frozen=True)
class Seed:
    """Where one picture shows a body."""

    frame: int
    box: Box
    """What is cut out of the picture."""
    core: Box
    """The part of it that surely moves along: where the features are."""
    speed_px_frame: float
    """How fast they move along the line."""
    fence: tuple[float, float] = (-np.inf, np.inf)
    """Image x within which the body lies in that picture: beyond are its neighbours."""


@dataclass(frozen=True)
class Body:
    """A sprite with its outline; x is measured from the sprite's left column."""

    sprite: Sprite
    left_edge_px: float
    right_edge_px: float
    """Where the outline's outermost points are."""
    round_: bool
    """Whether the outline is a circle."""
    sightings: dict[int, tuple[float, float]]
    """Frame index -> (x, y) of the sprite's top left pixel, where it was seen on the way."""
    typical_agreement: float
    """Median correlation with the pictures it was learnt from."""


@dataclass(frozen=True)
class _Place:
    x_px: float
    y_px: float
    agreement: float


@dataclass(frozen=True)
class _Sketch:
    """A body as far as it is known."""

    seed: Seed
    sprite: Sprite
    start: tuple[float, float]
    """Place of the sprite's top left pixel in the seed's picture."""
    outline: Outline | None = None


def learn(
    runs: Sequence[Sequence[Frame]], seeds: Sequence[Seed], tilt_deg: float
) -> list[Body] | None:
    """Learn neighbouring bodies together from runs of frames, given a box for each.

    Returns None if one of them cannot be found again, or shows no outline.
    """
    pictures = {seen.index: seen.luma for run in runs for seen in run}
    sketches = [_sketch(pictures, seed) for seed in seeds]
    for _ in range(ROUNDS):
        places = []
        for sketch in sketches:
            places.append(_find_everywhere(runs, sketch, tilt_deg))
            if len(places[-1]) < SIGHTINGS_AT_LEAST or sketch.seed.frame not in places[-1]:
                return None
        improved = []
        for number, sketch in enumerate(sketches):
            others = [found for other, found in enumerate(places) if other != number]
            better = _improved(pictures, sketch, places[number], others)
            if better is None:
                return None
            improved.append(better)
        sketches = improved
    bodies = [_finished(sketch, _find_everywhere(runs, sketch, tilt_deg)) for sketch in sketches]
    learnt = [body for body in bodies if body is not None]
    return learnt if len(learnt) == len(bodies) else None


def _sketch(pictures: Mapping[int, NDArray[np.uint8]], seed: Seed) -> _Sketch:
    left, top, right, bottom = (round(edge) for edge in seed.box)
    shape = (bottom - top, right - left)
    piece = look(pictures[seed.frame], left, top, shape)
    weight = np.zeros(shape, dtype=np.float32)
    x, y = np.meshgrid(np.arange(left, right), np.arange(top, bottom))
    core = seed.core
    weight[(x >= core[0]) & (y >= core[1]) & (x <= core[2]) & (y <= core[3])] = 1.0
    return _Sketch(seed, make_sprite(piece, weight), (float(left), float(top)))


def _improved(
    pictures: Mapping[int, NDArray[np.uint8]],
    sketch: _Sketch,
    places: dict[int, _Place],
    others: Sequence[dict[int, _Place]],
) -> _Sketch | None:
    """Sketch the body anew from the mean of where it was found."""
    seed = sketch.seed
    margin = round(SURROUNDINGS * sketch.sprite.shape[0])
    weight = _rarity(places, others)
    mean = _average(pictures, places, weight, (sketch.sprite.shape, margin))
    here = places[seed.frame]
    first = here.x_px - margin
    outline = find_outline(mean, (seed.fence[0] - first, seed.fence[1] - first))
    if outline is None:
        return None
    return _Sketch(seed, outline.sprite, (first + outline.begin_px, here.y_px), outline)


def _finished(sketch: _Sketch, places: dict[int, _Place]) -> Body | None:
    if sketch.outline is None or len(places) < SIGHTINGS_AT_LEAST:
        return None
    if not _moves_along(sketch.seed, places):
        return None
    return Body(
        sprite=sketch.sprite,
        left_edge_px=sketch.outline.left_px,
        right_edge_px=sketch.outline.right_px,
        round_=sketch.outline.round_,
        sightings={index: (place.x_px, place.y_px) for index, place in places.items()},
        typical_agreement=_typical(places),
    )


def _moves_along(seed: Seed, places: dict[int, _Place]) -> bool:
    """Check that around the seed's frame the body moves as its features did.

    What was learnt by mistake from the scenery stands still there.
    """
    near = [index for index in places if abs(index - seed.frame) <= NEAR_FRAMES]
    if len(near) < 2:
        return True
    first, last = min(near), max(near)
    speed = (places[last].x_px - places[first].x_px) / (last - first)
    return abs(speed - seed.speed_px_frame) < max(SPEED_SLACK, 0.5 * abs(seed.speed_px_frame))


def _find_everywhere(
    runs: Sequence[Sequence[Frame]], sketch: _Sketch, tilt_deg: float
) -> dict[int, _Place]:
    """Places of the sprite, by frame index, wherever it agrees."""
    slope = float(np.tan(np.radians(tilt_deg)))
    frame = sketch.seed.frame
    found: dict[int, _Place] = {}
    for run in (_thinned(run, frame) for run in runs):
        path = _Path()
        order = list(run)
        if any(seen.index == frame for seen in run):
            order.sort(key=lambda seen: abs(seen.index - frame))
            path = _Path(frame, sketch.start, sketch.seed.speed_px_frame)
        for seen in order:
            fit = _find(seen.luma, sketch, path.at(seen.index, slope), slope, _typical(found))
            if fit is None:
                path = _Path()
                continue
            path = path.onward(seen.index, (fit.x_px, fit.y_px))
            found[seen.index] = _Place(fit.x_px, fit.y_px, fit.agreement)
    return _agreeing(found)


def _find(
    picture: NDArray[np.uint8],
    sketch: _Sketch,
    guess: tuple[float, float] | None,
    slope: float,
    typical: float,
) -> Fit | None:
    """Register the sprite at a guess, or where a search finds it if there it agrees poorly."""
    fit = None if guess is None else register(picture, sketch.sprite, guess)
    if fit is None or fit.agreement < AGREEMENT_SHARE * typical:
        other = search(picture, sketch.sprite, sketch.start, slope)
        if other is not None and (fit is None or other.agreement > fit.agreement):
            fit = other
    if fit is None or fit.agreement < AGREEMENT_AT_LEAST or fit.inside < INSIDE_AT_LEAST:
        return None
    return fit


def _typical(places: dict[int, _Place]) -> float:
    """Median agreement; 0 of none."""
    return float(np.median([place.agreement for place in places.values()])) if places else 0.0


def _agreeing(places: dict[int, _Place]) -> dict[int, _Place]:
    """Drop sightings that agree clearly less than most: the body was hidden, or it is another."""
    least = AGREEMENT_SHARE * _typical(places)
    return {index: place for index, place in places.items() if place.agreement > least}


@dataclass(frozen=True)
class _Path:
    """Where a body was last seen within a run, and how it moves."""

    index: int = 0
    place: tuple[float, float] | None = None
    speed_px_frame: float = 0.0

    def at(self, index: int, slope: float) -> tuple[float, float] | None:
        """Place to expect in a frame; None if nothing is known."""
        if self.place is None:
            return None
        way = self.speed_px_frame * (index - self.index)
        return self.place[0] + way, self.place[1] + slope * way

    def onward(self, index: int, place: tuple[float, float]) -> _Path:
        """Path with one more sighting."""
        if self.place is None or index == self.index:
            return _Path(index, place, self.speed_px_frame)
        return _Path(index, place, (place[0] - self.place[0]) / (index - self.index))


def _thinned(run: Sequence[Frame], keep: int) -> list[Frame]:
    """Take some frames of a run, spread over it."""
    step = max(1, round((len(run) - 1) / (FRAMES_OF_A_RUN - 1)))
    return [seen for place, seen in enumerate(run) if place % step == 0 or seen.index == keep]


def _rarity(places: dict[int, _Place], others: Sequence[dict[int, _Place]]) -> Floats:
    """Weight of each picture, shape (n,), sum 1: rare places and rare distances count more."""
    bins = [_bins({index: place.x_px for index, place in places.items()})]
    for other in others:
        bins.append(
            _bins({i: other[i].x_px - place.x_px for i, place in places.items() if i in other})
        )
    weight = np.ones(len(places))
    for binned in bins:
        crowd = Counter(binned.values())
        weight /= [crowd[binned[index]] if index in binned else 1 for index in places]
    return np.asarray(weight / weight.sum(), dtype=np.float64)


def _bins(values: dict[int, float]) -> dict[int, int]:
    return {index: round(value / PLACE_BIN_PX) for index, value in values.items()}


def _average(
    pictures: Mapping[int, NDArray[np.uint8]],
    places: dict[int, _Place],
    weight: Floats,
    extent: tuple[tuple[int, int], int],
) -> Mean:
    """Weighted mean and variance of the sprite's box and a margin beside it."""
    (height, width), margin = extent
    size = (height, width + 2 * margin)
    pieces = np.array(
        [
            look(pictures[index], place.x_px - margin, place.y_px, size)
            for index, place in places.items()
        ]
    )
    # Lamps flicker: every piece is brought to the common mean brightness first.
    level = np.median(pieces[:, ::LEVEL_STRIDE, ::LEVEL_STRIDE], axis=(1, 2))
    pieces *= (np.median(level) / (level + 1e-6))[:, None, None]
    share = weight.astype(np.float32)
    mean = np.tensordot(share, pieces, axes=1)
    variance = np.tensordot(share, (pieces - mean) ** 2, axes=1) + NOISE_FLOOR
    return Mean(mean.astype(np.float32), variance.astype(np.float32))

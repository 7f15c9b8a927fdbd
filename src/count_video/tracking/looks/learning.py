"""From a box in one picture to the appearance of a body, learnt from many pictures.

Each box is found again in pictures spread over the clip, and the pieces are laid upon each other
and averaged. To smear out what is not the body, pictures count by how rare they are: those in
which a body rests, or two move along side by side, are many and show nothing new.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Frame
from count_video.tracking.looks.outline import Mean, find_outline
from count_video.tracking.looks.sightings import (
    Place,
    Seed,
    Sketch,
    find_everywhere,
    typical_agreement,
)
from count_video.tracking.looks.sprite import Sprite, look, make_sprite

SURROUNDINGS = 0.6
"""The surroundings that are averaged too, on either side, as a share of the box's height."""
NOISE_FLOOR = 1.0
"""Variance in grey levels squared that every pixel has at least (rounding, compression)."""
LEVEL_STRIDE = 4
"""Brightness is told by every fourth pixel of every fourth row."""
ROUNDS = 2
SIGHTINGS_AT_LEAST = 4
ORDERED_AT_LEAST = 0.5
"""Share of the pictures in which neighbours keep their order."""
NEAR_FRAMES = 6
SPEED_SLACK = 0.05
"""px per frame; features tell a velocity to about this."""
PLACE_BIN_PX = 3.0
"""Pictures with the same bin of places, or of distances to the neighbour, are alike."""


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


def learn(
    runs: Sequence[Sequence[Frame]], seeds: Sequence[Seed], tilt_deg: float
) -> list[Body] | None:
    """Learn neighbouring bodies together from runs of frames, given a box for each.

    Returns None if one of them cannot be found again, or shows no outline.
    """
    pictures = {seen.index: seen.luma for run in runs for seen in run}
    sketches = [_sketch(pictures, seed) for seed in seeds]
    for _ in range(ROUNDS):
        places = _found_again(runs, sketches, tilt_deg)
        if places is None:
            return None
        improved = []
        for number, sketch in enumerate(sketches):
            others = [found for other, found in enumerate(places) if other != number]
            better = _improved(pictures, sketch, places[number], others)
            if better is None:
                return None
            improved.append(better)
        sketches = improved
    bodies = [_finished(sketch, find_everywhere(runs, sketch, tilt_deg)) for sketch in sketches]
    learnt = [body for body in bodies if body is not None]
    return learnt if len(learnt) == len(bodies) else None


def _sketch(pictures: Mapping[int, NDArray[np.uint8]], seed: Seed) -> Sketch:
    left, top, right, bottom = (round(edge) for edge in seed.box)
    shape = (bottom - top, right - left)
    piece = look(pictures[seed.frame], left, top, shape)
    weight = np.zeros(shape, dtype=np.float32)
    x, y = np.meshgrid(np.arange(left, right), np.arange(top, bottom))
    core = seed.core
    weight[(x >= core[0]) & (y >= core[1]) & (x <= core[2]) & (y <= core[3])] = 1.0
    return Sketch(seed, make_sprite(piece, weight), (float(left), float(top)))


def _found_again(
    runs: Sequence[Sequence[Frame]], sketches: Sequence[Sketch], tilt_deg: float
) -> list[dict[int, Place]] | None:
    """Find all bodies all over the clip; None if one of them is not found, or out of its place."""
    places = []
    for sketch in sketches:
        places.append(find_everywhere(runs, sketch, tilt_deg))
        if len(places[-1]) < SIGHTINGS_AT_LEAST or sketch.seed.frame not in places[-1]:
            return None
    return places if _in_order(sketches, places) else None


def _in_order(sketches: Sequence[Sketch], places: Sequence[dict[int, Place]]) -> bool:
    """Whether neighbours, the left one first, keep their order more often than not.

    One is taken for the other otherwise, and a mean over both would show neither.
    """
    middles = [
        {index: place.x_px + sketch.sprite.shape[1] / 2 for index, place in found.items()}
        for sketch, found in zip(sketches, places, strict=True)
    ]
    for left, right in pairwise(middles):
        ordered = [left[index] < right[index] for index in set(left) & set(right)]
        if ordered and np.mean(ordered) < ORDERED_AT_LEAST:
            return False
    return True


def _improved(
    pictures: Mapping[int, NDArray[np.uint8]],
    sketch: Sketch,
    places: dict[int, Place],
    others: Sequence[dict[int, Place]],
) -> Sketch | None:
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
    return Sketch(seed, outline.sprite, (first + outline.begin_px, here.y_px), outline)


def _finished(sketch: Sketch, places: dict[int, Place]) -> Body | None:
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
        typical_agreement=typical_agreement(places),
    )


def _moves_along(seed: Seed, places: dict[int, Place]) -> bool:
    """Check that around the seed's frame the body moves as its features did.

    What was learnt by mistake from the scenery stands still there.
    """
    near = [index for index in places if abs(index - seed.frame) <= NEAR_FRAMES]
    if len(near) < 2:
        return True
    first, last = min(near), max(near)
    speed = (places[last].x_px - places[first].x_px) / (last - first)
    return abs(speed - seed.speed_px_frame) < max(SPEED_SLACK, 0.5 * abs(seed.speed_px_frame))


def _rarity(places: dict[int, Place], others: Sequence[dict[int, Place]]) -> Floats:
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
    places: dict[int, Place],
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

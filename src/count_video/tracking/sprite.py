"""From a box in one picture to the appearance of a body, learnt from many pictures.

The box is found again in pictures spread over the clip; the pieces are laid upon each other and
averaged. What belongs to the body stays the same, so its edges stay sharp in the mean; what lies
behind it, the neighbour, or a reflection that does not quite follow, smears out and varies. The
slope of the mean over the standard deviation of the pixels is therefore high on the body's own
edges only: it gives the outline and the weights without a word on shape, colour or brightness.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Frame
from count_video.tracking.register import (
    Pixels,
    Sprite,
    look,
    make_sprite,
    register,
)
from count_video.tracking.search import search

Box = tuple[float, float, float, float]
"""Left, top, right, bottom in px."""

SURROUNDINGS = 0.6
"""The surroundings that are averaged too, on either side, as a share of the box's height."""
AGREEMENT_AT_LEAST = 0.5
"""Correlation below which a piece is not taken for the body."""
EDGE_POSSIBLE = 0.35
"""Slope per px over the standard deviation, from which on an edge can be the body's own."""
PIECE_SHARE = 0.01
PIECE_HEIGHT = 0.2
"""A piece of the outline has these shares of the clearest piece's weight and of the height."""
BEYOND_OUTLINE_PX = 2
"""Pixels kept beyond the outline: the blurred edge reaches that far."""
NOISE_FLOOR = 1.0
"""Variance in grey levels squared that every pixel has at least (rounding, compression)."""
ROUNDS = 2
FRAMES_OF_A_RUN = 4
PLACE_BIN_PX = 3.0
FRAMES_OF_A_PLACE = 2
"""So many frames with the body within one bin take part in the mean."""
AGREEMENT_SHARE = 0.9
"""Sightings that agree less than this share of the median are dropped in the end."""


@dataclass(frozen=True)
class Body:
    """A sprite with its outline; x is measured from the sprite's left column."""

    sprite: Sprite
    left_edge_px: float
    right_edge_px: float
    """Where the outline's outermost points are."""
    sightings: dict[int, tuple[float, float]]
    """Frame index -> (x, y) of the sprite's top left pixel, where it was seen on the way."""
    typical_agreement: float
    """Median correlation with the pictures it was learnt from."""


@dataclass(frozen=True)
class _Mean:
    appearance: Pixels
    variance: Pixels
    """In the body's frame."""


@dataclass(frozen=True)
class Seed:
    """Where one picture shows the body."""

    frame: int
    box: Box
    fence: tuple[float, float] = (-np.inf, np.inf)
    """Image x within which the body lies in that picture: beyond are its neighbours."""


def learn(runs: Sequence[Sequence[Frame]], seed: Seed, tilt_deg: float) -> Body | None:
    """Learn a body from runs of frames, given its box in one of them.

    Returns None if it cannot be found again, or shows no outline.
    """
    frame = seed.frame
    left, top, right, bottom = (round(edge) for edge in seed.box)
    shape = (bottom - top, right - left)
    pictures = {seen.index: seen.luma for run in runs for seen in run}
    sprite = make_sprite(look(pictures[frame], left, top, shape), np.ones(shape, dtype=np.float32))
    start, outline = (float(left), float(top)), None
    for _ in range(ROUNDS):
        places = _find_everywhere(runs, sprite, (frame, start), tilt_deg)
        if len(places) < 4:
            return None
        margin = round(SURROUNDINGS * shape[0])
        mean = _average(pictures, places, sprite.shape, margin)
        first = places[frame][0] - margin
        fence = (seed.fence[0] - first, seed.fence[1] - first)
        outline = _outline(mean, margin, fence)
        if outline is None:
            return None
        sprite, moved = outline.sprite, outline.moved
        start = (places[frame][0] + moved[0], places[frame][1] + moved[1])
    places = _find_everywhere(runs, sprite, (frame, start), tilt_deg)
    if outline is None or len(places) < 4:
        return None
    typical = float(np.median([place[2] for place in places.values()]))
    places = {i: place for i, place in places.items() if place[2] > AGREEMENT_SHARE * typical}
    return Body(
        sprite=sprite,
        left_edge_px=outline.left_px,
        right_edge_px=outline.right_px,
        sightings={index: place[:2] for index, place in places.items()},
        typical_agreement=typical,
    )


def _find_everywhere(
    runs: Sequence[Sequence[Frame]],
    sprite: Sprite,
    known: tuple[int, tuple[float, float]],
    tilt_deg: float,
) -> dict[int, tuple[float, float, float]]:
    """Places (x, y, agreement) of the sprite, by frame index, wherever it agrees."""
    frame, (x, y) = known
    runs = [_thinned(run, frame) for run in runs]
    slope = float(np.tan(np.radians(tilt_deg)))
    found: dict[int, tuple[float, float, float]] = {}
    for run in runs:
        guess: tuple[float, float] | None = None
        order = list(run)
        if any(seen.index == frame for seen in run):
            order.sort(key=lambda seen: abs(seen.index - frame))
            guess = (x, y)
        for seen in order:
            if guess is None:
                guess = search(seen.luma, sprite, (x, y), slope)
            if guess is None:
                continue
            fit = register(seen.luma, sprite, guess)
            if fit is None or fit.agreement < AGREEMENT_AT_LEAST or fit.inside < 0.7:
                guess = None
                continue
            guess = (fit.x_px, fit.y_px)
            found[seen.index] = (fit.x_px, fit.y_px, fit.agreement)
    return found


def _thinned(run: Sequence[Frame], keep: int) -> list[Frame]:
    """Take some frames of a run, spread over it: neighbours show almost the same."""
    step = max(1, round((len(run) - 1) / (FRAMES_OF_A_RUN - 1)))
    return [seen for place, seen in enumerate(run) if place % step == 0 or seen.index == keep]


def _spread(places: dict[int, tuple[float, float, float]]) -> list[int]:
    """Choose frames whose places are spread evenly: a body that rests would smear nothing."""
    chosen: list[int] = []
    taken: dict[int, int] = {}
    for index in sorted(places, key=lambda index: -places[index][2]):
        bin_ = round(places[index][0] / PLACE_BIN_PX)
        if taken.get(bin_, 0) < FRAMES_OF_A_PLACE:
            taken[bin_] = taken.get(bin_, 0) + 1
            chosen.append(index)
    return chosen


def _average(
    pictures: dict[int, NDArray[np.uint8]],
    places: dict[int, tuple[float, float, float]],
    shape: tuple[int, int],
    margin: int,
) -> _Mean:
    """Mean and variances of the surroundings of the sprite, over places spread evenly."""
    used = _spread(places)
    size = (shape[0], shape[1] + 2 * margin)
    corners = [(places[index][0] - margin, places[index][1]) for index in used]
    pieces = np.array(
        [look(pictures[index], *corner, size) for index, corner in zip(used, corners, strict=True)]
    )
    # Lamps flicker: every piece is brought to the common mean brightness first.
    level = np.median(pieces, axis=(1, 2))
    pieces *= (np.median(level) / (level + 1e-6))[:, None, None]
    return _Mean(pieces.mean(axis=0), pieces.var(axis=0) + NOISE_FLOOR)


@dataclass(frozen=True)
class _Outline:
    sprite: Sprite
    left_px: float
    right_px: float
    moved: tuple[float, float]
    """From the old sprite's top left pixel to the new one's."""


def _outline(mean: _Mean, margin: int, fence: tuple[float, float]) -> _Outline | None:
    """Trim the mean to the body and weight its pixels; None if there is no outline."""
    slope = np.gradient(mean.appearance)[1]
    clarity = np.abs(slope) / np.sqrt(mean.variance)
    columns = np.arange(clarity.shape[1])
    clarity[:, (columns < fence[0]) | (columns > fence[1])] = 0
    body = _own_edges(clarity)
    rows = np.flatnonzero(body.sum(axis=1) >= 3)
    if len(rows) < 8:
        return None
    left = np.array([np.flatnonzero(body[row])[0] for row in rows])
    right = np.array([np.flatnonzero(body[row])[-1] for row in rows])
    mask = np.zeros_like(body)
    for row, begin, end in zip(rows, left, right, strict=True):
        mask[row, max(0, begin - BEYOND_OUTLINE_PX) : end + BEYOND_OUTLINE_PX + 1] = True
    columns = np.flatnonzero(mask.any(axis=0))
    begin, end = int(columns[0]), int(columns[-1]) + 1
    weight = np.where(mask, 1 / mean.variance, 0)[:, begin:end]
    sprite = make_sprite(mean.appearance[:, begin:end], weight.astype(np.float32))
    return _Outline(
        sprite,
        _edge(slope, rows, left, 1) - begin,
        _edge(slope, rows, right, -1) - begin,
        (float(begin - margin), 0.0),
    )


def _own_edges(clarity: Pixels) -> NDArray[np.bool_]:
    """Pixels of the body's own edges.

    Edges come in pieces: a long plain body shows its two ends and nothing between them, a ball two
    arcs and its ring. A piece counts if it is tall enough to be part of an outline.
    """
    possible = (cv2.blur(clarity, (3, 3)) > EDGE_POSSIBLE).astype(np.uint8)
    bridge = max(3, clarity.shape[0] // 6) | 1
    joined = cv2.morphologyEx(possible, cv2.MORPH_CLOSE, np.ones((bridge, bridge), np.uint8))
    _, labels = cv2.connectedComponents(joined)
    own = possible > 0
    worth = np.bincount(labels[own], weights=clarity[own], minlength=int(labels.max()) + 1)
    pieces = [
        label
        for label in np.flatnonzero(worth > PIECE_SHARE * worth.max())
        if (own & (labels == label)).any(axis=1).sum() > PIECE_HEIGHT * clarity.shape[0]
    ]
    return np.asarray(own & np.isin(labels, pieces), dtype=bool)


def _edge(slope: Pixels, rows: NDArray[np.intp], ends: NDArray[np.intp], inward: int) -> float:
    """Find the outermost point of one side of the outline, to about half a pixel.

    In every row the edge is the steepest place within a few pixels of the mask's end; the
    outermost one is taken as a quantile over the rows, which a stray row does not move.
    """
    steepest = []
    for row, end in zip(rows, ends, strict=True):
        begin, stop = sorted((end - 3 * inward, end + 4 * inward))
        begin, stop = max(begin, 0), min(stop + 1, slope.shape[1])
        steepest.append(begin + int(np.argmax(np.abs(slope[row, begin:stop]))))
    return float(np.quantile(steepest, 0.1 if inward > 0 else 0.9))

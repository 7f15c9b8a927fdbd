"""Find a body that is known a little all over a clip: its sightings, picture by picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.records import Frame
from count_video.tracking.looks.outline import Outline
from count_video.tracking.looks.register import Fit, register
from count_video.tracking.looks.search import search
from count_video.tracking.looks.sprite import Sprite

Box = tuple[float, float, float, float]
"""Left, top, right, bottom in px."""
AGREEMENT_AT_LEAST = 0.5
"""Correlation below which a piece is not taken for the body."""
AGREEMENT_SHARE = 0.9
"""Sightings that agree less than this share of the median are dropped."""
INSIDE_AT_LEAST = 0.7
"""Share of the sprite that must lie within a picture to learn from it."""
FRAMES_OF_A_RUN = 4
"""Of a run of frames only so many are used: neighbours show almost the same."""


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
class Sketch:
    """A body as far as it is known."""

    seed: Seed
    sprite: Sprite
    start: tuple[float, float]
    """Place of the sprite's top left pixel in the seed's picture."""
    outline: Outline | None = None


@dataclass(frozen=True)
class Place:
    """A sighting: the sprite's top left pixel, and how well it agrees there."""

    x_px: float
    y_px: float
    agreement: float


def find_everywhere(
    runs: Sequence[Sequence[Frame]], sketch: Sketch, tilt_deg: float
) -> dict[int, Place]:
    """Places of the sprite, by frame index, wherever it agrees."""
    slope = float(np.tan(np.radians(tilt_deg)))
    frame = sketch.seed.frame
    found: dict[int, Place] = {}
    for run in (_thinned(run, frame) for run in runs):
        path = _Path()
        order = list(run)
        if any(seen.index == frame for seen in run):
            order.sort(key=lambda seen: abs(seen.index - frame))
            path = _Path(frame, sketch.start, sketch.seed.speed_px_frame)
        for seen in order:
            fit = _find(
                seen.luma, sketch, path.at(seen.index, slope), slope, typical_agreement(found)
            )
            if fit is None:
                path = _Path()
                continue
            path = path.onward(seen.index, (fit.x_px, fit.y_px))
            found[seen.index] = Place(fit.x_px, fit.y_px, fit.agreement)
    return _agreeing(found)


def _find(
    picture: NDArray[np.uint8],
    sketch: Sketch,
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


def typical_agreement(places: dict[int, Place]) -> float:
    """Median agreement; 0 of none."""
    return float(np.median([place.agreement for place in places.values()])) if places else 0.0


def _agreeing(places: dict[int, Place]) -> dict[int, Place]:
    """Drop sightings that agree clearly less than most: the body was hidden, or it is another."""
    least = AGREEMENT_SHARE * typical_agreement(places)
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

"""One body's motion along a line: where it is, how noisy that is, and what usually pulls it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.signals import MEDIAN_TO_SIGMA, low_points, noise_px, running_median

MIDDLE_NOISE_PX = 0.1
"""The middle of a body is known no better than this."""
HYSTERESIS_SIGMAS = 3.0
"""What is no more than noise has no turn, and lies at no stop."""
STEP_SHARE = 0.2
"""Step of the differences that give the acceleration, as a share of the time between turns."""
PULL_SHARE = 0.1
"""An acceleration is known to this share of itself: lenses, slopes, the air."""
LAW_SIGMAS, LAW_SHARE = 3.0, 0.03
"""A free flight strays from its law by less than this: noise, or a share of its extent (RMS)."""


@dataclass(frozen=True)
class Motion:
    """Places of one body along one direction; arrays have shape (n,)."""

    frame: Floats
    """Frame coordinates in pictures, increasing."""
    place_px: Floats
    """NaN where not seen."""
    acceleration: float
    """The usual one, in px per picture squared."""
    acceleration_spread: float
    """How far the accelerations of the clip scatter about it: half of them lie within."""
    sigma_px: float
    """Noise of one place."""
    friction: float = 0.0
    """How much smaller the acceleration is on the way to larger places than on the way back; not of
    a gap of two, which either may open or close."""

    @cached_property
    def middle_px(self) -> float:
        """Mean place."""
        return float(np.nanmean(self.place_px))

    @cached_property
    def way_px(self) -> float:
        """How far it comes."""
        return float(np.nanmax(self.place_px) - np.nanmin(self.place_px)) + self.sigma_px

    @cached_property
    def moving(self) -> NDArray[np.bool_]:
        """Which pictures show the body, but for its rest at both ends of the clip."""
        seen = np.isfinite(self.place_px)
        rows = np.flatnonzero(seen)
        if len(rows) == 0:
            return seen
        place, depth = self.place_px[rows], HYSTERESIS_SIGMAS * self.sigma_px
        away = np.abs(place[::-1] - place[-1]) > depth  # small last bounces are no rest
        after = int(np.argmax(away)) if away.any() else len(rows)
        for rest, ordered in ((_rest_before(place, depth), rows), (after, rows[::-1])):
            if rest > REST_PICTURES:
                seen[ordered[: rest - 1]] = False
        return seen

    @cached_property
    def speed(self) -> float:
        """How fast it moves at most, in px per picture; misplaced pictures aside."""
        rows = np.flatnonzero(self.moving)  # a body may rest for all of the clip but a few pictures
        steps = np.abs(np.diff(self.place_px[rows])) / np.diff(self.frame[rows])
        return (float(np.quantile(steps, 0.95)) if len(steps) else 0.0) + self.sigma_px

    @cached_property
    def acceleration_sigma(self) -> float:
        """Standard deviation of the acceleration from flight to flight."""
        spread = min(self.acceleration_spread, self.speed) * MEDIAN_TO_SIGMA
        share = PULL_SHARE * self.acceleration
        return float(np.hypot(np.hypot(spread, share), self.sigma_px / STILL_PICTURES**2))

    @cached_property
    def swing_sigma(self) -> float:
        """Standard deviation of w^2 in (radians per picture) squared.

        A swing is no faster than the accelerations of the clip differ over the body's way.
        """
        return 2 * self.acceleration_sigma / (float(np.nanstd(self.place_px)) + self.sigma_px)


REST_PICTURES = 6
"""A body rests that does not move for longer."""
STILL_PICTURES = 10.0
"""A flight over so many pictures shows its acceleration to the noise of one place."""


def _rest_before(place_px: Floats, depth_px: float) -> int:
    """How many pictures a path, shape (n,), lasts before it gets so far from where it rests.

    Noise leads one place of hundreds as far, but hardly the median of five. Where it rests the
    first pictures say roughly, and then all of its rest.
    """
    path, rest = running_median(place_px), REST_PICTURES
    for _ in range(2):
        away = np.abs(path[REST_PICTURES:] - np.median(path[:rest])) > depth_px
        rest = REST_PICTURES + int(np.argmax(away)) if away.any() else len(path)
    return rest


def motion_of(
    frame: Floats, place_px: Floats, noise_at_least_px: float = MIDDLE_NOISE_PX
) -> Motion:
    """Measure acceleration and noise of a path, shape (n,), in pictures and px."""
    sigma_px = max(noise_px(place_px), noise_at_least_px)
    return Motion(frame, place_px, *usual_acceleration(frame, place_px), sigma_px)


def usual_acceleration(frame: Floats, place_px: Floats) -> tuple[float, float]:
    """Median of the second differences over a few pictures, and half the range of their quartiles.

    Corners are too few to matter. Each difference counts by the speed at which the body moves
    there, so that rest says nothing. Over one picture noise, and places that are whole px, hide a
    small acceleration; over more they do not.
    """
    second, way, step = _second_differences(frame, place_px)
    if not np.abs(way).sum() > 0:
        return 0.0, np.inf
    low, middle, high = (_quartiles(second, np.abs(way)) / step**2).tolist()
    return middle, (high - low) / 2


def friction_of(frame: Floats, place_px: Floats) -> float:
    """Acceleration on the way back less that on the way to larger places; at least 0.

    Friction turns round with the body; a fall and a swing are the same both ways.
    """
    second, way, step = _second_differences(frame, place_px)
    there, back = (np.maximum(sign * way, 0.0) for sign in (1, -1))
    if not (there.any() and back.any()):
        return 0.0
    differ = _quartiles(second, back)[1] - _quartiles(second, there)[1]
    return max(0.0, float(differ) / step**2)


def _second_differences(frame: Floats, place_px: Floats) -> tuple[Floats, Floats, int]:
    """Second differences over some pictures, how far the body gets meanwhile, and their step."""
    step = max(1, round(STEP_SHARE * _between_turns(frame, place_px)))
    far = 2 * step
    second = place_px[far:] - 2 * place_px[step:-step] + place_px[:-far]
    even = np.isfinite(second) & (np.abs(frame[far:] - frame[:-far] - far) < 0.5)
    return second[even], (place_px[far:] - place_px[:-far])[even], step


def _quartiles(values: Floats, weights: Floats) -> Floats:
    """Quartiles of values, each of which counts by its weight."""
    order = np.argsort(values)
    share = np.cumsum(weights[order]) / float(weights.sum())
    return np.asarray(
        values[order][np.searchsorted(share, [0.25, 0.5, 0.75]).clip(max=len(order) - 1)]
    )


def _between_turns(frame: Floats, place_px: Floats) -> float:
    """Median time in pictures between turns of a path, of whatever sort; 0 for fewer than two."""
    depth = HYSTERESIS_SIGMAS * max(noise_px(place_px), MIDDLE_NOISE_PX)
    turns = np.sort(np.concatenate([low_points(sign * place_px, depth) for sign in (1, -1)]))
    return float(np.median(np.diff(frame[turns]))) if len(turns) > 1 else 0.0

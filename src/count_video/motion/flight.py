"""One body's motion seen from a frame of reference that falls along with it.

Between impacts a body that is thrown, or slides down an incline, has one constant acceleration: its
path bends, and turns round smoothly where no contact is. With half that acceleration times the time
squared taken off, flights become straight lines, whatever their height, and only impacts are left
as corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.signals import low_points

Rows = NDArray[np.intp]

STRAY_SHARE = 0.03
"""A free flight strays from its parabola by less than this share of its extent (RMS); half a swing
of a pendulum or a spring strays by 4 %, as it holds no parabola."""
STRAY_SIGMAS = 3.0
QUARTILE = 0.3186
"""Lower quartile of a standard normal value without its sign."""
NOISE_AT_LEAST_PX = 0.1
"""The centre of a patch is known no better than this."""
STEP_SHARE = 0.2
"""Step of the differences that give the acceleration, as a share of the time between turns."""
TURN_SIGMAS = 3.0
POINTS_FOR_BEND = 5
POINTS_AT_LEAST = 3


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

    @property
    def levelled_px(self) -> Floats:
        """Places seen from the falling frame of reference, in which flights are straight."""
        clock = self.frame - self.frame[0]
        return np.asarray(self.place_px - self.acceleration * clock**2 / 2)


def motion_of(frame: Floats, place_px: Floats) -> Motion:
    """Measure acceleration and noise of a path, shape (n,), in pictures and px."""
    return Motion(frame, place_px, *usual_acceleration(frame, place_px), _noise_px(place_px))


def _noise_px(place_px: Floats) -> float:
    """Estimate the noise of one place from third differences, as ``signals.noise_px`` does.

    The lower quartile gives it: short flights leave fewer than half of them clear of corners.
    """
    third = np.diff(place_px, n=3)
    third = third[np.isfinite(third)]
    if len(third) == 0:
        return NOISE_AT_LEAST_PX
    spread = float(np.quantile(np.abs(third), 0.25)) / QUARTILE / float(np.sqrt(20.0))
    return max(spread, NOISE_AT_LEAST_PX)


def usual_acceleration(frame: Floats, place_px: Floats) -> tuple[float, float]:
    """Median of the second differences over a few pictures, and half the range of their quartiles.

    Corners are too few to matter. Each difference counts by the speed at which the body moves
    there, so that rest says nothing. Over one picture noise, and places that are whole px, hide a
    small acceleration; over more they do not.
    """
    step = max(1, round(STEP_SHARE * _between_turns(frame, place_px)))
    far = 2 * step
    second = place_px[far:] - 2 * place_px[step:-step] + place_px[:-far]
    speed = np.abs(place_px[far:] - place_px[:-far])
    even = np.isfinite(second) & (np.abs(frame[far:] - frame[:-far] - far) < 0.5)
    if not even.any() or float(speed[even].sum()) == 0.0:
        return 0.0, np.inf
    order = np.argsort(second[even])
    share = np.cumsum(speed[even][order]) / float(speed[even].sum())
    quartiles = np.searchsorted(share, [0.25, 0.5, 0.75]).clip(max=len(order) - 1)
    low, middle, high = (second[even][order][quartiles] / step**2).tolist()
    return middle, (high - low) / 2


def _between_turns(frame: Floats, place_px: Floats) -> float:
    """Median time in pictures between turns of a path, of whatever sort; 0 for fewer than two."""
    depth = TURN_SIGMAS * _noise_px(place_px)
    turns = np.sort(np.concatenate([low_points(sign * place_px, depth) for sign in (1, -1)]))
    return float(np.median(np.diff(frame[turns]))) if len(turns) > 1 else 0.0


def flies_freely(motion: Motion, rows: Rows) -> bool:
    """Whether one parabola describes the places in these rows within their errors."""
    if len(rows) <= POINTS_AT_LEAST:
        return True
    time, places = motion.frame[rows], motion.levelled_px[rows]
    order = 2 if len(time) >= POINTS_FOR_BEND else 1
    flight = np.polynomial.Polynomial.fit(time, places, order)
    freedom = max(len(time) - order - 1, 1)
    stray = float(np.sqrt(np.sum((places - flight(time)) ** 2) / freedom))
    extent = float(np.ptp(motion.place_px[rows]))
    return stray <= max(STRAY_SIGMAS * motion.sigma_px, STRAY_SHARE * extent)


def straying(motion: Motion, impacts: Sequence[float], contact: float) -> list[tuple[float, float]]:
    """Flights between neighbouring impacts that are not those of a free body.

    ``contact`` is half the time in pictures that a contact takes; flights are judged clear of it.
    """
    seen = np.isfinite(motion.place_px)
    flights = []
    for low, high in pairwise(impacts):
        inside = (motion.frame > low + contact) & (motion.frame < high - contact)
        if not flies_freely(motion, np.flatnonzero(inside & seen)):
            flights.append((low, high))
    return flights

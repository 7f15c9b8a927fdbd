"""Paths of bodies that bounce, swing and fly, with their impacts known exactly."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from count_video.records import BodyTrack, Floats, MotionLine, Track

SIZE_PX = 40.0


def bouncing(flights: list[float], pull: float, drop: float) -> tuple[Floats, list[float]]:
    """Heights (down is positive) of a body dropped on a floor at 300 px, and its impacts.

    ``flights`` are the frames from one impact to the next, ``pull`` px per frame squared, ``drop``
    the frames of the first fall.
    """
    impacts = [drop, *(drop + np.cumsum(flights)).tolist()]
    frame = np.arange(int(impacts[-1]))
    height = pull / 2 * (drop**2 - frame**2.0)
    for begin, end in pairwise(impacts):
        inside = (frame >= begin) & (frame < end)
        height[inside] = pull / 2 * (frame[inside] - begin) * (end - frame[inside])
    return 300.0 - height, impacts[:-1]


def between_stops(speed: float, width: float, frames: int) -> tuple[Floats, list[float]]:
    """Places of a body that goes to and fro between stops at 0 and ``width`` without a loss."""
    way = speed * np.arange(frames) + width / 3
    impacts = (np.arange(1, int(way[-1] // width) + 1) * width - width / 3) / speed
    return width - np.abs(way % (2 * width) - width), impacts.tolist()


def rolling(speed: float, width: float, friction: float, kept: float) -> tuple[Floats, list[float]]:
    """Four impacts between two stops; friction slows the body down, which starts at the middle."""
    time, velocity, begin = 0.0, speed, width / 2
    pieces, impacts = [], []
    for flight in range(4):
        way = width / 2 if flight == 0 else width
        lasts = (abs(velocity) - np.sqrt(velocity**2 - 2 * friction * way)) / friction
        pieces.append((time, begin, velocity))
        time, begin = time + lasts, width if velocity > 0 else 0.0
        impacts.append(time)
        velocity = -kept * np.sign(velocity) * (abs(velocity) - friction * lasts)
    pieces.append((time, begin, velocity))
    frame = np.arange(time + 40.0)
    place = np.empty_like(frame)
    for at, where, fast in pieces:
        since = frame - at
        rolled = where + fast * since - np.sign(fast) * friction * since**2 / 2
        place[since >= 0] = rolled[since >= 0]
    return place, impacts


def noisy(place: Floats, sigma: float, seed: int = 0) -> Floats:
    """Add white noise."""
    return place + np.random.default_rng(seed).normal(0.0, sigma, len(place))


def body(place: Floats) -> BodyTrack:
    """One body of a fixed size."""
    return BodyTrack(place, np.full(len(place), 0.1), -SIZE_PX / 2, SIZE_PX / 2)


def alone(place: Floats, pace: float = 1.0) -> Track:
    """Track of one body alone."""
    line = MotionLine(0.0, 0.0, 0.0, upright=False)
    frame = pace * np.arange(len(place), dtype=np.float64)
    return Track(frame, body(place), None, "left", SIZE_PX, line, ())


def pair(left: Floats, right: Floats) -> Track:
    """Track of two bodies; the second's reference point is its face turned to the first."""
    one = alone(left)
    heavy = BodyTrack(right - SIZE_PX / 2, one.ball.sigma_px, 0.0, SIZE_PX)
    return Track(one.frame, one.ball, heavy, "left", SIZE_PX, one.line, ())

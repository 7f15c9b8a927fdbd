r"""Tell whether the heavy body turned round between two collisions, be it by ever so little.

    heavy           .-^-.
      away       .-'     '        velocity > 0 at the left end, < 0 at the right one:
              .-'         \       it has turned by itself before the ball struck it
             1             2

The paths' low and high points tell a turn once it is as deep as the noise. One that ends at a
contact may be a hundredth of a pixel deep, and still it is where the burst ends; the velocities at
both ends of the flight know better. They are those of one fit to the whole flight, along which the
body swings, x'' = -w^2 (x - x0), with the rate w that its path through all collisions tells. Where
even they leave it open, the velocity over its uncertainty is the chance of either.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from count_video.motion.gaps import Gaps
from count_video.motion.onesided import BENT_FROM, HALF_EXPOSURE
from count_video.motion.swing import CORRELATED_FRAMES, Swing
from count_video.records import Collision, Floats
from count_video.signals import sigma_of

SIGMAS = 4.0
"""A velocity or a change of it counts from this many standard uncertainties on."""


LASTING_PX = 0.05
"""Errors of places that last a flight: reflections, shading, encoders; a few hundredths of a px."""
LASTING_SLOPE = 12.0
"""Slope at the end of a flight of one frame that hides in an error of one px: that of the third
Legendre polynomial, the first one that a swing with a free centre does not take up."""


@dataclass(frozen=True)
class Turning:
    """Where the heavy body, driven back, turns round by itself between two collisions."""

    before: float
    """Frame of the collision before which it has turned; inf where there is none."""
    open_before: float
    """Frame of an earlier collision before which it may have turned; inf where there is none."""
    chance: float
    """Probability that it has not turned before that one; 1 where there is none."""


def first_turn(collisions: Sequence[Collision], gaps: Gaps, swing: Swing | None) -> Turning:
    """Find where the heavy body, driven back, turns round between two collisions.

    ``swing`` is its path through all of them, as far as it is known.
    """
    open_before, chance = np.inf, 1.0
    for before, after in pairwise(collisions):
        first, last = _velocities(gaps, (before.frame, after.frame), swing)
        slowed = first.value - last.value > SIGMAS * np.hypot(first.sigma, last.sigma)
        if first.value < SIGMAS * first.sigma or not slowed or last.value > SIGMAS * last.sigma:
            continue
        if last.value < -SIGMAS * last.sigma:
            return Turning(after.frame, open_before, chance)
        if np.isinf(open_before):
            open_before, chance = after.frame, _normal(last.value / last.sigma)
    return Turning(np.inf, open_before, chance)


def _normal(sigmas: float) -> float:
    """Probability that a normal variable stays below its mean plus so many standard deviations."""
    return math.erfc(-sigmas / math.sqrt(2.0)) / 2


@dataclass(frozen=True)
class _Velocity:
    """Away from the wall, in px per frame."""

    value: float
    sigma: float


_UNKNOWN = _Velocity(0.0, np.inf)


def _velocities(
    gaps: Gaps, flight: tuple[float, float], swing: Swing | None
) -> tuple[_Velocity, _Velocity]:
    """Velocities of the heavy body at both ends of a flight; unknown where it shows no bend."""
    inside = (gaps.frame > flight[0] + HALF_EXPOSURE) & (gaps.frame < flight[1] - HALF_EXPOSURE)
    inside &= np.isfinite(gaps.heavy_px)
    frame, place = gaps.frame[inside] - flight[1], gaps.heavy_px[inside]
    if len(frame) < BENT_FROM:
        return _UNKNOWN, _UNKNOWN
    ends = np.subtract(flight, flight[1])
    slowest, rate, fastest = _rates(swing)
    value, sigma = _ends(frame, place, ends, rate, sigma_of(gaps.heavy_px))
    low, high = (_ends(frame, place, ends, other)[0] for other in (slowest, fastest))
    sigma = np.hypot(np.hypot(sigma, (high - low) / 2), LASTING_SLOPE * LASTING_PX / len(frame))
    return _Velocity(float(value[0]), float(sigma[0])), _Velocity(float(value[1]), float(sigma[1]))


def _ends(
    frame: Floats, place: Floats, ends: Floats, rate: float, noise: float = 0.0
) -> tuple[Floats, Floats]:
    """Velocities at both ends of a swing at this rate, and their standard uncertainties."""
    design, slopes = _swinging(frame, rate), _slopes(ends, rate)
    inverse = np.linalg.pinv(design.T @ design)
    solution = inverse @ (design.T @ place)
    left_over = place - design @ solution
    freedom = max(len(frame) - design.shape[1], 1)
    # What is left over hangs together from frame to frame; a short flight has fewer frames for it.
    together = min(CORRELATED_FRAMES, len(frame) / design.shape[1])
    variance = together * max(noise**2, float(left_over @ left_over) / freedom)
    sigma = np.sqrt(variance * np.einsum("ij,jk,ik->i", slopes, inverse, slopes))
    return np.asarray(slopes @ solution), np.asarray(sigma)


def _rates(swing: Swing | None) -> Floats:
    """Angular rate of the swing in radians per frame, between its bounds; 0 where not clear."""
    if swing is None or swing.rate_squared < SIGMAS * swing.rate_squared_sigma:
        return np.zeros(3)
    squared = swing.rate_squared + swing.rate_squared_sigma * np.array([-1.0, 0.0, 1.0])
    return np.asarray(np.sqrt(squared))


def _swinging(time: Floats, rate: float) -> Floats:
    """Columns of a swing about an unknown centre, shape (n, 3); a parabola for a rate of 0."""
    # sin(wt)/w and (1 - cos(wt))/w^2, which stay what they are in the limit.
    half = np.sinc(rate * time / (2 * np.pi))
    return np.stack(
        [np.ones_like(time), time * np.sinc(rate * time / np.pi), (time * half) ** 2 / 2], axis=1
    )


def _slopes(time: Floats, rate: float) -> Floats:
    """Slopes of the columns, shape (n, 3)."""
    return np.stack(
        [np.zeros_like(time), np.cos(rate * time), time * np.sinc(rate * time / np.pi)], axis=1
    )

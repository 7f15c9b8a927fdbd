"""Straight or slightly bent pieces on both sides of a corner, never one across it.

A collision is instantaneous on the scale of a frame; the track is smooth before it and smooth
after it. Each side is fitted on its own and the corner lies where the two fits cross. Frames whose
exposure holds the corner (centre nearer than half a frame) show a blend of both sides and take no
part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.signals import sigma_of

HALF_EXPOSURE = 0.5
"""Frames: the longest shutter is open for the whole frame, half of it before its centre."""
WINDOW_FRAMES = 24.0
"""A side reaches this far at most: motion further away says little about the corner."""
WINDOW_PICTURES = 6.0
"""... but to so many pictures, where these come more rarely."""
BENT_FROM = 9
"""With so many points a side may be bent (gravity on the threads); below, it is straight."""
MISFIT_SIGMAS = 5.0
"""Where a bent side leaves over so many standard deviations it is no parabola: a swing of a few
dozen frames is none over all of the window. Errors that last leave over two or three."""
SMOOTH_ORDER = 4
"""A polynomial of this order leaves over so many times less of a swing, but not of a collision that
hides in the side, which is found by what is left over."""
CUT_TO_SHARE = 0.75
"""Such a side is cut to this share of its points, those next to the corner, until it is one."""


@dataclass(frozen=True)
class Side:
    """One side of a corner: a polynomial about the corner's frame."""

    value: float
    """Signal at the reference frame."""
    slope: float
    """Its slope there, per frame."""
    bend: float
    """Half its second derivative."""
    covariance: Floats
    """Of value and slope, shape (2, 2)."""
    points: int


@dataclass(frozen=True)
class Corner:
    """Where two sides meet."""

    frame: float
    frame_sigma: float
    value: float
    """Signal at the corner."""
    slope_before: float
    slope_after: float
    slope_sigma: float
    """Standard uncertainty of the jump of the slope."""
    points: tuple[int, int]
    """How many frames support each side."""

    @property
    def clarity(self) -> float:
        """Jump of the slope over its standard uncertainty."""
        return abs(self.slope_after - self.slope_before) / max(self.slope_sigma, 1e-9)


def side_of(frame: Floats, signal: Floats, about: float, limit: float) -> Side | None:
    """Select and fit one side of a corner at ``about``, as far as ``limit``; None if not shown."""
    chosen = side_frames(frame, signal, about, limit)
    return fit_side(frame[chosen], signal[chosen], about, sigma_of(signal))


def fit_side(
    frame: Floats, signal: Floats, about: float, sigma: float, *, bent: bool = True
) -> Side | None:
    """Fit one side by least squares about a reference frame; None with fewer than two points.

    Parameters
    ----------
    frame, signal
        Shape (n,), all finite.
    about
        Frame coordinate at which value and slope are wanted.
    sigma
        Standard deviation of one point.
    bent
        Whether a side with many points may be bent.
    """
    count = len(frame)
    if count < 2:
        return None
    if bent:
        near = _parabolic(frame, signal, about, sigma)
        frame, signal = frame[near], signal[near]
    order = _order(len(frame)) if bent else 1
    weights, variance = _solved(frame, signal, about, order)
    solution = weights @ signal
    # Bodies do not follow polynomials, and noise is not white: what is left over counts too.
    covariance = np.asarray(
        max(sigma**2, variance) * (weights @ weights.T)[:2, :2], dtype=np.float64
    )
    bend = float(solution[2]) if order > 1 else 0.0
    return Side(float(solution[0]), float(solution[1]), bend, covariance, len(frame))


def _order(points: int) -> int:
    return 2 if points >= BENT_FROM else 1


def _parabolic(frame: Floats, signal: Floats, about: float, sigma: float) -> NDArray[np.intp]:
    """Rows of those points next to ``about`` that lie on one parabola, or too few to be cut."""
    rows = np.argsort(np.abs(frame - about), kind="stable")
    while len(rows) > BENT_FROM:
        parabola, smooth = (
            _solved(frame[rows], signal[rows], about, order)[1] for order in (2, SMOOTH_ORDER)
        )
        if parabola <= MISFIT_SIGMAS**2 * max(sigma**2, smooth):
            break
        rows = rows[: max(BENT_FROM, int(CUT_TO_SHARE * len(rows)))]
    return np.sort(rows)


def _solved(frame: Floats, signal: Floats, about: float, order: int) -> tuple[Floats, float]:
    """Weights of the points in each coefficient, shape (order + 1, n), and the variance left."""
    design = np.vander(frame - about, order + 1, increasing=True)
    weights = np.asarray(np.linalg.pinv(design), dtype=np.float64)
    left_over = signal - design @ (weights @ signal)
    freedom = len(frame) - order - 1
    return weights, float(left_over @ left_over) / freedom if freedom > 0 else 0.0


def side_frames(
    frame: Floats,
    signal: Floats,
    corner: float,
    limit: float,
    window: float = WINDOW_FRAMES,
) -> NDArray[np.intp]:
    """Select the frames of one side: between the corner and the limit, clear of both corners.

    ``limit`` is the neighbouring corner (or -inf, inf) and tells by its sign which side is meant.
    """
    if limit < corner:
        inside = (frame < corner - HALF_EXPOSURE) & (frame > limit + HALF_EXPOSURE)
    else:
        inside = (frame > corner + HALF_EXPOSURE) & (frame < limit - HALF_EXPOSURE)
    pictures = np.abs(np.arange(len(frame)) - np.interp(corner, frame, np.arange(len(frame))))
    inside &= (np.abs(frame - corner) < window) | (pictures < WINDOW_PICTURES)
    return np.flatnonzero(inside & np.isfinite(signal))


def crossing(before: Side, after: Side, about: float) -> Corner | None:
    """Cross two sides fitted about the same frame; None where they are parallel."""
    jump = after.slope - before.slope
    offset = before.value - after.value
    if jump == 0.0:
        return None
    step = offset / jump
    # The bends shift the crossing by a second order amount: one Newton step settles it.
    bend = after.bend - before.bend
    gradient = jump + 2 * bend * step
    if gradient != 0.0:
        step -= (jump * step + bend * step**2 - offset) / gradient
    lever = np.array([1.0, step])
    variance = float(lever @ (before.covariance + after.covariance) @ lever)
    jump_sigma = float(np.sqrt(before.covariance[1, 1] + after.covariance[1, 1]))
    return Corner(
        frame=about + step,
        frame_sigma=float(np.sqrt(variance)) / abs(jump),
        value=before.value + before.slope * step + before.bend * step**2,
        slope_before=before.slope + 2 * before.bend * step,
        slope_after=after.slope + 2 * after.bend * step,
        slope_sigma=jump_sigma,
        points=(before.points, after.points),
    )

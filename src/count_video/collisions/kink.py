r"""Tell a corner of a signal from a bend.

    corner   \      /          bend   \        /
              \    /                    `.    .'
               \  /                       `--'
                \/

Around the place a cubic and a corner, J/2 |t|, are fitted together: the cubic takes what bends, and
what J is left tells the corner. The nearer the look, the less any bend matters, so windows grow
from a few frames until the corner stands clear of its uncertainty, if it ever does.
"""

from __future__ import annotations

import numpy as np

from count_video.collisions.onesided import HALF_EXPOSURE, Corner
from count_video.records import Floats
from count_video.signals import sigma_of

KINK_SIGMAS = 5.0
KINK_SHARE = 0.4
"""The corner that the joint fit leaves has at least this share of the one-sided fits' jump."""
FIRST_WINDOW_FRAMES = 4.0
LAST_WINDOW_FRAMES = 64.0
WINDOW_GROWTH = 1.5
FLIGHT_FRAMES = 12.0
"""Between neighbours nearer than this two straight flights are set against one bent path."""
BEND_PREFERRED = 16.0
"""A bent path must fit better by this much in chi squared, four standard deviations."""
BEND_POINTS = 5
POINTS_AT_LEAST = 7
"""Fewer points leave no freedom to tell a corner from a bend: then the one-sided fits stand."""


def has_kink(frame: Floats, signal: Floats, corner: Corner, limits: tuple[float, float]) -> bool:
    """Tell whether a corner found by one-sided fits is one.

    Parameters
    ----------
    frame, signal
        Shape (n,); NaN where not seen.
    corner
        The crossing of the fits on both sides.
    limits
        Frames of the neighbouring corners, which no window may reach.
    """
    if min(corner.frame - limits[0], limits[1] - corner.frame) < FLIGHT_FRAMES:
        return not _bends(frame, signal, corner, limits)
    jump = corner.slope_after - corner.slope_before
    window, judged = FIRST_WINDOW_FRAMES, False
    while window <= LAST_WINDOW_FRAMES:
        chosen = np.isfinite(signal) & (np.abs(frame - corner.frame) < window)
        chosen &= (frame > limits[0] + HALF_EXPOSURE) & (frame < limits[1] - HALF_EXPOSURE)
        chosen &= np.abs(frame - corner.frame) > HALF_EXPOSURE
        if chosen.sum() >= POINTS_AT_LEAST:
            judged = True
            found, sigma = _kink(frame[chosen] - corner.frame, signal[chosen], sigma_of(signal))
            if found > max(KINK_SIGMAS * sigma, KINK_SHARE * jump):
                return True
        window *= WINDOW_GROWTH
    return not judged


def _bends(frame: Floats, signal: Floats, corner: Corner, limits: tuple[float, float]) -> bool:
    """Whether one parabola describes short flights clearly better than two straight lines.

    A flight may be short on one side only: further away than that the long one bends as well.
    """
    chosen = np.isfinite(signal) & (np.abs(frame - corner.frame) > HALF_EXPOSURE)
    chosen &= (frame > limits[0] + HALF_EXPOSURE) & (frame < limits[1] - HALF_EXPOSURE)
    chosen &= np.abs(frame - corner.frame) < FLIGHT_FRAMES
    if chosen.sum() < BEND_POINTS:
        return False
    time, values = frame[chosen] - corner.frame, signal[chosen]
    ones = np.ones_like(time)
    bent = _misfit(np.column_stack([ones, time, time**2]), values)
    straight = _misfit(np.column_stack([ones, time, np.abs(time)]), values)
    return straight - bent > BEND_PREFERRED * sigma_of(signal) ** 2


def _misfit(design: Floats, values: Floats) -> float:
    """Sum of squares that least squares leaves."""
    solution, *_ = np.linalg.lstsq(design, values, rcond=None)
    left_over = values - design @ solution
    return float(left_over @ left_over)


def _kink(time: Floats, signal: Floats, noise: float) -> tuple[float, float]:
    """Jump of the slope at time 0 and its standard uncertainty."""
    reach = float(np.abs(time).max())
    unit = time / reach
    design = np.column_stack([np.ones_like(unit), unit, unit**2, unit**3, np.abs(unit) / 2])
    normal = design.T @ design
    if np.linalg.cond(normal) > 1e12:
        return 0.0, np.inf
    inverse = np.linalg.inv(normal)
    solution = inverse @ (design.T @ signal)
    left_over = signal - design @ solution
    freedom = max(1, len(time) - design.shape[1])
    variance = max(noise**2, float(left_over @ left_over) / freedom)
    return float(solution[4]) / reach, float(np.sqrt(variance * inverse[4, 4])) / reach

"""Tell which of the two bodies is the ball, and on which side the wall stands.

Only the ball bounces off the wall: on the side away from its neighbour it reverses with a jump of
its velocity. The heavy body reverses on its far side too, when it swings back, but smoothly.
"""

from __future__ import annotations

import numpy as np

from count_video.records import Floats, WallSide
from count_video.signals import low_points, noise_px

REVERSAL_SIGMAS = 8.0
REVERSAL_AT_LEAST_PX = 0.4
SPAN_FRAMES = 3
"""The jump is read between the mean velocities over so many frames on either side."""


def wall_side(left_px: Floats, right_px: Floats) -> WallSide | None:
    """Tell the side of the wall from the places of the left and the right body.

    Parameters
    ----------
    left_px, right_px
        Shape (n,), image position per frame, NaN where not seen.

    Returns
    -------
    str or None
        ``left`` if the left body is the ball; None if neither bounces on its far side.
    """
    left, right = far_side_jump(left_px), far_side_jump(-right_px)
    if left == right == 0.0:
        return None
    return "left" if left > right else "right"


def far_side_jump(distance_px: Floats) -> float:
    """Sum of the velocity jumps, in px per frame, at the low points of a distance."""
    depth = max(REVERSAL_AT_LEAST_PX, REVERSAL_SIGMAS * noise_px(distance_px))
    total = 0.0
    for place in low_points(distance_px, depth):
        before, after = place - SPAN_FRAMES, place + SPAN_FRAMES
        if before < 0 or after >= len(distance_px):
            continue
        jump = distance_px[after] - 2 * distance_px[place] + distance_px[before]
        total += float(np.nan_to_num(jump)) / SPAN_FRAMES
    return total

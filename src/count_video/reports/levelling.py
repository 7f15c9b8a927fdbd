"""Let the drawn circle lie on the ball across the line of motion as well.

The track follows motion along the line and measures the line's height only roughly. Place and
radius along the line being known, the height is where the circle runs along the ball's rim: there
the brightness steps from inside to outside all around, most of all at top and bottom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import map_coordinates

from count_video.records import Floats, Frame, Track
from count_video.reports.contact_frames import image_point, shift_of

FRAMES_ENOUGH = 8
REACH_DIAMETERS = 0.3
STEP_PX = 0.5
BESIDE_RIM_PX = 1.5
"""Brightness is compared this far inside and outside of the circle."""
ANGLES_DEG = np.concatenate([np.arange(40, 141, 4), np.arange(220, 321, 4)])
"""The upper and the lower arc, which a shift across the line moves off the rim."""
CLEARER = 1.3
"""The best height is believed if it is so much clearer than the typical one."""


def levelled(track: Track, frames: Sequence[Frame]) -> Track:
    """Shift the line of motion across itself so that the ball's circle lies on its rim.

    A few frames are enough; where no rim shows (the body is no ball) the track is left as it is.
    """
    radius = track.ball_diameter_px / 2
    offsets = np.arange(-REACH_DIAMETERS, REACH_DIAMETERS, STEP_PX / (2 * radius)) * 2 * radius
    clearness = np.zeros(len(offsets))
    rows = {int(index): row for row, index in enumerate(track.frame)}
    for frame in frames:
        row = rows.get(frame.index)
        if row is not None and np.isfinite(track.ball.position_px[row]):
            clearness += _rim_clearness(frame, track, row, offsets)
    best = int(np.argmax(clearness))
    if clearness[best] <= CLEARER * float(np.median(clearness)):
        return track
    line = track.line
    if line.upright:
        return replace(track, line=replace(line, anchor_x_px=line.anchor_x_px + offsets[best]))
    return replace(track, line=replace(line, anchor_y_px=line.anchor_y_px + offsets[best]))


def _rim_clearness(frame: Frame, track: Track, row: int, offsets: Floats) -> Floats:
    """Step of the brightness across the circle, for each offset across the line, shape (n,)."""
    radius = track.ball_diameter_px / 2
    angle = np.radians(ANGLES_DEG)
    middle = image_point(track.line, float(track.ball.position_px[row]), shift_of(track, row))
    along, across = middle[::-1] if track.line.upright else middle
    picture = (frame.luma.T if track.line.upright else frame.luma).astype(np.float64)

    def ring(size: float) -> Floats:
        x = np.broadcast_to(along + size * np.cos(angle), (len(offsets), len(angle)))
        y = across + offsets[:, None] + size * np.sin(angle)
        values: Floats = map_coordinates(picture, [y, x], order=1, mode="nearest")
        return values

    step = np.abs(ring(radius + BESIDE_RIM_PX) - ring(radius - BESIDE_RIM_PX))
    return np.asarray(step.mean(axis=1), np.float64)

"""Whether something stands in the way of a body that still moves when the clip ends.

Two like bodies that meet once, without a wall, move as those of a trial do whose wall is not
reached in the clip. Its end may show the difference: a face ahead, across the line of motion.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Track
from count_video.tracking.observation import Observation

LAST_PICTURES = 8
"""The velocity at the end is that of so many pictures; what stands still does so in the first and
the last of them."""
MOVES_SIZES = 0.02
"""A body that moves by less than this share of its size from picture to picture comes nowhere."""
HEIGHT_SHARE = 0.3
"""A face is sought so far above and below the line, as a share of the body's size."""
FACE_LEVELS = 4.0
ROWS_SHARE = 0.85
"""Grey levels from one side of an edge to the other, all along it, in this share of the rows."""
EDGE_PX = 2
SMOOTHING_PX = 1.0


def stands_ahead(seen: Observation, track: Track) -> bool:
    """Whether one of two bodies moves towards a face when the clip ends."""
    ways = _ways(track)
    if not ways:
        return False
    pictures = [_whole(seen, luma, track) for luma in seen.pictures[-LAST_PICTURES:]]
    if not pictures:
        return False
    return any(
        has_face(*(_strip(luma, track, way) for luma in (pictures[0], pictures[-1])))
        for way in ways
    )


def _whole(seen: Observation, luma: NDArray[np.uint8], track: Track) -> NDArray[np.uint8]:
    """Picture in px of the footage, with x along the line of motion; 0 beyond the region."""
    x, y, width, height = seen.view.region
    info = seen.view.footage.info
    whole = np.zeros((info.height_px, info.width_px), dtype=np.uint8)
    whole[y : y + height, x : x + width] = cv2.resize(luma, (width, height))
    return whole.T if track.line.upright else whole


def _ways(track: Track) -> list[tuple[float, int]]:
    """For each body that moves outward at the end: where its middle is, and in which direction."""
    if track.heavy is None or len(track.frame) < LAST_PICTURES:
        return []
    bodies = sorted((track.ball, track.heavy), key=lambda body: float(np.nanmean(body.position_px)))
    ways = []
    for body, side in zip(bodies, (-1, 1), strict=True):
        recent = body.position_px[-LAST_PICTURES:]
        rows = np.flatnonzero(np.isfinite(recent))
        if len(rows) < 2 or rows[-1] < len(recent) - 1:
            continue  # it has left the picture
        step = side * float(recent[rows[-1]] - recent[rows[0]]) / float(rows[-1] - rows[0])
        if step > MOVES_SIZES * (body.high_edge_px - body.low_edge_px):
            middle = (body.low_edge_px + body.high_edge_px) / 2
            ways.append((float(recent[-1]) + middle, side))
    return ways


def _strip(luma: NDArray[np.uint8], track: Track, way: tuple[float, int]) -> Floats:
    """Cut out what lies ahead of a body, shape (across, along), from its middle to the border."""
    begins, side = way
    line = track.line
    about, level = (
        (line.anchor_y_px, line.anchor_x_px)
        if line.upright
        else (line.anchor_x_px, line.anchor_y_px)
    )
    end = luma.shape[1] - 1.0 if side > 0 else 0.0
    along = np.arange(min(begins, end), max(begins, end))
    half = max(1.0, HEIGHT_SHARE * track.ball_diameter_px)
    across = level + np.tan(np.radians(line.tilt_deg)) * (along - about)
    if len(along) == 0 or (end - begins) * side <= 0:
        return np.zeros((1, 0))
    rows = np.arange(-half, half + 1)
    smooth = cv2.GaussianBlur(luma.astype(np.float32), (0, 0), SMOOTHING_PX)
    x = np.tile(along, (len(rows), 1)).astype(np.float32)
    y = (across[None] + rows[:, None]).astype(np.float32)
    picked = cv2.remap(np.asarray(smooth), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(picked, dtype=np.float64)


def has_face(before: Floats, after: Floats) -> bool:
    """Whether an edge goes across two strips, shape (across, along), at the same place in both.

    Those of the body itself move on from one to the other.
    """
    if before.shape[1] <= EDGE_PX:
        return False
    steps = [strip[:, EDGE_PX:] - strip[:, :-EDGE_PX] for strip in (before, after)]
    for sign in (1, -1):
        shares = (np.mean(sign * step > FACE_LEVELS, axis=0) > ROWS_SHARE for step in steps)
        if bool(np.logical_and(*shares).any()):
            return True
    return False

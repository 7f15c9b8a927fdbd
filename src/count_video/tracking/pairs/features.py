"""Small patches that move: where they are and how fast, from one short run of frames.

Corner features are followed through the run by pyramidal Lucas-Kanade registration (Bouguet 2001,
as in OpenCV) and a straight line is fitted to each path. A feature counts when it moved by more
than its own scatter and came back to its start when it was followed backwards. Nothing here asks
what a body looks like.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats, Frame
from count_video.tracking.flow import as_bytes, flow, prepare

FRAMES_AT_LEAST = 4
"""Fewer frames do not tell a steady motion from a scatter."""
FEATURES_AT_MOST = 500
CORNER_QUALITY = 0.01
FAINT_QUALITY = 0.001
"""Corners may be weaker than the strongest one by these shares; the second finds a plain body that
hardly stands out, beside one that glitters."""
CORNER_SPACING_PX = 4
RETURN_ERROR_PX = 0.5
"""Following a feature forth and back must end this near to its start."""
PATH_SCATTER_PX = 0.9
"""RMS about the straight path; a corner within the run shows as scatter and is left out."""
MOVED_AT_LEAST_PX = 0.8
MOVED_OVER_SCATTER = 3.0
ACTIVITY_OVER_NOISE = 4.0
"""A pixel is active when run start and run end differ by this many standard deviations."""


@dataclass(frozen=True)
class MovingFeatures:
    """Features of one run that move steadily; arrays have shape (n,)."""

    frame: float
    """Frame coordinate of the middle of the run, to which positions refer."""
    span_frames: float
    """From the first frame of the run to its last."""
    x_px: Floats
    y_px: Floats
    speed_x_px_frame: Floats
    speed_y_px_frame: Floats
    speed_sigma_px_frame: Floats
    """Standard uncertainty of the speeds, from the scatter about the straight path."""
    grain_px: float = 1.0
    """Errors of following count in px of the pictures that were searched: px of the footage for one
    of these where they were enlarged, else 1."""


def moving_features(
    run: Sequence[Frame], *, faint: bool = False, close: bool = False
) -> MovingFeatures:
    """Follow features through a run of consecutive frames and keep those that move steadily.

    ``faint`` takes weak corners as well, ``close`` looks at enlarged pictures.
    """
    frames = np.array([frame.index for frame in run], dtype=np.float64)
    none = np.empty(0)
    nothing = MovingFeatures(
        float(frames.mean()), float(np.ptp(frames)), none, none, none, none, none
    )
    if len(run) < FRAMES_AT_LEAST:
        return nothing
    pictures, scale = prepare([seen.luma for seen in run], close=close)
    start = cv2.goodFeaturesToTrack(
        pictures[0],
        FEATURES_AT_MOST,
        FAINT_QUALITY if faint else CORNER_QUALITY,
        CORNER_SPACING_PX,
        mask=_active(pictures[0], pictures[-1], pictures[1]),
    )
    if start is None:
        return nothing
    paths, good = _follow(pictures, np.asarray(start, dtype=np.float32))
    return _steady(frames, paths[:, good] * scale, min(scale, 1.0))


def _active(
    first: NDArray[np.uint8], last: NDArray[np.uint8], second: NDArray[np.uint8]
) -> NDArray[np.uint8]:
    """Mask of what changed over the run; the noise is judged by neighbouring frames."""
    step = second.astype(np.int16) - first
    noise = 1.4826 * float(np.median(np.abs(step - np.median(step)))) + 0.5
    change = last.astype(np.int16) - first
    change = np.abs(change - np.median(change)).astype(np.float32)
    mask = (cv2.blur(change, (3, 3)) > ACTIVITY_OVER_NOISE * noise / 2).astype(np.uint8)
    return as_bytes(cv2.dilate(mask, np.ones((5, 5), np.uint8)))


def _follow(
    pictures: Sequence[NDArray[np.uint8]], start: NDArray[np.float32]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Paths of shape (frames, features, 2), and which features came back to their start."""
    paths = [start[:, 0]]
    points, good = start, np.ones(len(start), dtype=bool)
    for before, after in pairwise(pictures):
        points, found = flow(before, after, points)
        good &= found
        paths.append(points[:, 0])
    back = points
    for before, after in pairwise(reversed(pictures)):
        back, found = flow(before, after, back)
        good &= found
    good &= np.hypot(*(back - start)[:, 0].T) < RETURN_ERROR_PX
    return np.array(paths, dtype=np.float64), good


def _steady(frames: Floats, paths: Floats, grain_px: float) -> MovingFeatures:
    """Fit each path by a straight line and keep the features that moved, and moved evenly."""
    middle = float(frames.mean())
    lever = frames - middle
    speed = np.tensordot(lever, paths, axes=1) / float(lever @ lever)
    place = paths.mean(axis=0)
    left_over = paths - place - lever[:, None, None] * speed
    scatter = np.sqrt((left_over**2).sum(axis=2).mean(axis=0))
    travel = np.hypot(*speed.T) * float(np.ptp(frames))
    keep = (scatter < PATH_SCATTER_PX * grain_px) & (travel > MOVED_AT_LEAST_PX * grain_px)
    keep &= travel > MOVED_OVER_SCATTER * scatter
    sigma = scatter / np.sqrt(float(lever @ lever))
    (x, y), (speed_x, speed_y) = place[keep].T, speed[keep].T
    span = float(np.ptp(frames))
    return MovingFeatures(middle, span, x, y, speed_x, speed_y, sigma[keep], grain_px)

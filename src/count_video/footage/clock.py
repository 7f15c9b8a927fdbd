"""Frames, footage time and real time: the one place where they are converted.

A frame coordinate k (a float; the integer is the centre of the exposure of frame k) happened at
real time k / capture rate. Footage time is what the container says of each frame; with a variable
playing rate it is no multiple of anything, so it is read off the time stamps.
"""

from __future__ import annotations

import numpy as np

from count_video.records import Floats


def real_time_s(frame: float, capture_fps: float) -> float:
    """Return seconds of real time from frame 0 to a frame coordinate."""
    return frame / capture_fps


def frame_at_real_time(time_s: float, capture_fps: float) -> float:
    """Return the frame coordinate at a real time counted from frame 0."""
    return time_s * capture_fps


def footage_time_s(frame: float, time_stamps_s: Floats) -> float:
    """Return the footage time at a frame coordinate, linear from frame to frame.

    Parameters
    ----------
    frame
        Frame coordinate.
    time_stamps_s
        Footage time of every frame from frame 0, shape (n,); NaN where the container has none.

    Returns
    -------
    float
        Seconds; NaN outside the clip.
    """
    known = np.flatnonzero(np.isfinite(time_stamps_s))
    if known.size == 0:
        return float("nan")
    return float(np.interp(frame, known, time_stamps_s[known], left=np.nan, right=np.nan))


def frame_at_footage_time(time_s: float, time_stamps_s: Floats) -> float:
    """Return the frame coordinate at a footage time; the inverse of :func:`footage_time_s`."""
    known = np.flatnonzero(np.isfinite(time_stamps_s))
    if known.size == 0:
        return float("nan")
    return float(np.interp(time_s, time_stamps_s[known], known, left=np.nan, right=np.nan))

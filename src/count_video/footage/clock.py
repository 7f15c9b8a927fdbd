"""Frames, footage time and real time: the one place where they are converted.

A frame coordinate k (a float; the integer is the centre of the exposure of frame k) happened at
real time k / capture rate. Footage time is what the container says of each frame; with a variable
playing rate it is no multiple of anything, so it is read off the time stamps.
"""

from __future__ import annotations


def real_time_s(frame: float, capture_fps: float) -> float:
    """Return seconds of real time from frame 0 to a frame coordinate."""
    return frame / capture_fps

"""Frames and pictures: a converted clip repeats pictures, and only new ones show anything.

Where every picture comes twice, the camera's exposure and the shortest interval that it resolves
span two frames. The search for collisions therefore counts in pictures, and what it finds is told
in frames.
"""

from __future__ import annotations

from dataclasses import astuple, replace

import numpy as np

from count_video.motion.swing import Swing
from count_video.records import Collision, Track, Velocities


def frames_per_picture(track: Track) -> float:
    """Usual number of frames from one new picture to the next; 1 for footage as it was filmed."""
    if len(track.frame) < 2:
        return 1.0
    return float(np.median(np.diff(track.frame)))


def in_pictures(track: Track, pace: float) -> Track:
    """Count the track's frames in pictures."""
    return track if pace == 1.0 else replace(track, frame=track.frame / pace)


def in_frames(collision: Collision, pace: float) -> Collision:
    """Tell a collision that was found in pictures in frames."""
    return replace(
        collision,
        frame=collision.frame * pace,
        frame_sigma=collision.frame_sigma * pace,
        velocity_before=_slowed(collision.velocity_before, pace),
        velocity_after=_slowed(collision.velocity_after, pace),
    )


def _slowed(velocities: Velocities, pace: float) -> Velocities:
    return Velocities(*(value / pace for value in astuple(velocities)))


def swing_in_frames(swing: Swing | None, pace: float) -> Swing | None:
    """Tell a swing that was fitted in pictures in frames."""
    if swing is None:
        return None
    return replace(
        swing,
        rate_squared=swing.rate_squared / pace**2,
        rate_squared_sigma=swing.rate_squared_sigma / pace**2,
    )

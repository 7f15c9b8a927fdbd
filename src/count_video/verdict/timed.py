"""Times of collisions, where the camera's rate is known."""

from __future__ import annotations

from dataclasses import replace

from count_video.footage.clock import real_time_s
from count_video.records import Collision


def timed(collision: Collision, capture_fps: float | None) -> Collision:
    """Add the time since the clip's start in seconds, where the camera's rate is known."""
    if capture_fps is None:
        return collision
    return replace(collision, time_s=real_time_s(collision.frame, capture_fps))

"""The impacts that a clip of one body alone shows, or of two that meet nothing but each other."""

from __future__ import annotations

import numpy as np

from count_video.collisions.flight import motion_of
from count_video.collisions.impacts import Impact, find_impacts
from count_video.collisions.meeting import seen_meetings
from count_video.collisions.pace import frames_per_picture, in_frames, in_pictures
from count_video.collisions.weighing import SeenImpacts, weighed
from count_video.records import Collision, Track, Velocities


def seen_impacts(track: Track) -> SeenImpacts:
    """Find the impacts of one body alone (kind ``wall``), or of two on each other (``bodies``)."""
    pace = frames_per_picture(track)
    slow = in_pictures(track, pace)
    if slow.heavy is not None:
        return seen_meetings(slow, slow.heavy, pace)
    motion = motion_of(slow.frame, slow.ball.position_px)
    impacts, contact = find_impacts(motion)
    collisions = [
        in_frames(_collision(number, impact), pace) for number, impact in enumerate(impacts, 1)
    ]
    return weighed(motion, impacts, (contact, pace), collisions)


def _collision(number: int, impact: Impact) -> Collision:
    return Collision(
        number=number,
        kind="wall",
        frame=impact.frame,
        frame_sigma=impact.frame_sigma,
        time_s=None,
        seen=True,
        position_px=impact.place_px,
        velocity_before=Velocities(impact.velocity_before, np.nan),
        velocity_after=Velocities(impact.velocity_after, np.nan),
    )

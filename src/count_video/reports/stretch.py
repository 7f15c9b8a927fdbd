"""Which frames and places a picture shows."""

from __future__ import annotations

import numpy as np

from count_video.reports.material import Material, ball_edges_px

Range = tuple[float, float]
CROWD_SHARE = 0.6
"""The enlarged stretch is the shortest that holds this share of the burst."""
MARGIN_SHARE = 0.06
"""Of a stretch of frames, shown on either side of it."""
ROOM_DIAMETERS = 0.35
"""Shown beyond the ball's path, towards the wall and towards the heavy body."""


def shown_frames(material: Material) -> Range:
    """First and last frame of the whole picture: all collisions, or the clip without any."""
    frames = material.track.frame
    ends = (float(frames[0]), float(frames[-1]))
    collisions = material.result.collisions
    if not collisions:
        return ends
    low, high = collisions[0].frame, collisions[-1].frame
    margin = max(10.0, 2 * MARGIN_SHARE * (high - low))
    return max(ends[0], low - margin), min(ends[1], high + margin)


def crowded_frames(material: Material) -> Range:
    """Find the shortest stretch of frames that holds most of the burst."""
    times = [collision.frame for collision in material.burst]
    if len(times) < 3:
        return shown_frames(material)
    held = max(3, round(CROWD_SHARE * len(times)))
    starts = range(len(times) - held + 1)
    start = min(starts, key=lambda first: times[first + held - 1] - times[first])
    low, high = times[start], times[start + held - 1]
    margin = MARGIN_SHARE * (high - low) + 1.0
    return low - margin, high + margin


def shown_places(material: Material, frames: Range) -> Range:
    """Lowest and highest position shown: from the wall to the heavy body's face, with room."""
    track = material.track
    inside = (track.frame >= frames[0]) & (track.frame <= frames[1])
    low, high = (edge[inside] for edge in ball_edges_px(track))
    face = track.heavy.position_px[inside] if track.heavy is not None else high
    values = np.concatenate([low, high, face])
    values = values[np.isfinite(values)]
    if values.size == 0:
        return 0.0, float(material.space_time.image.shape[1])
    room = ROOM_DIAMETERS * track.ball_diameter_px
    return float(values.min()) - room, float(values.max()) + room

"""Collisions of which only kind and time are known."""

from __future__ import annotations

import numpy as np

from count_video.records import Collision, CollisionKind, Velocities


def collision(kind: CollisionKind, frame: float) -> Collision:
    unknown = Velocities(np.nan, np.nan)
    return Collision(
        kind=kind,
        frame=frame,
        frame_sigma=0.1,
        seen=True,
        position_px=0.0,
        velocity_before=unknown,
        velocity_after=unknown,
    )

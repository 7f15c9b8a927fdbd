"""Collisions of which only kind and time are known."""

from __future__ import annotations

import numpy as np

from count_video.records import Collision, CollisionKind, Velocities


def collision(kind: CollisionKind, frame: float) -> Collision:
    unknown = Velocities(np.nan, np.nan)
    return Collision(1, kind, frame, 0.1, None, True, 0.0, unknown, unknown)

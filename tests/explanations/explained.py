"""Explanations of a clip, made without one."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from count_video.explanations import Explanation
from count_video.reasons import Cause, Reason
from count_video.records import BodyTrack, Collision, CollisionKind, MotionLine, Track, Velocities

FRAMES = 40


def body() -> BodyTrack:
    return BodyTrack(np.arange(FRAMES, dtype=float), np.full(FRAMES, 0.1), -10.0, 10.0)


def track(*, wall_seen: bool) -> Track:
    line = MotionLine(0.0, 0.0, 0.0, upright=False)
    frame = np.arange(FRAMES, dtype=float)
    return Track(frame, body(), body(), "left", 20.0, line, (), wall_seen=wall_seen)


def collision(number: int, kind: CollisionKind) -> Collision:
    still = Velocities(0.0, 0.0)
    return Collision(
        kind=kind,
        frame=5.0 * number,
        frame_sigma=0.5,
        seen=True,
        position_px=0.0,
        velocity_before=still,
        velocity_after=still,
    )


def at_a_wall(*, path_shows: bool, counts: bool = False) -> Explanation:
    """A trial at a wall, counted or not; its heavy body's path fits its collisions or not."""
    kinds: list[CollisionKind] = ["bodies", "wall", "bodies", "wall"]
    shown = tuple(collision(number, kind) for number, kind in enumerate(kinds, 1))
    found: Any = SimpleNamespace(path_fits=path_shows, swing=SimpleNamespace(is_clear=True))
    against = () if counts else (Reason(Cause.STRAYS),)
    seen = track(wall_seen=True)
    return Explanation(seen, "wall", shown, len(shown), {len(shown): 1.0}, against, found=found)


def bouncing(count: int | None) -> Explanation:
    """One body alone with so many impacts, or with none."""
    one = replace(track(wall_seen=False), heavy=None)
    if count is None:
        return Explanation(one, "stop", (), 0, {}, (Reason(Cause.NO_IMPACT),))
    shown = tuple(collision(number, "wall") for number in range(1, count + 1))
    return Explanation(one, "stop", shown, count, {count: 0.9})

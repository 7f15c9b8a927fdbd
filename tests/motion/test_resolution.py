from __future__ import annotations

import numpy as np
import pytest
from made_collisions import collision

from count_video.motion.gaps import Gaps
from count_video.motion.reasons import Cause
from count_video.motion.resolution import unresolved


def swinging_back(seen: bool) -> Gaps:
    """A ball that leaves the wall, turns and comes back; the cylinder is far off, or not seen."""
    frame = np.arange(100.0)
    ball = 20.0 + 30.0 * np.abs(np.sin(np.pi * (frame - 20.0) / 60.0))
    touching = np.abs(frame - 50.0) > 45.0
    heavy = np.where(touching, ball + 20.0, 200.0 if seen else np.nan)
    zero = np.zeros(100)
    return Gaps(frame, ball, heavy, heavy - ball - 20.0, zero, zero, 1)


@pytest.mark.parametrize("seen", [True, False])
def test_a_turn_between_two_wall_collisions_counts_if_the_cylinder_is_seen_far_off(
    seen: bool,
) -> None:
    walls = [collision("wall", frame) for frame in (20.0, 80.0)]

    missing = unresolved(walls, swinging_back(seen), 1.0)

    assert all(reason.cause is Cause.BODY_MISSED for reason in missing)
    assert bool(missing) is not seen

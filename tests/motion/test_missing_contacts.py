from __future__ import annotations

import numpy as np
import pytest
from filmed_trials import Filming, film_motion, resolving_fps

from count_video.motion.seen import seen_collisions
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.signals import sigma_of
from tiers import rest_slow

TRIAL = simulate(Setup(wall_gap_m=0.03))
NOISE_PX, LEAD_FRAMES = 0.5, 20
"""With these the gap closes by three px before the first contact, six deviations of its noise are
four: no low point shows it."""
DEPTH_SIGMAS = 6.0
OFF_AT_MOST_FRAMES = 8.0
"""Lines through 20 places meet where they are known to 2 * 0.7 px / sqrt(20) over the jump of
0.16 px per frame, two frames, of which this is four times as much."""


@pytest.mark.parametrize("seed", rest_slow(range(8), 4))
def test_what_sends_a_resting_ball_to_the_wall_is_found_however_shallow(seed: int) -> None:
    filming = Filming(resolving_fps(TRIAL, 8.0), NOISE_PX, lead_frames=LEAD_FRAMES)
    trial = film_motion(TRIAL, filming, seed)
    assert trial.track.heavy is not None
    gap = trial.track.heavy.position_px - trial.track.ball.position_px
    first = int(trial.frames[0])
    closed = np.mean(gap[:3]) - np.mean(gap[first - 3 : first])
    assert closed < DEPTH_SIGMAS * sigma_of(gap)

    found = seen_collisions(trial.track).collisions[0]

    assert found.kind == "bodies"
    assert abs(found.frame - trial.frames[0]) < OFF_AT_MOST_FRAMES

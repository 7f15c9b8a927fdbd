from __future__ import annotations

from dataclasses import replace

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
JERK_PX_FRAME, JERK_FRAMES = 0.06, 10.0
"""A thread that hangs slack for some frames lets a ball at rest drift by so much, and stops it."""
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


def test_a_jerk_far_from_the_wall_is_no_contact_with_it() -> None:
    # Of equal masses the ball rests after the third collision, until the other swings back.
    setup = Setup(0.01, 0.01, wall_gap_m=0.03, restitution_bodies=0.99, restitution_wall=0.95)
    motion = simulate(setup)
    trial = film_motion(motion, Filming(240.0, NOISE_PX / 10, tail_frames=420), 1)
    last = trial.frames[2]
    drift = JERK_PX_FRAME * np.clip(trial.track.frame - last, 0.0, JERK_FRAMES)
    jerked = replace(trial.track.ball, position_px=trial.track.ball.position_px - drift)

    found = seen_collisions(replace(trial.track, ball=jerked)).collisions
    walls = [one.position_px for one in found if one.kind == "wall"]

    assert [one.kind for one in found[:4]] == ["bodies", "wall", "bodies", "bodies"]
    assert np.ptp(walls) < JERK_PX_FRAME * JERK_FRAMES + NOISE_PX

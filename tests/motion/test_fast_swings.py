"""Bodies that swing so fast that a few dozen frames are a good part of a period."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filmed_trials import Filming, film

from count_video.motion.gaps import gaps_of
from count_video.motion.seen import seen_collisions
from count_video.motion.swing import fit_swing
from count_video.physics.setup import Setup
from count_video.records import Track


def held_first(track: Track, frames: int) -> Track:
    """Let bodies rest where they are at first for some frames more, as if a hand held one."""
    assert track.heavy is not None
    bodies = [
        replace(
            body,
            position_px=np.concatenate([np.full(frames, body.position_px[0]), body.position_px]),
            sigma_px=np.concatenate([np.full(frames, body.sigma_px[0]), body.sigma_px]),
        )
        for body in (track.ball, track.heavy)
    ]
    frame = np.arange(float(len(track.frame) + frames))
    return replace(track, frame=frame, ball=bodies[0], heavy=bodies[1])


def test_the_collisions_of_a_body_that_is_held_at_first_are_confirmed() -> None:
    setup = Setup(heavy_mass_kg=0.2, light_mass_kg=0.1, wall_gap_m=0.03, release_m=0.06)
    whole = film(setup, Filming(capture_fps=60.0, lead_frames=12, tail_frames=20))
    held = held_first(whole.track, 25)

    found, alone = seen_collisions(held), seen_collisions(whole.track)

    assert alone.path_fits
    assert found.path_fits
    assert found.burst == alone.burst
    swings = [fit_swing(gaps_of(t), f.collisions) for t, f in ((held, found), (whole.track, alone))]
    assert swings[0] is not None
    assert swings[1] is not None
    # The held part takes no part: the same mass ratio comes out.
    assert swings[0].mass_ratio == pytest.approx(swings[1].mass_ratio, rel=0.02)

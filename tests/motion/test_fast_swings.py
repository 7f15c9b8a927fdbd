"""Bodies that swing so fast that a few dozen frames are a good part of a period."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filmed_trials import Filming, film

from count_video.motion.gaps import gaps_of
from count_video.motion.onesided import BENT_FROM, fit_side
from count_video.motion.seen import seen_collisions
from count_video.motion.swing import fit_path
from count_video.physics.setup import Setup
from count_video.records import Track

SIGMA_PX = 0.05
PERIOD_FRAMES = 60.0
AMPLITUDE_PX = 40.0
PHASES = np.linspace(0.0, 2 * np.pi, 12, endpoint=False)
CUBIC_SHARE = (2 * np.pi / PERIOD_FRAMES) ** 3 * AMPLITUDE_PX / 6
"""The third order of the swing at most, in px per cubic frame."""
NEAR_FRAMES = BENT_FROM + 1.0


@pytest.mark.parametrize("phase", PHASES)
def test_a_side_of_a_fast_swing_is_fitted_next_to_the_corner(phase: float) -> None:
    frame = np.arange(1.0, 24.0)
    turn = 2 * np.pi * frame / PERIOD_FRAMES + phase
    swing = AMPLITUDE_PX * np.sin(turn)

    side = fit_side(frame, swing, 0.0, SIGMA_PX)

    assert side is not None
    # Extrapolated by its third order at most over what is next to the corner, or to what the
    # points may leave over before a side is cut.
    far_off = CUBIC_SHARE * NEAR_FRAMES**3 / 10 + 5 * SIGMA_PX
    assert side.value == pytest.approx(AMPLITUDE_PX * np.sin(phase), abs=far_off)


def test_a_side_that_is_a_parabola_keeps_all_its_points() -> None:
    frame = np.arange(1.0, 24.0)
    noise = np.random.default_rng(3).normal(0.0, SIGMA_PX, len(frame))

    side = fit_side(frame, 3.0 - 2.0 * frame + 0.1 * frame**2 + noise, 0.0, SIGMA_PX)

    assert side is not None
    assert side.points == len(frame)


def test_a_side_that_hides_a_collision_keeps_all_its_points() -> None:
    frame = np.arange(1.0, 24.0)

    side = fit_side(frame, 4.0 * np.abs(frame - 12.0), 0.0, SIGMA_PX)

    assert side is not None
    assert side.points == len(frame)


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


def test_a_body_that_is_held_at_first_bears_out_its_collisions() -> None:
    setup = Setup(heavy_mass_kg=0.2, light_mass_kg=0.1, wall_gap_m=0.03, release_m=0.06)
    whole = film(setup, Filming(capture_fps=60.0, lead_frames=12, tail_frames=20))
    held = held_first(whole.track, 25)

    found, alone = seen_collisions(held), seen_collisions(whole.track)

    assert alone.borne_out
    assert found.borne_out
    assert found.burst == alone.burst
    paths = [fit_path(gaps_of(t), f.collisions) for t, f in ((held, found), (whole.track, alone))]
    assert paths[0] is not None
    assert paths[1] is not None
    # The held part takes no part: the same mass ratio comes out.
    assert paths[0].solution[4] == pytest.approx(paths[1].solution[4], rel=0.02)

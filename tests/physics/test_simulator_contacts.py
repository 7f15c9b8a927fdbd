"""Bodies that stay in contact: chatter that ends, pushing, leaning, parting."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.physics.engine import Anchor, events, settle
from count_video.physics.flights import Pendulum
from count_video.physics.setup import RESTING_FRACTION, Hold, Setup, build_apparatus
from count_video.physics.simulator import Motion, simulate

PRESSED = Setup(wall_gap_m=-0.02, bodies_gap_m=0.02)
"""The ball's thread presses it on the wall."""
LEANING = Setup(wall_gap_m=0.08, bodies_gap_m=-0.03, release_m=0.03)
"""The cylinder starts against the ball and pushes it toward the wall."""


def holds(motion: Motion) -> set[Hold]:
    return {anchor.hold for anchor in motion.anchors}


@given(st.floats(0.1, 0.95), st.floats(1e-4, 1e-2))
def test_a_bouncing_ball_rests_after_the_hops_that_the_geometric_law_allows(
    restitution: float, speed: float
) -> None:
    apparatus = build_apparatus(replace(PRESSED, bodies_gap_m=0.5))
    far_away = Anchor(0.0, 0.48, 0.0, 0.0, speed, Hold.APART)
    hops = 0
    for anchor, impact in events(apparatus, far_away, lambda kind: restitution):
        if anchor.hold is Hold.BALL_ON_WALL:
            break
        # An undamped ball comes back as fast as it left.
        assert impact is not None
        assert -impact.light_before_m_s == pytest.approx(speed * restitution**hops, rel=1e-6)
        hops += 1
    # The last hop recorded leaves with less than the resting speed or comes back with less.
    exact = math.log(apparatus.resting_speed_m_s / speed) / math.log(restitution)
    assert abs(hops - exact) <= 1.0
    assert (anchor.ball_m, anchor.ball_velocity_m_s) == (0.0, 0.0)


@given(st.floats(0.0, 0.6), st.sampled_from(["free", "floor", "suspended"]))
def test_inelastic_collapse_ends_and_leaves_the_rest_of_the_motion(
    restitution: float, mounting: str
) -> None:
    setup = Setup(
        mounting=mounting,  # type: ignore[arg-type]
        heavy_velocity_m_s=-1.0,
        restitution_bodies=restitution,
        restitution_wall=restitution,
    )
    motion = simulate(setup)
    assert holds(motion) - {Hold.APART}
    energies = [bounce.energy_after_j for bounce in motion.collisions]
    assert energies[-1] < energies[0]
    if mounting == "suspended":  # threads pull both from the wall again
        assert motion.burst_end_s < math.inf
    else:
        assert motion.anchors[-1].hold is Hold.PINNED


def test_bodies_that_do_not_rebound_travel_as_one() -> None:
    setup = Setup(mounting="free", heavy_velocity_m_s=-1.0, restitution_bodies=0.0)
    first, second = simulate(setup).collisions[:2]
    common = -setup.heavy_mass_kg / (setup.heavy_mass_kg + setup.light_mass_kg)
    assert first.heavy_after_m_s == pytest.approx(common, rel=1e-15)
    assert second.kind == "wall"
    assert second.time_s - first.time_s == pytest.approx(setup.wall_gap_m / -common)


def test_a_leaning_cylinder_and_its_ball_swing_as_one_pendulum() -> None:
    motion = simulate(LEANING)
    assert holds(motion) == {Hold.TOGETHER}
    assert motion.collisions == ()
    times = np.linspace(0.0, 2.0, 101)
    sample = motion.sample(times)
    np.testing.assert_array_equal(sample.heavy_face_m, sample.ball_near_face_m)
    # Equal threads: the common rest lies between the two, weighed by mass.
    share = LEANING.heavy_mass_kg / (LEANING.heavy_mass_kg + LEANING.light_mass_kg)
    rest_m = 0.05 * share + 0.08 * (1 - share)
    natural = math.sqrt(LEANING.gravity_m_s2)
    expected = rest_m + (0.08 - rest_m) * np.cos(natural * times)
    np.testing.assert_allclose(sample.ball_far_face_m, expected, atol=1e-15)


@given(st.floats(0.2, 0.4), st.floats(1.2, 2.0), st.floats(0.0, 0.5))
def test_bodies_part_where_the_push_between_them_ends(
    heavy_thread_m: float, light_thread_m: float, damping: float
) -> None:
    # The short thread stops the cylinder while the ball swings on.
    setup = replace(
        LEANING,
        heavy_thread_m=heavy_thread_m,
        light_thread_m=light_thread_m,
        heavy_damping_per_s=damping,
    )
    motion = simulate(setup, until_s=5.0)
    pairs = zip(motion.anchors, motion.anchors[1:], strict=False)
    partings = [
        after
        for before, after in pairs
        if before.hold is Hold.TOGETHER and after.hold is Hold.APART and after.ball_m > 0
    ]
    assert partings
    apparatus = build_apparatus(setup)
    for state in partings:
        heavy = apparatus.heavy.acceleration(state.heavy_m, state.heavy_velocity_m_s)
        light = apparatus.light.acceleration(state.ball_m, state.ball_velocity_m_s)
        assert heavy - light == pytest.approx(apparatus.resting_acceleration_m_s2, abs=1e-12)


def test_a_pressed_ball_waits_on_the_wall_for_the_cylinder() -> None:
    motion = simulate(PRESSED)
    assert motion.anchors[0].hold is Hold.BALL_ON_WALL
    first = motion.collisions[0]
    before = motion.sample(np.linspace(0.0, first.time_s, 50)[:-1])
    np.testing.assert_array_equal(before.ball_far_face_m, 0.0)
    assert (first.kind, first.light_before_m_s) == ("bodies", 0.0)


@pytest.mark.parametrize(
    ("wall_gap_m", "bodies_gap_m", "heavy_kg", "hold"),
    [
        (-0.02, -0.02, 1.0, Hold.PINNED),  # both threads press
        (0.05, -0.06, 100.0, Hold.PINNED),  # a heavy cylinder presses harder than the ball pulls
        (0.05, -0.06, 1.0, Hold.TOGETHER),  # a light one is pushed away by the ball
        (0.05, 0.0, 1.0, Hold.TOGETHER),  # both pulled away alike
        (-0.02, 0.05, 1.0, Hold.BALL_ON_WALL),  # only the cylinder is pulled away
        (0.02, 0.05, 1.0, Hold.APART),  # the cylinder is pulled away faster than the ball
    ],
)
def test_who_stays_in_contact_at_the_wall_follows_from_the_pulls(
    wall_gap_m: float, bodies_gap_m: float, heavy_kg: float, hold: Hold
) -> None:
    setup = Setup(
        heavy_mass_kg=heavy_kg,
        light_mass_kg=1.0,
        wall_gap_m=wall_gap_m,
        bodies_gap_m=bodies_gap_m,
        release_m=0.1,
    )
    at_wall = Anchor(0.0, 0.0, 0.0, 0.0, 0.0, Hold.APART)
    assert settle(build_apparatus(setup), at_wall).hold is hold


def test_a_cylinder_pushes_a_sluggish_ball_along_the_floor_to_a_common_stop() -> None:
    setup = Setup(
        mounting="floor",
        heavy_mass_kg=2.0,
        light_mass_kg=1.0,
        heavy_friction=0.1,
        light_friction=0.7,
        restitution_bodies=0.0,
        heavy_velocity_m_s=-1.0,
        release_m=0.0,
        wall_gap_m=0.5,
    )
    end = simulate(setup).anchors[-1]
    common = 2.0 / 3.0  # perfectly inelastic
    mean_friction = (2.0 * 0.1 + 1.0 * 0.7) / 3.0
    path_m = common**2 / (2.0 * mean_friction * setup.gravity_m_s2)
    assert end.hold is Hold.TOGETHER
    assert setup.wall_gap_m - end.ball_m == pytest.approx(path_m, rel=1e-12)


def test_everything_at_rest_stays_at_rest() -> None:
    still = Setup(release_m=0.0)
    assert simulate(still, until_s=100.0).collisions == ()
    pinned = simulate(Setup(wall_gap_m=-0.02, bodies_gap_m=-0.02, release_m=0.04))
    assert holds(pinned) == {Hold.PINNED}
    assert pinned.until_s == math.inf


def test_equal_pendulums_side_by_side_do_not_rattle() -> None:
    motion = simulate(Setup(restitution_bodies=0.0, restitution_wall=0.0), until_s=60.0)
    together = [anchor for anchor in motion.anchors if anchor.hold is Hold.TOGETHER]
    assert together
    last_bounce_s = motion.collisions[-1].time_s
    sample = motion.sample(np.linspace(last_bounce_s, 60.0, 1000))
    assert np.ptp(sample.heavy_face_m - sample.ball_near_face_m) <= 1e-12


def test_a_collision_faster_than_a_resting_contact_always_counts() -> None:
    motion = simulate(Setup(restitution_bodies=0.5, restitution_wall=0.5))
    slowest = min(
        abs(bounce.light_before_m_s - (bounce.kind == "bodies") * bounce.heavy_before_m_s)
        for bounce in motion.collisions
    )
    speed = Setup().release_m * Pendulum.from_thread(1.0, 9.81, 0.0, 0.0).natural_rad_s
    assert slowest > RESTING_FRACTION * speed

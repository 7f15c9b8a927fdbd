from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from random_setups import free, sliding, suspended

from count_video.physics.engine import Anchor, SimulatedCollision, events
from count_video.physics.setup import Hold, Setup, build_apparatus
from count_video.physics.simulator import Motion, simulate
from count_video.physics.theory import WHOLE_QUOTIENTS, collision_count

ELASTIC = st.just(1.0)
UNDAMPED = st.just(0.0)
ANY_TRIAL = suspended() | sliding() | free()

VELOCITY_ROUNDING = 1e-14
"""Of velocities up to a few m/s after one collision."""
DRIFT = 1e-11
"""Relative, of energies and times over a few hundred collisions."""


def kinetic_j(setup: Setup, heavy_m_s: float, light_m_s: float) -> float:
    return 0.5 * (setup.heavy_mass_kg * heavy_m_s**2 + setup.light_mass_kg * light_m_s**2)


def bounces(motion: Motion, kind: str) -> list[SimulatedCollision]:
    return [bounce for bounce in motion.collisions if bounce.kind == kind]


@given(ANY_TRIAL)
def test_collisions_of_the_bodies_keep_the_momentum(setup: Setup) -> None:
    for bounce in bounces(simulate(setup), "bodies"):
        gained = setup.heavy_mass_kg * (bounce.heavy_after_m_s - bounce.heavy_before_m_s)
        lost = setup.light_mass_kg * (bounce.light_before_m_s - bounce.light_after_m_s)
        assert gained == pytest.approx(lost, abs=setup.heavy_mass_kg * VELOCITY_ROUNDING)


@given(ANY_TRIAL)
def test_collisions_with_the_wall_leave_the_cylinder_alone(setup: Setup) -> None:
    for bounce in bounces(simulate(setup), "wall"):
        assert bounce.heavy_after_m_s == bounce.heavy_before_m_s
        assert bounce.light_after_m_s == -bounce.restitution * bounce.light_before_m_s


@given(ANY_TRIAL)
def test_restitution_is_relative_speed_after_over_before(setup: Setup) -> None:
    for bounce in bounces(simulate(setup), "bodies"):
        before = bounce.light_before_m_s - bounce.heavy_before_m_s
        after = bounce.heavy_after_m_s - bounce.light_after_m_s
        assert before > 0
        assert after == pytest.approx(bounce.restitution * before, abs=4 * VELOCITY_ROUNDING)


@given(ANY_TRIAL)
def test_a_collision_costs_one_minus_restitution_squared(setup: Setup) -> None:
    reduced = (
        setup.heavy_mass_kg * setup.light_mass_kg / (setup.heavy_mass_kg + setup.light_mass_kg)
    )
    for bounce in simulate(setup).collisions:
        before = kinetic_j(setup, bounce.heavy_before_m_s, bounce.light_before_m_s)
        after = kinetic_j(setup, bounce.heavy_after_m_s, bounce.light_after_m_s)
        mass, speed = setup.light_mass_kg, bounce.light_before_m_s
        if bounce.kind == "bodies":
            mass, speed = reduced, bounce.light_before_m_s - bounce.heavy_before_m_s
        cost = 0.5 * mass * speed**2 * (1.0 - bounce.restitution**2)
        assert before - after == pytest.approx(cost, abs=1e-12 * before)


@given(suspended(ELASTIC, UNDAMPED) | sliding(ELASTIC, UNDAMPED) | free(ELASTIC))
def test_without_losses_the_energy_stays(setup: Setup) -> None:
    energies = [bounce.energy_after_j for bounce in simulate(setup).collisions]
    assume(energies)
    np.testing.assert_allclose(energies, energies[0], rtol=DRIFT)


@given(suspended() | sliding() | free())
def test_energy_never_grows(setup: Setup) -> None:
    energies = np.array([bounce.energy_after_j for bounce in simulate(setup).collisions])
    assert (np.diff(energies) <= DRIFT * energies[:-1]).all()


@given(sliding(ELASTIC, st.floats(0.05, 0.8)))
def test_friction_takes_weight_times_path(setup: Setup) -> None:
    motion = simulate(setup)
    places = np.array([(anchor.heavy_m, anchor.ball_m) for anchor in motion.anchors])
    paths = np.abs(np.diff(places, axis=0)).sum(axis=0)  # no body turns within a flight
    drag = [
        setup.heavy_friction * setup.heavy_mass_kg * setup.gravity_m_s2,
        setup.light_friction * setup.light_mass_kg * setup.gravity_m_s2,
    ]
    end = motion.anchors[-1]
    assert (end.heavy_velocity_m_s, end.ball_velocity_m_s) == (0.0, 0.0)
    assert motion.until_s == math.inf
    start = kinetic_j(setup, setup.heavy_velocity_m_s, 0.0)
    assert drag @ paths == pytest.approx(start, rel=DRIFT)


@given(st.fractions(Fraction(1, 10), Fraction(2000), max_denominator=20))
@settings(max_examples=60)
def test_the_simulated_count_of_free_bodies_is_the_exact_one(ratio: Fraction) -> None:
    quotient = math.pi / math.atan(math.sqrt(1 / ratio))
    # Within this of a whole quotient the last contact is slower than a resting contact.
    assume(ratio in WHOLE_QUOTIENTS or abs(quotient - round(quotient)) > 1e-8)
    setup = Setup(
        mounting="free", heavy_mass_kg=float(ratio), light_mass_kg=1.0, heavy_velocity_m_s=-1.0
    )
    touching = Setup(heavy_mass_kg=float(ratio), light_mass_kg=1.0, wall_gap_m=0.0)
    assert simulate(setup).count == collision_count(ratio)
    # Equal pendulums at the wall itself: the whole burst at one instant.
    assert simulate(touching).count == collision_count(ratio)


@given(free(ELASTIC))
def test_free_collision_times_are_those_of_the_unfolded_straight_line(setup: Setup) -> None:
    ratio = setup.heavy_mass_kg / setup.light_mass_kg
    theta = math.atan(math.sqrt(1 / ratio))
    quotient = math.pi / theta
    assume(abs(quotient - round(quotient)) > 1e-6)
    motion = simulate(setup)
    # In the plane of √M x and √m y the trial is a straight line through mirrored wedges of angle
    # θ; its k-th crossing lies at the angle kθ.
    crossings = np.arange(1, motion.count + 1) * theta
    start_m = setup.wall_gap_m + setup.release_m
    heights = setup.wall_gap_m / math.sqrt(ratio) / np.tan(crossings)
    expected_s = (start_m - heights) / -setup.heavy_velocity_m_s
    times_s = [bounce.time_s for bounce in motion.collisions]
    # The last crossings are nearly parallel to the line: far, late, and sensitive as 1/sin².
    sensitivity = 1 / np.sin(crossings) ** 2
    assert (np.abs(times_s - expected_s) <= 1e-12 * expected_s.max() * sensitivity).all()


@given(suspended(dampings=UNDAMPED) | free(), st.sampled_from([0.25, 4.0, 16.0]))
def test_time_scales_with_gravity_and_velocity_to_the_bit(setup: Setup, factor: float) -> None:
    root = math.sqrt(factor)  # powers of two, so that floats scale exactly
    quick = replace(
        setup,
        gravity_m_s2=setup.gravity_m_s2 * factor,
        heavy_velocity_m_s=setup.heavy_velocity_m_s * root,
    )
    slow_motion, quick_motion = simulate(setup), simulate(quick)
    assert quick_motion.burst_end_s == slow_motion.burst_end_s / root
    assert [bounce.time_s * root for bounce in quick_motion.collisions] == [
        bounce.time_s for bounce in slow_motion.collisions
    ]


@given(ANY_TRIAL, st.sampled_from([0.125, 2.0, 64.0]))
def test_the_unit_of_mass_does_not_matter_to_the_bit(setup: Setup, factor: float) -> None:
    scaled = replace(
        setup,
        heavy_mass_kg=setup.heavy_mass_kg * factor,
        light_mass_kg=setup.light_mass_kg * factor,
    )
    assert simulate(scaled).anchors == simulate(setup).anchors


@given(suspended(ELASTIC, UNDAMPED) | free(ELASTIC))
def test_a_lossless_trial_runs_backwards_through_its_mirror_image(setup: Setup) -> None:
    motion = simulate(setup)
    burst = motion.burst
    assume(burst and all(anchor.hold is Hold.APART for anchor in motion.anchors))
    last = next(a for a in reversed(motion.anchors) if a.time_s == burst[-1].time_s)
    end = Anchor(
        0.0,
        last.heavy_m,
        -burst[-1].heavy_after_m_s,
        last.ball_m,
        -burst[-1].light_after_m_s,
        Hold.APART,
    )
    backwards = events(build_apparatus(setup), end, lambda kind: 1.0)
    times_s = [a.time_s for a, impact in (next(backwards) for _ in burst) if impact is not None]
    expected_s = [burst[-1].time_s - bounce.time_s for bounce in reversed(burst)]
    np.testing.assert_allclose(times_s, expected_s, rtol=0, atol=1e-9)

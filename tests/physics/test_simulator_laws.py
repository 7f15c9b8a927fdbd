"""The laws of mechanics, which every simulated trial keeps."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from random_trials import all_trials, lossless_trials, trials

from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion, SimulatedCollision, simulate
from count_video.physics.theory import WHOLE_QUOTIENTS, collision_count
from energies import energies_j, kinetic_j

VELOCITY_ROUNDING = 1e-14
"""Of velocities up to a few m/s after one collision; those of the cylinder times its mass."""
DRIFT = 1e-11
"""Relative, of energies and times over a few hundred collisions."""
POSITION_ROUNDING = 1e-15
"""Of positions below a metre, after one flight."""
FASTEST_M_S = 20.0
"""No ball is faster: 2 m/s of the cylinder times the root of its mass, 200, below that."""


def bounces(kind: str) -> list[tuple[Setup, SimulatedCollision]]:
    found = [(m.setup, hit) for m in all_trials() for hit in m.collisions if hit.kind == kind]
    assert len(found) > 1000
    return found


def test_collisions_of_the_bodies_keep_the_momentum() -> None:
    for setup, bounce in bounces("bodies"):
        gained = setup.heavy_mass_kg * (bounce.heavy_after_m_s - bounce.heavy_before_m_s)
        lost = setup.light_mass_kg * (bounce.light_before_m_s - bounce.light_after_m_s)
        assert gained == pytest.approx(lost, abs=setup.heavy_mass_kg * VELOCITY_ROUNDING)


def test_collisions_with_the_wall_leave_the_cylinder_alone() -> None:
    for _, bounce in bounces("wall"):
        assert bounce.heavy_after_m_s == bounce.heavy_before_m_s
        assert bounce.light_after_m_s == -bounce.restitution * bounce.light_before_m_s


def test_restitution_is_relative_speed_after_over_before() -> None:
    for setup, bounce in bounces("bodies"):
        before = bounce.light_before_m_s - bounce.heavy_before_m_s
        after = bounce.heavy_after_m_s - bounce.light_after_m_s
        assert before > 0
        rounding = VELOCITY_ROUNDING * math.sqrt(1 + setup.heavy_mass_kg)
        assert after == pytest.approx(bounce.restitution * before, abs=rounding)


def test_a_collision_costs_one_minus_restitution_squared() -> None:
    for setup, bounce in [*bounces("bodies"), *bounces("wall")]:
        mass, speed = setup.light_mass_kg, bounce.light_before_m_s
        if bounce.kind == "bodies":
            mass = 1 / (1 / setup.heavy_mass_kg + 1 / setup.light_mass_kg)
            speed = bounce.light_before_m_s - bounce.heavy_before_m_s
        before = kinetic_j(setup, bounce.heavy_before_m_s, bounce.light_before_m_s)
        after = kinetic_j(setup, bounce.heavy_after_m_s, bounce.light_after_m_s)
        cost = 0.5 * mass * speed**2 * (1.0 - bounce.restitution**2)
        assert before - after == pytest.approx(cost, abs=1e-12 * before)


def test_without_losses_the_energy_stays() -> None:
    for motion in lossless_trials():
        energies = energies_j(motion)
        np.testing.assert_allclose(energies, np.full_like(energies, energies[0]), rtol=DRIFT)


def test_energy_never_grows() -> None:
    for motion in all_trials():
        energies = energies_j(motion)
        assert (np.diff(energies) <= DRIFT * energies[:-1]).all()


def test_bodies_never_pass_through_each_other_or_the_wall() -> None:
    for motion in all_trials():
        end = min(motion.until_s, float(motion.events[-1, 0]) + 1.0)
        sample = motion.sample(np.linspace(0.0, end, 5000))
        assert (sample.heavy_face_m - sample.ball_near_face_m).min() > -POSITION_ROUNDING
        assert sample.ball_far_face_m.min() > -POSITION_ROUNDING


def test_collisions_are_seen_as_contacts_in_the_samples() -> None:
    for motion in all_trials():
        for kind in ("bodies", "wall"):
            times = np.array([bounce.time_s for bounce in motion.collisions if bounce.kind == kind])
            sample = motion.sample(times)
            gap = sample.ball_far_face_m
            if kind == "bodies":
                gap = sample.heavy_face_m - sample.ball_near_face_m
            # Two events closer than a rounding of the time share their time.
            rounding = POSITION_ROUNDING + FASTEST_M_S * np.spacing(times)
            assert (np.abs(gap) <= rounding).all()


@given(st.fractions(Fraction(1, 10), Fraction(2000), max_denominator=20))
@settings(max_examples=30)
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


def test_free_collision_times_are_those_of_the_unfolded_straight_line() -> None:
    for motion in trials(hung=False, lossy=False):
        setup = motion.setup
        ratio = setup.heavy_mass_kg / setup.light_mass_kg
        theta = math.atan(math.sqrt(1 / ratio))
        # In the plane of √M x and √m y the trial is a straight line through mirrored wedges of
        # angle θ; its k-th crossing lies at the angle kθ.
        crossings = np.arange(1, motion.count + 1) * theta
        start_m = setup.wall_gap_m + setup.release_m
        heights = setup.wall_gap_m / math.sqrt(ratio) / np.tan(crossings)
        expected_s = (start_m - heights) / -setup.heavy_velocity_m_s
        times_s = [bounce.time_s for bounce in motion.collisions]
        # The last crossings are nearly parallel to the line: far, late, and sensitive as 1/sin².
        sensitivity = 1 / np.sin(crossings) ** 2
        assert (np.abs(times_s - expected_s) <= 1e-12 * expected_s.max() * sensitivity).all()


@pytest.mark.parametrize("factor", [0.25, 4.0])
def test_time_scales_with_gravity_and_velocity_to_the_bit(factor: float) -> None:
    root = math.sqrt(factor)  # powers of two, so that floats scale exactly
    for slow in lossless_trials()[::4]:
        setup = slow.setup
        quick = simulate(
            replace(
                setup,
                gravity_m_s2=setup.gravity_m_s2 * factor,
                heavy_velocity_m_s=setup.heavy_velocity_m_s * root,
            ),
            seed=slow.seed,
        )
        assert quick.burst_end_s == slow.burst_end_s / root
        assert [bounce.time_s * root for bounce in quick.collisions] == [
            bounce.time_s for bounce in slow.collisions
        ]


@pytest.mark.parametrize("factor", [0.125, 64.0])
def test_the_unit_of_mass_does_not_matter_to_the_bit(factor: float) -> None:
    for motion in all_trials()[::8]:
        scaled = replace(
            motion.setup,
            heavy_mass_kg=motion.setup.heavy_mass_kg * factor,
            light_mass_kg=motion.setup.light_mass_kg * factor,
        )
        assert events_of(simulate(scaled, seed=motion.seed)) == events_of(motion)


def test_a_ball_diameter_only_moves_the_cylinder_aside() -> None:
    for motion in all_trials()[::8]:
        wide = simulate(
            replace(motion.setup, ball_diameter_m=motion.setup.ball_diameter_m + 0.5),
            seed=motion.seed,
        )
        assert events_of(wide) == events_of(motion)
        times = np.linspace(-0.1, min(1.0, motion.until_s), 50)
        sample, wide_sample = motion.sample(times), wide.sample(times)
        aside = wide_sample.heavy_face_m - sample.heavy_face_m
        np.testing.assert_allclose(aside, 0.5, rtol=1e-13)


def events_of(motion: Motion) -> bytes:
    """Every state of a motion, to the bit."""
    return motion.events.tobytes()


def test_free_bodies_close_in_as_the_unfolded_straight_line_crosses_the_walls() -> None:
    # In the unfolded plane the speed toward the k-th wall of the wedges is v sin kθ.
    for motion in trials(hung=False, lossy=False):
        theta = math.atan(math.sqrt(motion.setup.light_mass_kg / motion.setup.heavy_mass_kg))
        scale = -motion.setup.heavy_velocity_m_s / math.sin(theta)
        for number, hit in enumerate(motion.burst, 1):
            other, share = (
                (0.0, math.cos(theta)) if hit.kind == "wall" else (hit.heavy_before_m_s, 1)
            )
            closing = abs(hit.light_before_m_s - other)
            assert closing == pytest.approx(share * scale * math.sin(number * theta), rel=1e-9)

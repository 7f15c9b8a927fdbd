from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video.errors import UsageError
from synth_video.experiments.several import Disc, DiscMotion, collide

ROUNDED = 1e-9
"""Relative: near a graze the time of contact is the root of a small difference."""

masses = st.floats(0.1, 10.0)
offsets = st.floats(-0.9, 0.9)
restitutions = st.floats(0.0, 1.0)


def met(mass_kg: float, offset: float, restitution: float) -> DiscMotion:
    """A disc of radius 0.3 m comes at another of mass 1 kg and radius 0.7 m, at rest at 0."""
    first = Disc(mass_kg, 0.3, complex(-3.0, offset), complex(2.0, 0.0))
    return collide(first, Disc(1.0, 0.7, 0j, 0j), restitution)


@given(masses, offsets, restitutions)
def test_a_collision_keeps_the_momentum(mass_kg: float, offset: float, restitution: float) -> None:
    first, second = met(mass_kg, offset, restitution).after_m_s
    assert mass_kg * first + second == pytest.approx(complex(2 * mass_kg, 0), rel=ROUNDED)


@given(masses, offsets, restitutions)
def test_only_the_speed_along_the_line_of_centres_changes_by_the_restitution(
    mass_kg: float, offset: float, restitution: float
) -> None:
    motion = met(mass_kg, offset, restitution)
    first, second = motion.sample(np.array(motion.contact_s))
    line = complex(second - first)
    line /= abs(line)
    before = -2.0 * line.conjugate()
    after = (motion.after_m_s[1] - motion.after_m_s[0]) * line.conjugate()
    assert after.real == pytest.approx(-restitution * before.real, abs=ROUNDED)
    assert after.imag == pytest.approx(before.imag, abs=ROUNDED)


@given(masses, offsets, restitutions)
def test_the_discs_touch_at_the_contact_and_never_overlap(
    mass_kg: float, offset: float, restitution: float
) -> None:
    motion = met(mass_kg, offset, restitution)
    times_s = motion.contact_s + np.array([-1.0, -0.1, 0.0, 0.1, 1.0])
    first, second = motion.sample(times_s)
    apart_m = np.abs(second - first)
    assert apart_m[2] == pytest.approx(1.0, rel=ROUNDED)
    assert (apart_m >= 1.0 - ROUNDED).all()


def test_equal_discs_that_meet_head_on_exchange_their_velocities() -> None:
    first, second = Disc(1.0, 0.5, -2 + 0j, 1 + 0j), Disc(1.0, 0.5, 2 + 0j, -3 + 0j)
    motion = collide(first, second, 1.0)
    assert motion.contact_s == pytest.approx(0.75)
    assert motion.after_m_s == pytest.approx((-3, 1))


@pytest.mark.parametrize(("offset", "speed"), [(1.0, 2.0), (-1.5, 2.0), (0.0, -2.0), (0.0, 0.0)])
def test_discs_that_miss_or_part_never_touch(offset: float, speed: float) -> None:
    first = Disc(1.0, 0.3, complex(-3.0, offset), complex(speed, 0.0))
    motion = collide(first, Disc(1.0, 0.7, 0j, 0j), 1.0)
    assert motion.contact_s == math.inf
    there = motion.sample(np.array([-2.0, 5.0]))[0]
    assert there == pytest.approx(np.array([-3 - 2 * speed, -3 + 5 * speed]) + 1j * offset)


def test_what_cannot_collide_is_refused() -> None:
    disc = Disc(1.0, 0.5, 0j, 0j)
    with pytest.raises(UsageError, match="overlap"):
        collide(disc, disc, 1.0)
    with pytest.raises(UsageError, match="restitution"):
        collide(disc, Disc(1.0, 0.5, 2 + 0j, 0j), -0.1)

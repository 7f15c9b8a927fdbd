"""Energy of the bodies of a simulated trial, by their masses, velocities and places alone."""

from __future__ import annotations

import numpy as np

from count_video.physics.setup import Setup
from count_video.physics.simulator import Motion
from count_video.records import Floats


def kinetic_j(setup: Setup, heavy_m_s: float, light_m_s: float) -> float:
    return 0.5 * (setup.heavy_mass_kg * heavy_m_s**2 + setup.light_mass_kg * light_m_s**2)


def energies_j(motion: Motion) -> Floats:
    """Energy of the bodies after each collision; on threads also of their height above rest."""
    setup, hits = motion.setup, motion.collisions
    sample = motion.sample(np.array([bounce.time_s for bounce in hits]))
    moving = [kinetic_j(setup, hit.heavy_after_m_s, hit.light_after_m_s) for hit in hits]
    stiff = setup.gravity_m_s2 / np.array([setup.heavy_thread_m, setup.light_thread_m])
    heavy_m = sample.heavy_face_m - setup.heavy_rest_m
    off_m = np.stack([heavy_m, sample.ball_far_face_m - setup.wall_gap_m])
    masses = np.array([setup.heavy_mass_kg, setup.light_mass_kg])
    raised = (setup.mounting == "suspended") * 0.5 * (masses * stiff) @ off_m**2
    return np.array(moving) + raised


def kept_shares(motion: Motion) -> Floats:
    """Share of the first energy that is left after each collision of the burst."""
    setup, first = motion.setup, motion.burst[0]
    reduced_kg = 1 / (1 / setup.heavy_mass_kg + 1 / setup.light_mass_kg)
    lost = reduced_kg * (1 - first.restitution**2) / 2 * first.heavy_before_m_s**2
    energies = energies_j(motion)[: motion.count]
    return np.asarray(energies / (energies[0] + lost))

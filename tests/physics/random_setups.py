"""Random apparatus for property tests."""

from __future__ import annotations

from hypothesis import strategies as st

from count_video.physics.setup import Setup

THREADS = st.just(1.0) | st.floats(0.3, 2.0)
DAMPINGS = st.just(0.0) | st.floats(0.01, 1.0)
FRICTIONS = st.just(0.0) | st.floats(0.01, 0.8)
RESTITUTIONS = st.just(1.0) | st.floats(0.85, 1.0)


def suspended(
    restitutions: st.SearchStrategy[float] = RESTITUTIONS,
    dampings: st.SearchStrategy[float] = DAMPINGS,
) -> st.SearchStrategy[Setup]:
    """Two pendulums, of any two threads."""
    return st.builds(
        Setup,
        heavy_mass_kg=st.floats(0.5, 200.0),
        light_mass_kg=st.just(1.0),
        heavy_thread_m=THREADS,
        light_thread_m=THREADS,
        heavy_damping_per_s=dampings,
        light_damping_per_s=dampings,
        wall_gap_m=st.floats(0.0, 0.1),
        bodies_gap_m=st.just(0.0) | st.floats(-0.02, 0.02),
        release_m=st.floats(0.03, 0.1),
        restitution_bodies=restitutions,
        restitution_wall=restitutions,
    )


def sliding(
    restitutions: st.SearchStrategy[float] = RESTITUTIONS,
    frictions: st.SearchStrategy[float] = FRICTIONS,
) -> st.SearchStrategy[Setup]:
    """Two bodies on a floor, each with its own friction, which may be none."""
    return st.builds(
        Setup,
        mounting=st.just("floor"),
        heavy_mass_kg=st.floats(0.5, 200.0),
        light_mass_kg=st.just(1.0),
        heavy_friction=frictions,
        light_friction=frictions,
        wall_gap_m=st.floats(0.0, 0.1),
        heavy_velocity_m_s=st.floats(-2.0, -0.1),
        restitution_bodies=restitutions,
        restitution_wall=restitutions,
    )


def free(restitutions: st.SearchStrategy[float] = RESTITUTIONS) -> st.SearchStrategy[Setup]:
    """Two bodies without any force between collisions."""
    return st.builds(
        Setup,
        mounting=st.just("free"),
        heavy_mass_kg=st.floats(0.5, 200.0),
        light_mass_kg=st.just(1.0),
        wall_gap_m=st.floats(0.001, 0.1),
        heavy_velocity_m_s=st.floats(-2.0, -0.1),
        restitution_bodies=restitutions,
        restitution_wall=restitutions,
    )

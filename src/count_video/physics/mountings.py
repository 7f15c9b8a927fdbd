"""The three mountings as laws of motion, and what bodies do that stay in contact.

Two bodies can touch without bouncing: the ball lies against the wall, the cylinder leans on the
ball, or both. Each such *hold* is a motion of its own, so that a run never has to follow endless
ever smaller hops.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import IntEnum

from count_video.physics.contacts import first_zero
from count_video.physics.flights import REST, Law, Pendulum, Sliding
from count_video.physics.setup import Setup

RESTING_FRACTION = 1e-9
"""A contact slower than this fraction of the trial's speed is no bounce: the bodies stay together.
The energy so lost, a fraction of 1e-18, is below the rounding of the whole. It ends the chatter of
inelastic bodies: the speed of the n-th hop falls as eⁿ, so at most ln(1e-9) / ln(e) hops come
before rest (404 for e = 0.95). Likewise an acceleration below this fraction of the trial's does
not part two bodies, so that equal pendulums which swing side by side do not rattle by rounding."""


class Hold(IntEnum):
    """Which bodies are in lasting contact during a flight."""

    APART = 0
    BALL_ON_WALL = 1
    TOGETHER = 2
    """Ball and cylinder move as one."""
    PINNED = 3
    """The cylinder presses the ball on the wall and all rest."""


@dataclass(frozen=True)
class Apparatus:
    """A set-up turned into laws of motion.

    Positions are those of the ball's wall-side face and of the cylinder's face less a ball
    diameter, so that contact is equality and the wall is 0.
    """

    heavy_kg: float
    light_kg: float
    heavy: Law
    light: Law
    together: Law
    relative: Law | None
    """The law of the gap between cylinder and ball where it has one of its own: the difference
    of two swings of one frequency and damping is such a swing. Then two nearly equal motions
    cost no digits, and the bounds of their difference are as small as it is."""
    resting_speed_m_s: float
    """A contact slower than this is no bounce."""
    resting_acceleration_m_s2: float
    """A relative acceleration below this does not part two bodies."""

    def laws(self, hold: Hold) -> tuple[Law, Law]:
        """Law of the cylinder and of the ball."""
        if hold is Hold.APART:
            return self.heavy, self.light
        if hold is Hold.BALL_ON_WALL:
            return self.heavy, REST
        if hold is Hold.TOGETHER:
            return self.together, self.together
        return REST, REST

    def energy_j(
        self, heavy_m: float, heavy_velocity: float, ball_m: float, ball_velocity: float
    ) -> float:
        """Kinetic energy and that of the pendulums above their rest."""
        return self.heavy_kg * (
            0.5 * heavy_velocity * heavy_velocity + self.heavy.potential(heavy_m)
        ) + self.light_kg * (0.5 * ball_velocity * ball_velocity + self.light.potential(ball_m))

    def parting_s(self, position_m: float, velocity_m_s: float, window_s: float) -> float:
        """Time until bodies that move together are pulled apart; inf if not within the window.

        The signal is the relative acceleration a_heavy − a_light along the common swing: constant
        for sliding bodies, a constant plus a damped sine for pendulums. It must rise to the
        resting acceleration.
        """
        heavy, light, together = self.heavy, self.light, self.together
        if not (
            isinstance(heavy, Pendulum)
            and isinstance(light, Pendulum)
            and isinstance(together, Pendulum)
        ):
            return math.inf
        by_position = light.natural_rad_s**2 - heavy.natural_rad_s**2
        by_velocity = 2.0 * (light.damping_per_s - heavy.damping_per_s)
        acceleration, jerk = together.bounds(position_m, velocity_m_s)

        def margin(tau: float) -> tuple[float, float, float]:
            rise, velocity = together.advance(position_m, velocity_m_s, tau)
            position = position_m + rise
            pull = heavy.acceleration(position, velocity) - light.acceleration(position, velocity)
            change = by_position * velocity + by_velocity * together.acceleration(
                position, velocity
            )
            return self.resting_acceleration_m_s2 - pull, -change, 0.0

        curvature = abs(by_position) * acceleration + abs(by_velocity) * jerk
        return first_zero(margin, 0.0, (curvature, 0.0), window_s)


def build_apparatus(setup: Setup) -> Apparatus:
    """Laws of motion and thresholds of a set-up."""
    if setup.mounting == "suspended":
        heavy, light, together, relative = _pendulums(setup)
        reach_m = abs(setup.release_m)
        speed = abs(setup.heavy_velocity_m_s) + reach_m * heavy.natural_rad_s
        acceleration = speed * max(heavy.natural_rad_s, light.natural_rad_s)
        return _apparatus(setup, (heavy, light, together, relative), speed, acceleration)
    sliding = _sliding(setup) if setup.mounting == "floor" else (REST, REST, REST)
    strongest = max(law.deceleration_m_s2 for law in sliding)
    return _apparatus(setup, (*sliding, None), abs(setup.heavy_velocity_m_s), strongest)


def _apparatus(
    setup: Setup, laws: tuple[Law, Law, Law, Law | None], speed: float, acceleration: float
) -> Apparatus:
    heavy, light, together, relative = laws
    return Apparatus(
        heavy_kg=setup.heavy_mass_kg,
        light_kg=setup.light_mass_kg,
        heavy=heavy,
        light=light,
        together=together,
        relative=relative,
        resting_speed_m_s=RESTING_FRACTION * speed,
        resting_acceleration_m_s2=RESTING_FRACTION * acceleration,
    )


def _pendulums(setup: Setup) -> tuple[Pendulum, Pendulum, Pendulum, Pendulum | None]:
    """Cylinder, ball, both as one, and their gap if it is a pendulum too.

    For both as one forces add, so stiffness, damping and rest are means.
    """
    heavy = Pendulum.from_thread(
        setup.heavy_thread_m,
        setup.gravity_m_s2,
        setup.heavy_damping_per_s,
        setup.wall_gap_m + setup.bodies_gap_m,
    )
    light = Pendulum.from_thread(
        setup.light_thread_m, setup.gravity_m_s2, setup.light_damping_per_s, setup.wall_gap_m
    )
    share = setup.heavy_mass_kg / (setup.heavy_mass_kg + setup.light_mass_kg)
    heavy_stiffness = share * heavy.natural_rad_s**2
    light_stiffness = (1.0 - share) * light.natural_rad_s**2
    stiffness = heavy_stiffness + light_stiffness
    rest = (heavy_stiffness * heavy.rest_m + light_stiffness * light.rest_m) / stiffness
    damping = share * heavy.damping_per_s + (1.0 - share) * light.damping_per_s
    together = Pendulum.from_stiffness(stiffness, damping, rest)
    alike = replace(heavy, rest_m=light.rest_m) == light
    return heavy, light, together, replace(heavy, rest_m=setup.bodies_gap_m) if alike else None


def _sliding(setup: Setup) -> tuple[Sliding, Sliding, Sliding]:
    """Cylinder, ball, and both as one, each braked by its own weight on the floor."""
    heavy = setup.heavy_friction * setup.gravity_m_s2
    light = setup.light_friction * setup.gravity_m_s2
    mass = setup.heavy_mass_kg + setup.light_mass_kg
    mean = (setup.heavy_mass_kg * heavy + setup.light_mass_kg * light) / mass
    return Sliding(heavy), Sliding(light), Sliding(mean)

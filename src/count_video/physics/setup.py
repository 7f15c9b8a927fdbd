"""The apparatus: masses, threads, gaps and restitution, and the laws by which its bodies move.

The defaults are those of the paper's Table 1. Two bodies can touch without bouncing: the ball lies
against the wall, the cylinder leans on the ball, or both. Each such *hold* is a motion of its own,
so that a run never has to follow endless ever smaller hops.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import Any, Literal, get_args

from count_video.errors import UsageError
from count_video.physics.contacts import first_zero
from count_video.physics.flights import REST, Law, Pendulum, Sliding

Mounting = Literal["free", "floor", "suspended"]


@dataclass(frozen=True)
class Setup:
    """One apparatus and the way a trial on it starts, in SI units.

    Metres point away from the wall, whose face is at 0. The ball lies between the wall and the
    heavy body (the cylinder). A gap of the rest positions may be negative: then the threads press
    the two together (an overlap).

    Raises
    ------
    UsageError
        If a value is not finite, out of its range, or the combination is impossible.
    """

    heavy_mass_kg: float = 1.050
    light_mass_kg: float = 0.0105
    mounting: Mounting = "suspended"
    """``free``: no force between collisions; ``floor``: sliding friction; ``suspended``: each body
    a pendulum of its own, in the small-angle approximation."""
    heavy_thread_m: float = 1.0
    light_thread_m: float = 1.0
    heavy_damping_per_s: float = 0.0
    """Rate at which the amplitude of the free pendulum decays (suspended only)."""
    light_damping_per_s: float = 0.0
    heavy_friction: float = 0.0
    """Coulomb coefficient of sliding friction (floor only)."""
    light_friction: float = 0.0
    ball_diameter_m: float = 0.040
    wall_gap_m: float = 0.07
    """Distance from the wall to the ball's wall-side face when the ball hangs at rest."""
    bodies_gap_m: float = 0.0
    """Distance from the ball's near face to the cylinder's face when both hang at rest."""
    release_m: float = 0.09
    """The cylinder starts this far beyond its rest position."""
    heavy_velocity_m_s: float = 0.0
    """Velocity of the cylinder at time 0; free and floor need it negative (toward the wall)."""
    restitution_bodies: float = 1.0
    restitution_wall: float = 1.0
    restitution_bodies_sd: float = 0.0
    """Standard deviation of the restitution from collision to collision (clipped to [0, 1])."""
    restitution_wall_sd: float = 0.0
    gravity_m_s2: float = 9.81

    def __post_init__(self) -> None:
        if self.mounting not in get_args(Mounting):
            raise UsageError(
                f"mounting is {self.mounting!r}; choose one of {', '.join(get_args(Mounting))}"
            )
        for field in fields(self):
            if field.name != "mounting":
                _check_number(field.name, getattr(self, field.name))
        self._check_start()
        if self.mounting == "suspended":
            self._check_pendulums()

    @property
    def ball_start_m(self) -> float:
        """Wall-side face of the ball at time 0: at rest, against the wall if pressed there."""
        return max(0.0, self.wall_gap_m)

    @property
    def heavy_rest_m(self) -> float:
        """Face of the cylinder at rest."""
        return self.wall_gap_m + self.ball_diameter_m + self.bodies_gap_m

    @property
    def heavy_start_m(self) -> float:
        """Face of the cylinder at time 0."""
        return self.heavy_rest_m + self.release_m

    def _check_start(self) -> None:
        free_m = self.wall_gap_m + self.bodies_gap_m + self.release_m - self.ball_start_m
        if free_m < 0:
            raise UsageError(
                f"the cylinder would start {-free_m:g} m inside the ball; "
                "raise release_m or the gaps"
            )
        if self.mounting != "suspended" and self.heavy_velocity_m_s >= 0:
            raise UsageError(
                f"heavy_velocity_m_s is {self.heavy_velocity_m_s:g}; a {self.mounting} cylinder "
                "needs a negative one (toward the wall) to collide at all"
            )
        if self.mounting != "suspended" and self.wall_gap_m < 0:
            raise UsageError(
                f"wall_gap_m is {self.wall_gap_m:g}; only a suspended ball can press on the wall"
            )

    def _check_pendulums(self) -> None:
        if self.gravity_m_s2 == 0:
            raise UsageError("gravity_m_s2 is 0; a suspended body needs weight, or choose free")
        for body in ("heavy", "light"):
            damping = getattr(self, f"{body}_damping_per_s")
            natural = math.sqrt(self.gravity_m_s2 / getattr(self, f"{body}_thread_m"))
            if damping >= natural:
                raise UsageError(
                    f"{body}_damping_per_s is {damping:g}; a pendulum that swings needs less than "
                    f"{natural:g}"
                )


_POSITIVE = ("heavy_mass_kg", "light_mass_kg", "heavy_thread_m", "light_thread_m")
_ANY_SIGN = ("wall_gap_m", "bodies_gap_m", "release_m", "heavy_velocity_m_s")
_FRACTIONS = ("restitution_bodies", "restitution_wall")


def _check_number(name: str, value: float) -> None:
    """Refuse a value that is not finite or outside the range of its field."""
    if not math.isfinite(value):
        raise UsageError(f"{name} is {value}; it must be a finite number")
    if name in _POSITIVE and value <= 0:
        raise UsageError(f"{name} is {value:g}; it must be greater than 0")
    if name not in _ANY_SIGN and value < 0:
        raise UsageError(f"{name} is {value:g}; it must not be negative")
    if name in _FRACTIONS and value > 1:
        raise UsageError(f"{name} is {value:g}; it must lie between 0 and 1")


# ---- the laws of motion ----------------------------------------------------------------------

RESTING_FRACTION = 1e-9
"""A contact slower than this fraction of the trial's speed is no bounce: the bodies stay together.
The energy so lost, a fraction of 1e-18, is below the rounding of the whole. It ends the ever
smaller hops of inelastic bodies: the speed of the n-th hop falls as eⁿ, so at most
ln(1e-9) / ln(e) hops come before rest (404 for e = 0.95). Likewise an acceleration below this
fraction of the trial's does not part two bodies, so that equal pendulums which swing side by side
do not collide by rounding."""


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
    heavy: Law
    light: Law
    together: Law
    relative: Law | None = None
    speed = abs(setup.heavy_velocity_m_s)
    if setup.mounting == "suspended":
        heavy, light, together, relative = pendulums = _pendulums(setup)
        speed += abs(setup.release_m) * pendulums[0].natural_rad_s
        acceleration = speed * max(pendulum.natural_rad_s for pendulum in pendulums[:2])
    else:
        heavy, light, together = sliding = _sliding(setup)
        acceleration = max(law.deceleration_m_s2 for law in sliding)
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


def pendulums_of(setup: Any) -> tuple[Pendulum, Pendulum]:
    """Cylinder and ball of a set-up, or of a table of n set-ups with its fields as columns.

    The cylinder's place is that of its face less a ball diameter.
    """
    gravity, gap_m = setup.gravity_m_s2, setup.wall_gap_m
    heavy_rest_m = gap_m + setup.bodies_gap_m
    return (
        Pendulum.from_thread(
            setup.heavy_thread_m, gravity, setup.heavy_damping_per_s, heavy_rest_m
        ),
        Pendulum.from_thread(setup.light_thread_m, gravity, setup.light_damping_per_s, gap_m),
    )


def _pendulums(setup: Setup) -> tuple[Pendulum, Pendulum, Pendulum, Pendulum | None]:
    """Cylinder, ball, both as one, and their gap if it is a pendulum too.

    For both as one forces add, so stiffness, damping and rest are means.
    """
    heavy, light = pendulums_of(setup)
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
    """Cylinder, ball, and both as one: free, or each braked by its own weight on the floor."""
    if setup.mounting == "free":
        return REST, REST, REST
    heavy = setup.heavy_friction * setup.gravity_m_s2
    light = setup.light_friction * setup.gravity_m_s2
    mass = setup.heavy_mass_kg + setup.light_mass_kg
    mean = (setup.heavy_mass_kg * heavy + setup.light_mass_kg * light) / mass
    return Sliding(heavy), Sliding(light), Sliding(mean)

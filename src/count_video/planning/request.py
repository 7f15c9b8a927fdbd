"""What a plan is asked for: the set-up, the camera and how well hands can repeat it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import TypedDict

from count_video.errors import UsageError
from count_video.physics.many import GRAVITY_M_S2, ManySetups
from count_video.physics.setup import Setup
from count_video.physics.theory import Mass, exact_ratio
from count_video.records import Floats

MOST_RATIO = 1_000_000
"""A larger mass ratio would have more than 3141 collisions, of which no clip shows the number."""
MOST_TRIALS = 100_000
MOST_FACTOR, MOST_MORE = 2, 60
"""Of the theory's count, and beyond that: trials with more collisions are not followed."""


@dataclass(frozen=True)
class Tolerances:
    """How trials scatter that are meant to be alike: standard deviations, unless said otherwise."""

    gap_m: float = 0.001
    release_m: float = 0.002
    mass: float = 0.005
    """Of each mass, as a share of it."""
    thread_m: float = 0.001
    """Of each body's thread on its own."""
    restitution: float = 0.05
    """Width of the range in which the restitution of each contact lies from trial to trial, evenly;
    it ends at 1 for bodies that are planned without losses, else it lies about the planned value.
    """
    scatter: float = 0.005
    """Of the restitution from collision to collision."""

    def __post_init__(self) -> None:
        for one in fields(self):
            value = getattr(self, one.name)
            if not (math.isfinite(value) and value >= 0):
                raise UsageError(f"the tolerance {one.name} is {value:g}; it must be 0 or more")
        for name in ("mass", "restitution", "scatter"):
            if getattr(self, name) > 1:
                raise UsageError(f"the tolerance {name} is a share; it must not exceed 1")


class PlanDetails(TypedDict, total=False):
    """What may be said of a plan besides the masses; see ``PlanRequest``."""

    gap_m: float
    release_m: float
    heavy_thread_m: float
    light_thread_m: float
    capture_fps: float | None
    restitution: float
    damping_per_s: float
    ball_diameter_m: float
    tolerances: Tolerances
    trials: int
    seed: int


@dataclass(frozen=True)
class PlanRequest:
    """One planned set-up; lengths in metres, masses in any one unit.

    Raises
    ------
    UsageError
        If a value makes no sense; the message is one line.
    """

    heavy: Mass
    light: Mass
    gap_m: float = 0.03
    """From the wall to the far face of the ball where it hangs."""
    release_m: float = 0.09
    """From where the cylinder hangs, its face touching the hanging ball, to where it is let go."""
    heavy_thread_m: float = 1.0
    light_thread_m: float = 1.0
    capture_fps: float | None = None
    """Rate of the camera; None if it is still open."""
    restitution: float = 1.0
    """Of both contacts."""
    damping_per_s: float = 0.0
    """Rate at which the amplitude of a free swing decays."""
    ball_diameter_m: float = 0.040
    tolerances: Tolerances = field(default_factory=Tolerances)
    trials: int = 30
    """Trials of the table."""
    seed: int = 0
    """Of all that is drawn at random."""

    def __post_init__(self) -> None:
        _check_positive(self)
        if self.mass_ratio < 1:
            raise UsageError(
                f"the heavy mass is {float(self.mass_ratio):.4g} of the light one; give the heavy "
                "mass first"
            )
        if self.mass_ratio > MOST_RATIO:
            raise UsageError(f"a mass ratio above {MOST_RATIO} cannot be planned; take a smaller")
        if self.gap_m > self.release_m:
            raise UsageError(
                f"the gap of {self.gap_m:g} m is larger than the release of {self.release_m:g} m; "
                "hang the ball nearer to the wall or let the cylinder go from farther away"
            )
        shortest_m = min(self.heavy_thread_m, self.light_thread_m)
        if self.release_m >= shortest_m:
            raise UsageError(
                f"the release of {self.release_m:g} m is not shorter than a thread of "
                f"{shortest_m:g} m; plan swings that are small"
            )
        if not 0 <= self.restitution <= 1:
            raise UsageError(f"the restitution is {self.restitution:g}; it lies between 0 and 1")
        slowest = math.sqrt(GRAVITY_M_S2 / max(self.heavy_thread_m, self.light_thread_m))
        if not 0 <= self.damping_per_s < slowest:
            raise UsageError(
                f"the damping is {self.damping_per_s:g} a second; it must lie between 0 and "
                f"{slowest:.3g}, from where on nothing swings"
            )
        if not 2 <= self.trials <= MOST_TRIALS:
            raise UsageError(f"{self.trials} trials make no table; ask for 2 to {MOST_TRIALS}")
        if self.seed < 0:
            raise UsageError(f"the seed is {self.seed}; it must be 0 or more")

    @property
    def mass_ratio(self) -> float:
        """Heavy over light mass."""
        return float(exact_ratio(self.heavy, self.light))

    def setup(self) -> Setup:
        """Return the set-up as the simulator takes it; the light mass is the unit."""
        return Setup(
            heavy_mass_kg=self.mass_ratio,
            light_mass_kg=1.0,
            heavy_thread_m=self.heavy_thread_m,
            light_thread_m=self.light_thread_m,
            heavy_damping_per_s=self.damping_per_s,
            light_damping_per_s=self.damping_per_s,
            ball_diameter_m=self.ball_diameter_m,
            wall_gap_m=self.gap_m,
            release_m=self.release_m,
            restitution_bodies=self.restitution,
            restitution_wall=self.restitution,
            gravity_m_s2=GRAVITY_M_S2,
        )


def setups_at(request: PlanRequest, gap_m: Floats, release_m: Floats) -> ManySetups:
    """Return the planned set-up with other gaps and releases, without scatter."""
    return ManySetups.of(
        mass_ratio=request.mass_ratio,
        wall_gap_m=gap_m,
        release_m=release_m,
        heavy_thread_m=request.heavy_thread_m,
        light_thread_m=request.light_thread_m,
        damping_per_s=request.damping_per_s,
        restitution_bodies=request.restitution,
        restitution_wall=request.restitution,
    )


def most_collisions(theory: int) -> int:
    """Trials with more are taken for endless: losses that add so many end in ever more."""
    return MOST_FACTOR * theory + MOST_MORE


_POSITIVE = {
    "gap_m": "the gap",
    "release_m": "the release",
    "heavy_thread_m": "the cylinder's thread",
    "light_thread_m": "the ball's thread",
    "capture_fps": "the camera's rate",
    "ball_diameter_m": "the ball's diameter",
}


def _check_positive(request: PlanRequest) -> None:
    for name, words in _POSITIVE.items():
        value = getattr(request, name)
        if value is not None and not (math.isfinite(value) and value > 0):
            raise UsageError(f"{words} is {value:g}; it must be a number above 0")

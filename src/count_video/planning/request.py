"""What a plan is asked for: the set-up, the camera, how well hands can repeat it; and as JSON.

The JSON is kept so that a counted clip can be held against its plan later.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, TypedDict

from count_video import inputs
from count_video.errors import UsageError
from count_video.inputs import masses, number_words, read_json_object, shown
from count_video.physics.setup import Setup, swing_rate
from count_video.physics.theory import Mass, exact_ratio

PLAN_VERSION = 1
MOST_RATIO = 1_000_000
"""A larger mass ratio would have more than 3141 collisions, of which no clip shows the number."""
MOST_DAMPING = 0.95
"""Of the rate at which a pendulum swings no more: nearer to it a flight takes ever more steps."""
_LENGTHS = ("gap_m", "release_m", "heavy_thread_m", "light_thread_m", "ball_diameter_m")
Readers = Mapping[str, Callable[[str], object]]
"""What reads and checks the values of some fields, as the command line does."""
_READERS: Readers = {
    **dict.fromkeys(("heavy", "light"), inputs.MASS.exact),
    **dict.fromkeys(_LENGTHS, inputs.LENGTH),
    **{"capture_fps": inputs.CAPTURE_RATE, "restitution": inputs.SHARE},
    **{"damping_per_s": inputs.DAMPING, "trials": inputs.TRIALS, "seed": inputs.SEED},
}


@dataclass(frozen=True)
class Tolerances:
    """How trials scatter that are meant to be alike: standard deviations, unless said otherwise.

    Raises
    ------
    UsageError
        If a value is out of its range.
    """

    gap_m: float = 0.001
    release_m: float = 0.002
    mass: float = 0.005
    """Deviation of each mass, as a share of it."""
    thread_m: float = 0.001
    """Deviation of each body's thread on its own."""
    restitution: float = 0.05
    """Width of the range in which the restitution of each contact lies from trial to trial, evenly;
    it ends at 1 for bodies that are planned without losses, else it lies about the planned value.
    """
    scatter: float = 0.005
    """Deviation of the restitution from collision to collision."""

    def __post_init__(self) -> None:
        _check(self, dict(inputs.TOLERANCES.values()), "the tolerance ")


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

    A mass is kept as an exact fraction, a float at the decimal number it is written as.

    Raises
    ------
    UsageError
        If a value makes no sense; the message is one line.
    """

    heavy: Mass
    light: Mass
    gap_m: float = 0.03
    """Distance from the wall to the ball's side that faces it, where it hangs."""
    release_m: float = 0.09
    """Distance from where the cylinder hangs, touching the ball, to where it is let go."""
    heavy_thread_m: float = 1.0
    light_thread_m: float = 1.0
    capture_fps: float | None = None
    """Rate of the camera; None if it is still open."""
    restitution: float = 1.0
    """Restitution of both contacts."""
    damping_per_s: float = 0.0
    """Rate at which the amplitude of a free swing decays."""
    ball_diameter_m: float = 0.040
    tolerances: Tolerances = field(default_factory=Tolerances)
    trials: int = 30
    """Trials of the table."""
    seed: int = 0
    """Seed of all that is drawn at random."""

    def __post_init__(self) -> None:
        _check(self, _READERS)
        masses(exact_ratio(self.heavy, self.light), Fraction(1))  # refuses what are none
        if not isinstance(self.tolerances, Tolerances):
            raise UsageError(f"tolerances is {shown(str(self.tolerances))}; give a Tolerances")
        if self.mass_ratio > MOST_RATIO:
            raise UsageError(
                f"a mass ratio above {number_words(MOST_RATIO)} cannot be planned; take a smaller"
            )
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
        longest_m = max(self.heavy_thread_m, self.light_thread_m)
        most_per_s = MOST_DAMPING * swing_rate(longest_m, Setup.gravity_m_s2)
        if self.damping_per_s >= most_per_s:
            raise UsageError(
                f"with a damping of {self.damping_per_s:g} per second hardly anything swings: plan "
                f"less than {most_per_s:.3g}"
            )

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
        )


def most_collisions(theory: int) -> int:
    """Trials with more are taken for endless: losses that add so many end in ever more."""
    return 2 * theory + 60


def request_object(request: PlanRequest) -> dict[str, Any]:
    """Turn a request into what ``json.dumps`` takes."""
    return asdict(request) | {"heavy": float(request.heavy), "light": float(request.light)}


def read_request(path: Path) -> PlanRequest:
    """Read the request of a stored plan; UsageError if it cannot be read or makes no sense."""
    stored = read_json_object(path)
    if stored.get("plan_version") != PLAN_VERSION:
        raise UsageError(
            f"{path}: is no plan, version {PLAN_VERSION}; give the plan.json that --plan wrote"
        )
    values = stored.get("request")
    if not isinstance(values, dict):
        raise UsageError(f"{path}: has no planned set-up; make the file again with --plan")
    try:
        tolerances = Tolerances(**values.pop("tolerances", {}))
        return PlanRequest(**values, tolerances=tolerances)
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from error
    except TypeError as error:  # a field that there is not, or none where there has to be one
        raise UsageError(
            f"{path}: lacks a mass, or has what no plan has; make the file again with --plan"
        ) from error


def _check(record: object, readers: Readers, prefix: str = "") -> None:
    """Refuse a value that is no number or out of its range; the camera's rate may be left open.

    The values of NumPy and others become Python's own.
    """
    for name, read in readers.items():
        value = getattr(record, name)
        if value is not None or name != "capture_fps":
            object.__setattr__(record, name, inputs.checked(f"{prefix}{name}", value, read))

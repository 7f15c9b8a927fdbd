"""Two discs that slide freely on a plane: when they meet, and how they part.

Points of the plane are complex numbers, in metres: what matters of two points is their difference,
and its length and direction are then at hand. Two free discs meet at most once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.records import Floats

Points = NDArray[np.complex128]


@dataclass(frozen=True)
class Disc:
    """One disc at time 0."""

    mass_kg: float
    radius_m: float
    place_m: complex
    velocity_m_s: complex


@dataclass(frozen=True)
class DiscMotion:
    """Two discs before and after they meet."""

    discs: tuple[Disc, Disc]
    contact_s: float
    """Time at which they touch; inf if they never do."""
    after_m_s: tuple[complex, complex]
    """Velocities after the contact; those before it if there is none."""

    def sample(self, times_s: Floats) -> tuple[Points, Points]:
        """Centres of both at times of any shape, also before time 0."""
        times = np.asarray(times_s, dtype=np.float64)
        until = np.minimum(times, self.contact_s)
        since = times - until
        first, second = (
            disc.place_m + disc.velocity_m_s * until + after * since
            for disc, after in zip(self.discs, self.after_m_s, strict=True)
        )
        return first, second


def collide(first: Disc, second: Disc, restitution: float) -> DiscMotion:
    """Let two smooth discs meet: the impulse acts along the line of their centres.

    Raises
    ------
    UsageError
        If the discs overlap at time 0 or the restitution is not between 0 and 1.
    """
    if not 0.0 <= restitution <= 1.0:
        raise UsageError(f"restitution is {restitution:g}; it must lie between 0 and 1")
    apart = second.place_m - first.place_m
    if abs(apart) < first.radius_m + second.radius_m:
        raise UsageError("the discs overlap at the start; move them apart")
    drift = second.velocity_m_s - first.velocity_m_s
    contact_s = _contact_s(apart, drift, first.radius_m + second.radius_m)
    before = first.velocity_m_s, second.velocity_m_s
    if contact_s == math.inf:
        return DiscMotion((first, second), contact_s, before)
    line = apart + drift * contact_s
    line /= abs(line)
    approach = -(drift * line.conjugate()).real
    push = (1.0 + restitution) * approach / (first.mass_kg + second.mass_kg)
    after = before[0] - second.mass_kg * push * line, before[1] + first.mass_kg * push * line
    return DiscMotion((first, second), contact_s, after)


def _contact_s(apart_m: complex, drift_m_s: complex, reach_m: float) -> float:
    """First time t ≥ 0 with |apart + drift t| = reach; inf if there is none.

    Of the roots of |drift|² t² + 2 b t + c = 0 with b = Re(apart* drift) the smaller is wanted,
    written as c / (−b + root) so that nothing cancels.
    """
    inward = -(apart_m.conjugate() * drift_m_s).real
    beyond = abs(apart_m) ** 2 - reach_m**2
    level = inward**2 - abs(drift_m_s) ** 2 * beyond
    if inward <= 0.0 or level <= 0.0:  # going apart, or past each other; a graze is no push
        return math.inf
    return max(0.0, beyond) / (inward + math.sqrt(level))

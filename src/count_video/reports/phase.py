"""Measured states: scaled velocities and energy after each collision."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from count_video.records import Floats, Velocities
from count_video.reports.material import Material, heavy_at


@dataclass(frozen=True)
class States:
    """The state before the first collision of the burst and after each; arrays have shape (n,)."""

    number: Floats
    """0 before the first collision, then the collision's number."""
    scaled_heavy: Floats
    """V1 = sqrt(M) v1, away from the wall, in units of the first state's length; NaN if unknown."""
    scaled_light: Floats
    """V2 = sqrt(m) v2, likewise."""
    swing_energy: Floats
    """Energy stored in the heavy body's swing, in units of the first state's kinetic energy and
    counted from there; 0 where the swing is not known."""


def measured_states(material: Material) -> States | None:
    """States of the burst; None where the mass ratio or the first state is not known."""
    burst, ratio = material.burst, material.result.mass_ratio
    if not burst or ratio is None:
        return None
    velocities = [burst[0].velocity_before, *(c.velocity_after for c in burst)]
    points = np.array([_scaled(v, ratio) for v in velocities]) * material.outward
    length = float(np.hypot(*points[0]))
    if not (length > 0 and math.isfinite(length)):
        return None
    times = [burst[0].frame, *(c.frame for c in burst)]
    swing = np.array([_swing_energy(material, frame) for frame in times]) * ratio
    return States(
        number=np.arange(len(points), dtype=np.float64),
        scaled_heavy=points[:, 0] / length,
        scaled_light=points[:, 1] / length,
        swing_energy=(swing - swing[0]) / length**2,
    )


def _scaled(velocities: Velocities, ratio: float) -> tuple[float, float]:
    return math.sqrt(ratio) * velocities.heavy_px_frame, velocities.ball_px_frame


def _swing_energy(material: Material, frame: float) -> float:
    """Twice the potential energy of the heavy body a unit of its mass, in (px/frame) squared."""
    pendulum = material.pendulum
    if pendulum is None:
        return 0.0
    away = heavy_at(material, frame) * material.outward - pendulum.centre_px
    return pendulum.rate_squared * away**2

"""What a fitted burst says of its physics: the energy after each collision and how it ended."""

from __future__ import annotations

import numpy as np

from count_video.between.model import Paths
from count_video.between.parameters import Column
from count_video.records import Ending, EndingKind, Floats

DISSIPATED_BELOW = 0.1
"""With less than this share of the energy left, losses have ended the burst."""
AT_REST_SHARE = 0.02
"""A velocity within this share of the first one is as good as none."""


def energy_kept(paths: Paths, values: Floats) -> Floats:
    """Energy after each collision over that before the first, shape (events,).

    Kinetic and, on the threads, potential energy of both bodies, in units of the heavy mass.
    """
    after = _energy(paths, values, paths.states[:, 0, 1:])
    start = _energy(paths, values, paths.before[:, 0, 1:2])
    return np.asarray(after / start)


def _energy(paths: Paths, values: Floats, states: Floats) -> Floats:
    laws = paths.pendulums
    heavy, heavy_velocity, ball, ball_velocity = states
    swung = laws.heavy_rate[0] * (heavy - laws.heavy_rest[0])
    ball_swung = laws.ball_rate[0] * (ball - laws.ball_rest[0])
    light = np.exp(values[Column.LIGHTNESS]) * (ball_velocity**2 + ball_swung**2)
    return np.asarray(heavy_velocity**2 + swung**2 + light) / 2


def ending_of(paths: Paths, values: Floats) -> Ending:
    """Tell how the burst ended from its state after the last collision."""
    kept = float(energy_kept(paths, values)[-1])
    first = abs(float(paths.before[1, 0, 1]))
    heavy, ball = float(paths.states[1, 0, -1]) / first, float(paths.states[3, 0, -1]) / first
    kind: EndingKind = "pendulum"
    if kept < DISSIPATED_BELOW:
        kind = "dissipative"
    elif -AT_REST_SHARE <= ball <= heavy + AT_REST_SHARE:
        kind = "geometric"
    return Ending(kind, kept, heavy, ball)

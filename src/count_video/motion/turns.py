"""Turns of one body's path, on either side, that its weight alone does not explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from count_video.motion.flight import Motion
from count_video.signals import low_points

HYSTERESIS_SIGMAS = 3.0
"""What is no more than noise has no jump, and lies at no stop."""
PULL_AT_MOST = 1.5
TURN_PICTURES = (1, 2)
TURN_SIGMAS = 3.0
"""Within so many pictures of the highest point of a throw, the path bends by no more than this
factor of what the usual acceleration does, and the noise."""


@dataclass(frozen=True)
class Turn:
    """A turn of the path, which may be an impact."""

    side: int
    outermost: float
    """Frame of the outermost sample."""
    frame: float


def find_turns(motion: Motion) -> list[Turn]:
    """Find turns deeper than the noise that free fall does not explain, in order of time."""
    depth = HYSTERESIS_SIGMAS * motion.sigma_px
    turns = [
        Turn(side, float(motion.frame[row]), float(motion.frame[row]))
        for side in (-1, 1)
        for row in low_points(-side * motion.place_px, depth)
        if not _falls_back(motion, int(row), side)
    ]
    return sorted(turns, key=lambda turn: turn.frame)


def _falls_back(motion: Motion, row: int, side: int) -> bool:
    """Whether a body turns round there as it does when nothing but its weight acts on it."""
    pull = -side * motion.acceleration
    if pull <= 0:
        return False
    bends = []
    for reach in TURN_PICTURES:
        if reach <= row < len(motion.frame) - reach:
            before, here, after = motion.place_px[[row - reach, row, row + reach]]
            bends.append(-side * (before - 2 * here + after) / reach**2)
    slack = TURN_SIGMAS * np.sqrt(6.0) * motion.sigma_px
    shown = [bend for bend in bends if np.isfinite(bend)]
    return bool(shown) and max(shown) < PULL_AT_MOST * pull + slack


def usual_flight(turns: Sequence[Turn]) -> float:
    """Median time between turns on one side, in pictures; 0 for fewer than two."""
    flights = [
        step
        for side in (-1, 1)
        for step in np.diff([turn.frame for turn in turns if turn.side == side])
    ]
    return float(np.median(flights)) if flights else 0.0

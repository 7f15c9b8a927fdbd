r"""Tell whether the heavy body turned round between two collisions, be it by ever so little.

    heavy           .-^-.
      away       .-'     '        velocity > 0 at the left end, < 0 at the right one:
              .-'         \       it has turned by itself before the ball struck it
             1             2

The paths' low and high points tell a turn once it is as deep as the noise. One that ends at a
contact may be a hundredth of a pixel deep, and still it is where the burst ends; the velocities at
both ends of the flight, by one bent fit, know better. Where even they leave it open, nobody can
tell whether the collision belongs to the burst.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import numpy as np

from count_video.collisions.candidates import Candidate
from count_video.collisions.gaps import Gaps
from count_video.collisions.onesided import BENT_FROM, side_of

Turn = Literal["none", "open", "turned"]

SIGMAS = 4.0
"""A velocity or a change of it counts from this many standard uncertainties on."""


def first_turn(candidates: Sequence[Candidate], gaps: Gaps) -> tuple[float, float]:
    """Find where the heavy body, driven back, turns round between two collisions.

    Returns
    -------
    tuple of float
        Frame of the collision before which it has turned, and frame of the first one of which that
        is open; inf where there is none.
    """
    turned, doubtful = np.inf, np.inf
    for before, after in pairwise(candidates):
        turn = _turn(gaps, (before.frame, after.frame))
        if turn == "open":
            doubtful = min(doubtful, after.frame)
        if turn == "turned":
            turned = after.frame
            break
    return float(turned), float(doubtful)


def _turn(gaps: Gaps, flight: tuple[float, float]) -> Turn:
    """Judge one flight by the heavy body's velocities away from the wall, at both ends."""
    first = _velocity(gaps, flight[0], flight[1])
    last = _velocity(gaps, flight[1], flight[0])
    if first is None or last is None:
        return "none"
    slowed = first[0] - last[0] > SIGMAS * np.hypot(first[1], last[1])
    if first[0] < SIGMAS * first[1] or not slowed or last[0] > SIGMAS * last[1]:
        return "none"
    return "turned" if last[0] < -SIGMAS * last[1] else "open"


def _velocity(gaps: Gaps, about: float, limit: float) -> tuple[float, float] | None:
    """Velocity at one end of a flight and its standard uncertainty; None where it shows no bend."""
    side = side_of(gaps.frame, gaps.heavy_px, about, limit)
    if side is None or side.points < BENT_FROM:
        return None
    return side.slope, float(np.sqrt(side.covariance[1, 1]))

"""When the heavy body turns round by itself, which ends the burst, by its fitted velocities.

Of two collisions shortly before and after the turn, the first belongs to the burst and the second
does not; its places hardly tell, for near the turn it stands still. Its velocities at the
collisions do. Where even they leave it open, the velocity over its uncertainty is the chance of
either.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from count_video.motion.joint import Contacts

SIGMAS = 4.0
"""A velocity or a change of it counts from this many standard uncertainties on."""


@dataclass(frozen=True)
class Turning:
    """Where the heavy body, driven back, turns round by itself between two collisions."""

    before: float
    """Frame of the collision before which it has turned; inf where there is none."""
    open_before: float
    """Frame of an earlier collision before which it may have turned; inf where there is none."""
    chance: float
    """Probability that it has not turned before that one; 1 where there is none."""


def first_turn(contacts: Contacts) -> Turning:
    """Find where the heavy body, driven back, turns round between two collisions."""
    open_before, chance = np.inf, 1.0
    heavy = contacts.bodies[1]
    for number, frame in enumerate(contacts.frame[1:].tolist()):
        first, last = float(heavy.rate[number, 1]), float(heavy.rate[number + 1, 0])
        sigmas = heavy.sigma[number, 1], heavy.sigma[number + 1, 0]
        slowed = first - last > SIGMAS * np.hypot(*sigmas)
        if not slowed or first < SIGMAS * sigmas[0] or last > SIGMAS * sigmas[1]:
            continue
        if last < -SIGMAS * sigmas[1]:
            return Turning(frame, open_before, chance)
        if np.isinf(open_before):
            open_before, chance = frame, math.erfc(-last / sigmas[1] / math.sqrt(2.0)) / 2
    return Turning(np.inf, open_before, chance)

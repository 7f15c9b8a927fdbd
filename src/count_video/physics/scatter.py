"""Restitution that differs from bounce to bounce, from a seed."""

from __future__ import annotations

import numpy as np

from count_video.physics.engine import Restitution
from count_video.physics.setup import Setup
from count_video.records import CollisionKind

_BLOCK = 256
"""Random numbers are drawn so many at a time; it does not change their sequence."""


def draw_restitutions(setup: Setup, seed: int, skip: int) -> Restitution:
    """Return a function that draws one restitution a bounce, going on after ``skip`` bounces.

    One normal number is used for each bounce whatever its kind, so the n-th bounce gets the n-th
    number of the seed's sequence however the run is cut into pieces.
    """
    mean = {"bodies": setup.restitution_bodies, "wall": setup.restitution_wall}
    scatter = {"bodies": setup.restitution_bodies_sd, "wall": setup.restitution_wall_sd}
    if not any(scatter.values()):
        return mean.__getitem__
    rng = np.random.default_rng(seed)
    rng.standard_normal(skip)
    numbers: list[float] = []

    def draw(kind: CollisionKind) -> float:
        if not numbers:
            numbers.extend(rng.standard_normal(_BLOCK)[::-1].tolist())
        return min(1.0, max(0.0, mean[kind] + scatter[kind] * numbers.pop()))

    return draw

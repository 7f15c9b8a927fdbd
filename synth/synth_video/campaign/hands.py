"""How an experimenter's hands scatter from trial to trial, as distributions with seeds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.physics.setup import Setup


@dataclass(frozen=True)
class Hands:
    """What is set by hand before each trial; normal unless said otherwise, in SI units."""

    gap_least_m: float = 0.013
    """No wall gap (ball to wall, at rest) is smaller than this."""
    gap_scale_m: float = 0.014
    """Above the least the gap is exponential with this mean: most are close, now and then one is
    wide. Lossless bodies of 1:100 collide 31 times up to a gap of 3 cm and 28 times at 6."""
    alignment_m: float = 0.0003
    """Standard deviation of the gap between the bodies at rest about 0."""
    release_m: float = 0.09
    release_sd_m: float = 0.002
    thread_m: float = 1.0
    thread_sd_m: float = 0.003
    """Of each body's thread on its own."""
    loss_sd: float = 0.004
    """Restitution of each contact is 1 less the size of a normal number of this deviation."""

    def setup(self, seed: int, trial: int) -> Setup:
        """Draw what is on the table in one trial; each trial has a stream of its own."""
        rng = np.random.default_rng([seed, trial])
        return Setup(
            wall_gap_m=self.gap_least_m + float(rng.exponential(self.gap_scale_m)),
            bodies_gap_m=float(rng.normal(0.0, self.alignment_m)),
            release_m=float(rng.normal(self.release_m, self.release_sd_m)),
            heavy_thread_m=float(rng.normal(self.thread_m, self.thread_sd_m)),
            light_thread_m=float(rng.normal(self.thread_m, self.thread_sd_m)),
            restitution_bodies=1.0 - abs(float(rng.normal(0.0, self.loss_sd))),
            restitution_wall=1.0 - abs(float(rng.normal(0.0, self.loss_sd))),
        )

"""Campaigns whose true counts have a published mean and spread: found, not made.

The physics of a campaign hangs on one seed. ``search`` goes through the seeds from 0 on and
simulates all trials of each until the counts have the figures of the target.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from statistics import fmean, pstdev

from count_video.errors import UsageError
from count_video.physics.simulator import simulate
from synth_video.campaign.hands import Hands


@dataclass(frozen=True)
class Target:
    """A published table, and the hands that are to have made it."""

    trials: int
    maximum: int
    minimum: int
    mean: str
    """As printed, with its decimals."""
    sd_population: str
    """As printed, with its decimals; divided by n."""
    seed: int
    """The first seed that ``search`` finds."""
    hands: Hands = field(default_factory=Hands)

    def met_by(self, counts: Sequence[int]) -> bool:
        """Return whether counts have the figures of the table, as far as they are printed."""
        return (
            len(counts) == self.trials
            and (max(counts), min(counts)) == (self.maximum, self.minimum)
            and _printed(fmean(counts), self.mean) == self.mean
            and _printed(pstdev(counts), self.sd_population) == self.sd_population
        )


CAMPAIGNS: Mapping[str, Target] = {
    "paper-30": Target(
        trials=30, maximum=31, minimum=28, mean="30.57", sd_population="0.80", seed=211
    ),
}
"""Campaigns by name; ``paper-30`` is the paper's result, over 30 trials."""


def target_named(name: str) -> Target:
    """Return a campaign by its name.

    Raises
    ------
    UsageError
        There is no such campaign.
    """
    if name not in CAMPAIGNS:
        raise UsageError(f"no campaign {name!r}; there are: {', '.join(CAMPAIGNS)}")
    return CAMPAIGNS[name]


def true_counts(target: Target, seed: int) -> list[int]:
    """Simulate a campaign; stop at the first count that the target rules out."""
    counts: list[int] = []
    for trial in range(target.trials):
        counts.append(simulate(target.hands.setup(seed, trial), seed=trial).count)
        if not target.minimum <= counts[-1] <= target.maximum:
            break
    return counts


def search(target: Target, first: int = 0) -> int:
    """Return the first seed, from ``first`` on, whose counts meet the target."""
    return next(seed for seed in count(first) if target.met_by(true_counts(target, seed)))


def _printed(value: float, like: str) -> str:
    return f"{value:.{len(like.partition('.')[2])}f}"

"""The nouns of a campaign's reports: a row a trial, and what the trials say together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from count_video.records import Status

SURE = 0.9
"""A count less probable than this needs a person."""
TheorySource = Literal["masses", "measured"]


@dataclass(frozen=True)
class TrialRow:
    """One trial of a campaign, as far as its table needs it."""

    name: str
    """Its result is in ``NAME.json``."""
    clip: str
    status: Status
    count: int | None
    """None where the clip was not counted."""
    chances: Mapping[int, float]
    """Probability of each count; empty where nothing is said."""
    reason: str | None
    """Why it is not counted, or what is doubtful."""
    not_kept: str | None
    """Why the result is not on the disk; None for one that is."""
    seen: int | None
    between_frames: int | None
    capture_fps: float | None
    mass_ratio: float | None
    theory: int | None
    """Exact count of the masses that were given; None where none were."""
    pi_low: float | None
    pi_high: float | None
    restitution_bodies: float | None
    restitution_wall: float | None
    energy_kept: float | None
    """Energy after the burst over the energy before it."""
    ending: str | None
    """How the burst ended: ``geometric``, ``pendulum`` or ``dissipative``; None if unknown."""
    files: frozenset[str] = frozenset()
    """Names of the files that show it, beside the campaign's page."""

    @property
    def probability(self) -> float | None:
        """Probability of the count; None where there is none."""
        return None if self.count is None else self.chances.get(self.count)

    @property
    def needs_a_person(self) -> bool:
        """True for what is not counted, not kept, or less than sure."""
        sure = self.probability is None or self.probability >= SURE
        return self.status != "counted" or self.not_kept is not None or not sure


@dataclass(frozen=True)
class Spread:
    """Mean and spread of a quantity over trials."""

    number: int
    """How many trials tell it."""
    mean: float
    sd: float
    """Population standard deviation."""


@dataclass(frozen=True)
class CampaignSummary:
    """What the trials say together; None where no trial says anything."""

    trials: int
    counted: int
    maximum: int | None
    minimum: int | None
    mean: float | None
    sd_population: float | None
    """Root of the mean squared deviation: divided by n. The paper's standard deviation."""
    sd_sample: float | None
    """Divided by n - 1; None for fewer than two counts."""
    mean_uncertainty: float | None
    """Root mean square error of ``mean`` by the counts' own probabilities; None where a count has
    none."""
    mean_expected: float | None
    """Mean of the counts' expectations by their own probabilities; None where a count has none."""
    histogram: Mapping[int, int]
    """How many trials had each count, from the least to the greatest."""
    theory: int | None
    """Count of lossless bodies of these masses."""
    theory_source: TheorySource | None
    """``masses``: those given, exactly; ``measured``: the median of the measured mass ratios."""
    restitution_bodies: Spread | None
    restitution_wall: Spread | None
    energy_kept: Spread | None
    geometric_share: float | None
    """Share of geometric endings among the trials whose ending is known."""

"""A campaign's trials and what they say together, in figures and in words."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from count_video.inputs import MASS_RATIO
from count_video.physics.theory import collision_count
from count_video.planning.comparison import ratio_range
from count_video.planning.variations import CountFigures
from count_video.reasons import Cause, Reason
from count_video.records import SURE, Estimate, TrialResult
from count_video.reports.words import (
    WIDTH,
    chances_words,
    counts_words,
    percent,
    plural,
    printable,
    ratio_words,
    sentence,
)

NAME_COLUMNS = 24, 60
"""A name has so many columns of the table, at least and at most."""
NEAR_COUNTS, DOTS = 1, f"{'...':>10}"
"""Counts that no trial had are shown so near to others, and what stands for those further off."""
Line = tuple[str, str, str]
"""A label, a value, and a remark beside it."""


@dataclass(frozen=True)
class TrialRow:
    """One trial of a campaign."""

    name: str
    """Name of the trial, whose result is in ``NAME.json``."""
    result: TrialResult
    masses: tuple[Fraction, Fraction] | None = None
    """Heavy and light mass that were given; None where none were."""
    not_kept: str | None = None
    """Why the result is not on the disk; None for one that is."""
    files: frozenset[str] = frozenset()
    """Names of the files that show it, beside the campaign's page."""

    @property
    def missing(self) -> str:
        """Why the count, or its result on the disk, is missing; empty if neither is."""
        if self.result.count is not None and self.not_kept is None:
            return ""
        return self.not_kept or self.result.reason or "not counted"

    @property
    def theory(self) -> int | None:
        """Exact count of the masses that were given; None where none were."""
        return None if self.masses is None else collision_count(*self.masses)

    @property
    def only_theory(self) -> int | None:
        """Count of the masses, given or measured; None where more than one is possible."""
        if self.theory is not None or self.mass_ratio is None:
            return self.theory
        counts = theories_of(self.mass_ratio)
        return counts[0] if len(counts) == 1 else None

    @property
    def mass_ratio(self) -> Estimate | None:
        """Heavy over light, given or measured; None where neither is known."""
        if self.masses is not None:
            return Estimate(float(self.masses[0] / self.masses[1]), 0.0)
        ratio = self.result.ratio
        if ratio is None or not MASS_RATIO.holds(ratio.value):
            return None
        # An uncertainty of nothing but rounding errors is none: the ratio was given.
        known = 1e-9 * ratio.value < ratio.sigma < math.inf
        return ratio if known else Estimate(ratio.value, 0.0)

    @property
    def needs_a_person(self) -> bool:
        """True for what is not counted, not kept, less than sure, or has other masses."""
        others = self.result.contradicting_ratio is not None
        return bool(self.missing) or self.is_unsure or others

    @property
    def is_unsure(self) -> bool:
        """True for a count that is less than sure."""
        return self.result.chance is not None and self.result.chance < SURE

    @property
    def other_masses(self) -> str | None:
        """A sentence if the motion contradicts the masses given; else None."""
        given, shown = self.result.ratio, self.result.contradicting_ratio
        if given is None or shown is None:
            return None
        return sentence(Reason(Cause.MASSES_CONTRADICT, (given.value, shown.value, shown.sigma)))

    @property
    def advice(self) -> str:
        """What a person should do about the trial; empty if nothing."""
        if not self.needs_a_person:
            return ""
        if self.not_kept is not None:
            return "remove what prevented the writing and start the same command again"
        if self.result.frames_decoded is None:
            return "put right what the reason names and start the same command again"
        if self.result.contradicting_ratio is not None and not self.is_unsure:
            return "start again with the masses of these bodies"
        return self.result.what_to_do or "compare the clip with the collisions listed"


@dataclass(frozen=True)
class Spread:
    """Mean and spread of a quantity over trials."""

    number: int
    """Number of trials in which it is known."""
    mean: float
    sd: float
    """Population standard deviation."""


@dataclass(frozen=True)
class Summary(CountFigures):
    """What trials say together; None where no trial says anything."""

    mean_uncertainty: float | None
    """Root mean square error of ``mean`` by the counts' own probabilities; None where a count has
    none."""
    mean_expected: float | None
    """Mean of the counts' expectations by their own probabilities; None where a count has none."""
    theory: int | None
    """Count of lossless bodies of these masses; None where more than one is possible."""
    theory_source: Literal["masses", "measured"] | None
    """``masses``: those given, exactly; ``measured``: the mean of the measured mass ratios."""
    theory_low: int | None
    theory_high: int | None
    """Range of the theory's counts by the uncertainty of the measured mass ratio."""
    mass_ratio: Estimate | None
    """Mass ratio of the bodies; its uncertainty is 0 where it was given."""
    restitution_bodies: Spread | None
    restitution_wall: Spread | None
    energy_kept: Spread | None
    geometric_share: float | None
    """Share of geometric endings among the trials whose ending is known."""

    @property
    def theories(self) -> range:
        """The theory's possible counts; empty where the mass ratio is not known."""
        if self.theory_low is None or self.theory_high is None:
            return range(0)
        return range(self.theory_low, self.theory_high + 1)


@dataclass(frozen=True)
class CampaignSummary:
    """All trials of a campaign, and those of each mass ratio apart."""

    whole: Summary
    groups: tuple[Summary, ...]
    """One for each mass ratio, from the least; the first alone where all bodies are alike."""


def theories_of(ratio: Estimate) -> range:
    """Return the counts of lossless bodies of a measured mass ratio, which is no less than 1."""
    low, high = (max(1.0, one) for one in ratio_range(ratio))
    return range(collision_count(low), collision_count(high) + 1)


def theory_words(summary: Summary) -> str:
    """Say the theory's count, or the counts that the measured ratio leaves open."""
    counts = summary.theories
    return counts_words(counts[0], counts[-1]) if counts else "-"


# ---- text -------------------------------------------------------------------------------------


def name_columns(names: Iterable[str]) -> int:
    """Columns of a table that holds these names."""
    least, most = NAME_COLUMNS
    return min(max([least, *(len(printable(name)) for name in names)]), most)


def trial_heading(columns: int) -> str:
    """Write the heading of the table, whose names have so many columns."""
    return f"{'trial':<{columns}}  count  probability"


def trial_line(row: TrialRow, columns: int = NAME_COLUMNS[0]) -> str:
    """Write one trial as a line of the growing table."""
    count = "-" if row.result.count is None else str(row.result.count)
    chance = "-" if row.result.chance is None else percent(row.result.chance)
    mark = "  needs a person" if row.needs_a_person else ""
    return f"{printable(row.name):<{columns}}  {count:>5}  {chance:>11}{mark}"


def campaign_text(rows: Sequence[TrialRow], summary: CampaignSummary, width: int = WIDTH) -> str:
    """Write the end of a campaign's report: who needs a person first, then the paper's table.

    Sentences are wrapped at ``width`` columns; the table takes 80.
    """
    lines = _doubt_lines(rows, width)
    if len(summary.groups) > 1:
        lines += [entry(*line) for line in summary_lines(summary.whole)[:2]]
    for group in summary.groups:
        if len(summary.groups) > 1:
            lines += ["", f"Mass ratio {ratio_words(group.mass_ratio)}"]
        lines += [entry(*line) for line in summary_lines(group)]
        lines += histogram_lines(group.histogram, group.theories)
    return "\n".join(lines)


def _doubt_lines(rows: Sequence[TrialRow], width: int) -> list[str]:
    doubtful = [row for row in rows if row.needs_a_person]
    if not doubtful:
        return []
    need = "needs" if len(doubtful) == 1 else "need"
    lines = [f"{len(doubtful)} of {plural(len(rows), 'trial')} {need} a person:"]
    for what_to_do in dict.fromkeys(row.advice for row in doubtful):
        said = [f"{row.name}: {_why(row)}" for row in doubtful if row.advice == what_to_do]
        for text in (*said, f"What to do: {what_to_do}."):
            lines += textwrap.wrap(
                printable(text), width, initial_indent="  ", subsequent_indent=" " * 6
            )
    return [*lines, ""]


def _why(row: TrialRow) -> str:
    listed = chances_words(row.result.probability, 4)
    unsure = f"probably {row.result.count} ({listed})" if row.is_unsure else None
    return row.missing or "; ".join(filter(None, (unsure, row.result.reason, row.other_masses)))


def summary_lines(one: Summary) -> list[Line]:
    """List the lines of the paper's table for trials, and of what is known of their bodies."""
    source, beside = "", ""
    if one.theory_source == "measured":
        source = f"(measured mass ratio {ratio_words(one.mass_ratio)})"
    if one.mean_uncertainty is not None:
        beside = f"± {one.mean_uncertainty:.2f} by the counts' own probabilities"
    lines = paper_lines(one, (theory_words(one), source), beside)
    for label, spread in (
        ("Restitution between the bodies", one.restitution_bodies),
        ("Restitution at the wall", one.restitution_wall),
        ("Energy kept", one.energy_kept),
    ):
        if spread is not None:
            several = f"SD {spread.sd:.3f} over {spread.number}"
            beside = several if spread.number > 1 else "of 1 trial"  # which has no spread
            lines.append((label, f"{spread.mean:.3f}", beside))
    if one.geometric_share is not None:
        lines.append(("Geometric endings", f"{one.geometric_share:.0%}", ""))
    return lines


def paper_lines(table: CountFigures, theory: tuple[str, str], beside: str = "") -> list[Line]:
    """List the lines of the paper's table.

    ``theory`` is the theory's count and where it is from; ``beside`` stands beside the mean.
    """
    figures = (
        ("Maximum value", table.maximum, 0, ""),
        ("Minimum value", table.minimum, 0, ""),
        ("Mean value", table.mean, 2, beside),
        ("Standard deviation", table.sd_population, 2, "(population)"),
        ("  of a sample", table.sd_sample, 2, "(divided by n - 1)"),
    )
    return [
        ("Number of trials", str(table.trials), ""),
        ("  of these counted", str(table.counted), ""),
        *((label, "-" if v is None else f"{v:.{n}f}", remark) for label, v, n, remark in figures),
        ("Theory", *theory),
    ]


def histogram_lines(histogram: Mapping[int, int], theories: Sequence[int]) -> list[str]:
    """Draw how many trials had each count, the greatest first; no line for no counts.

    Of many counts in a row that no trial had, nor the theory gives, one line of dots stands for
    all.
    """
    if not histogram:
        return []
    lines = ["", "Collisions  trials"]
    scale = min(1.0, 40 / max(histogram.values()))
    shown = {*histogram, *theories}
    for count in range(max(histogram), min(histogram) - 1, -1):
        number = histogram.get(count, 0)
        if min(abs(count - other) for other in shown) > NEAR_COUNTS:
            if lines[-1] != DOTS:
                lines.append(DOTS)
            continue
        bar = "#" * max(round(number * scale), number > 0)
        mark = "  < theory" if count in theories else ""
        lines.append(f"{count:>10}  {number:>6}  {bar}{mark}".rstrip())
    return lines


def entry(label: str, value: str, note: str = "") -> str:
    """Write one line of the table."""
    return f"{label:<30} {value:>7}  {note}".rstrip()

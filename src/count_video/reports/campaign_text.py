"""A campaign for a person: a line a trial as it comes, then who needs a look, then the table."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

from count_video.reports.campaign_rows import CampaignSummary, Spread, TrialRow
from count_video.reports.printable import printable

WIDTH = 80
_NAME_WIDTH = 24
_LABEL_WIDTH = 30
_BAR_AT_MOST = 40
TRIAL_HEADING = f"{'trial':<{_NAME_WIDTH}}  count  probability"
_NOT_KNOWN = "-"


def trial_line(row: TrialRow) -> str:
    """Write one trial as a line of the growing table."""
    count = _NOT_KNOWN if row.count is None else str(row.count)
    chance = _NOT_KNOWN if row.probability is None else f"{row.probability:.0%}"
    mark = "  needs a person" if row.needs_a_person else ""
    return f"{printable(row.name):<{_NAME_WIDTH}}  {count:>5}  {chance:>11}{mark}"


def advice(row: TrialRow) -> str:
    """Say what a person should do about a trial; empty if nothing."""
    if not row.needs_a_person:
        return ""
    if row.not_kept is not None:
        return "see to what hindered the writing and start the same command again"
    if row.status == "counted":
        return "look at the clip and compare with the listed collisions (count-video CLIP)"
    return (
        "look at the clip; if it shows the trial, tell where with start, end and region or name "
        "the wall's side, or film it again at a higher rate"
    )


def campaign_text(rows: Sequence[TrialRow], summary: CampaignSummary) -> str:
    """Write the end of a campaign's report: who needs a person first, then the paper's table."""
    return "\n".join([*_doubt_lines(rows), *_table_lines(summary), *_physics_lines(summary)])


def _doubt_lines(rows: Sequence[TrialRow]) -> list[str]:
    doubtful = [row for row in rows if row.needs_a_person]
    if not doubtful:
        return []
    lines = [f"{len(doubtful)} of {len(rows)} trials need a person:"]
    for what_to_do in dict.fromkeys(map(advice, doubtful)):
        for row in doubtful:
            if advice(row) == what_to_do:
                lines += _wrapped(f"{row.name}: {_why(row)}", "  ", "      ")
        lines += _wrapped(f"What to do: {what_to_do}.", "  ", "      ")
    return [*lines, ""]


def _why(row: TrialRow) -> str:
    if row.not_kept is not None:
        return row.not_kept
    if row.status == "counted":
        chances = sorted(row.chances.items(), key=lambda item: -item[1])
        listed = ", ".join(f"{count}: {chance:.0%}" for count, chance in chances[:4])
        return "; ".join(filter(None, (f"probably {row.count} ({listed})", row.reason)))
    return row.reason or "not counted"


def _table_lines(summary: CampaignSummary) -> list[str]:
    theory = "" if summary.theory_source != "measured" else " (of the measured mass ratio)"
    lines = [
        entry("Number of trials", str(summary.trials)),
        entry("  of these counted", str(summary.counted)),
        entry("Maximum value", _number(summary.maximum)),
        entry("Minimum value", _number(summary.minimum)),
        entry("Mean value", _number(summary.mean, 2), _plus_minus(summary.mean_uncertainty)),
        entry("Standard deviation", _number(summary.sd_population, 2), "(population)"),
        entry("  of a sample", _number(summary.sd_sample, 2), "(divided by n - 1)"),
        entry("Theory", _number(summary.theory), theory.strip()),
    ]
    return [*lines, *histogram_lines(summary.histogram, summary.theory)]


def histogram_lines(histogram: Mapping[int, int], theory: int | None) -> list[str]:
    """Draw how many trials had each count, the greatest first; no line for no counts."""
    if not histogram:
        return []
    lines = ["", "Collisions  trials"]
    scale = min(1.0, _BAR_AT_MOST / max(histogram.values()))
    for count in range(max(histogram), min(histogram) - 1, -1):
        number = histogram.get(count, 0)
        bar = "#" * max(round(number * scale), number > 0)
        mark = "  < theory" if count == theory else ""
        lines.append(f"{count:>10}  {number:>6}  {bar}{mark}".rstrip())
    return lines


def _physics_lines(summary: CampaignSummary) -> list[str]:
    told = [
        ("Restitution between the bodies", summary.restitution_bodies),
        ("Restitution at the wall", summary.restitution_wall),
        ("Energy kept", summary.energy_kept),
    ]
    lines = [entry(label, *_spread_words(spread)) for label, spread in told if spread is not None]
    if summary.geometric_share is not None:
        lines.append(entry("Geometric endings", f"{summary.geometric_share:.0%}"))
    return ["", *lines] if lines else []


def _spread_words(spread: Spread) -> tuple[str, str]:
    return f"{spread.mean:.3f}", f"SD {spread.sd:.3f} over {spread.number}"


def entry(label: str, value: str, note: str = "") -> str:
    """Write one line of the table."""
    return f"{label:<{_LABEL_WIDTH}} {value:>7}  {note}".rstrip()


def _number(value: float | None, decimals: int = 0) -> str:
    return _NOT_KNOWN if value is None else f"{value:.{decimals}f}"


def _plus_minus(uncertainty: float | None) -> str:
    if uncertainty is None:
        return ""
    return f"± {uncertainty:.2f} by the counts' own probabilities"


def _wrapped(text: str, first: str, rest: str) -> list[str]:
    return textwrap.wrap(printable(text), WIDTH, initial_indent=first, subsequent_indent=rest)

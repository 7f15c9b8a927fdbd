"""The trials of a campaign as a table for spreadsheets."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from count_video.reports.campaign_rows import TrialRow
from count_video.reports.campaign_text import advice
from count_video.reports.printable import printable

COLUMNS = (
    *("name", "clip", "status", "count", "probability", "needs_a_person", "reason", "what_to_do"),
    *("seen", "between_frames", "capture_fps", "theory", "mass_ratio", "pi_low", "pi_high"),
    *("restitution_bodies", "restitution_wall", "energy_kept", "ending"),
)


def trials_csv(rows: Sequence[TrialRow]) -> str:
    """Write the rows as CSV, those that need a person first; what is not known is an empty cell."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in doubtful_first(rows):
        writer.writerow([_cell(value) for value in _values(row)])
    return text.getvalue()


def doubtful_first(rows: Sequence[TrialRow]) -> list[TrialRow]:
    """Put the rows that need a person first; else the order stays."""
    return sorted(rows, key=lambda row: not row.needs_a_person)


def _values(row: TrialRow) -> list[object]:
    reasons = "; ".join(filter(None, (row.reason, row.not_kept)))
    return [
        *(row.name, row.clip, row.status, row.count, row.probability),
        *("yes" if row.needs_a_person else "no", reasons, advice(row)),
        *(row.seen, row.between_frames, row.capture_fps, row.theory, row.mass_ratio),
        *(row.pi_low, row.pi_high, row.restitution_bodies, row.restitution_wall),
        *(row.energy_kept, row.ending),
    ]


def _cell(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.6g}"
    text = printable(str(value))
    # A spreadsheet would run a cell that begins so as a formula; a clip's name is only text.
    return f"'{text}" if text[:1] in ("=", "+", "-", "@") else text

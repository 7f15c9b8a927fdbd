"""A campaign's summary for a program: one JSON object with stable keys.

What is not known is ``null``; a key is never left out. Keys may be added; when one is renamed,
removed or changes its meaning, ``SCHEMA_VERSION`` grows.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

from count_video.reports.campaign_rows import CampaignSummary, Spread, TrialRow
from count_video.reports.campaign_text import advice

SCHEMA_VERSION = 1


def campaign_json(rows: Sequence[TrialRow], summary: CampaignSummary) -> str:
    """Write the summary and the trials that need a person as JSON text."""
    told = {
        "schema_version": SCHEMA_VERSION,
        "trials": summary.trials,
        "counted": summary.counted,
        "maximum": summary.maximum,
        "minimum": summary.minimum,
        "mean": summary.mean,
        "sd_population": summary.sd_population,
        "sd_sample": summary.sd_sample,
        "mean_uncertainty": summary.mean_uncertainty,
        "mean_expected": summary.mean_expected,
        "theory": summary.theory,
        "theory_source": summary.theory_source,
        "histogram": {str(count): number for count, number in summary.histogram.items()},
        "restitution_bodies": _spread(summary.restitution_bodies),
        "restitution_wall": _spread(summary.restitution_wall),
        "energy_kept": _spread(summary.energy_kept),
        "geometric_share": summary.geometric_share,
        "need_a_person": [_doubt(row) for row in rows if row.needs_a_person],
    }
    return json.dumps(told, indent=1, allow_nan=False) + "\n"


def _spread(spread: Spread | None) -> dict[str, object] | None:
    if spread is None:
        return None
    return {"number": spread.number, "mean": spread.mean, "sd": spread.sd}


def _doubt(row: TrialRow) -> dict[str, object]:
    return {
        "name": _text(row.name),
        "clip": row.clip,
        "status": row.status,
        "count": row.count,
        "probability": row.probability,
        "reason": row.not_kept or row.reason,
        "what_to_do": advice(row),
    }


def _text(text: str) -> str:
    return text.encode("utf-8", "backslashreplace").decode("utf-8")

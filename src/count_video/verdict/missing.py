"""How sure a count is of a clip that is known to lack pictures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from count_video.records import FootageReport, TrialResult


def with_missing(
    probability: Mapping[int, float], count: int, report: FootageReport
) -> dict[int, float]:
    """Let collisions happen in the pictures that are missing as often as in those that are there.

    They come at random then (Poisson): the chance that none is missing is exp(-expected), and what
    this takes from the chances is that of one more.
    """
    expected = count * report.frames_missing / max(1, report.frames_decoded)
    none = math.exp(-expected)
    changed = {number: chance * none for number, chance in probability.items()}
    if expected:
        changed[count + 1] = changed.get(count + 1, 0.0) + (1 - none) * sum(probability.values())
    return changed


def doubted_for_missing(result: TrialResult, report: FootageReport) -> TrialResult:
    """Doubt a count where pictures are missing and nothing says that the burst was over."""
    if result.count is None or result.ending is not None or not report.frames_missing:
        return result
    missing = f"{report.frames_missing} frames are missing, in which collisions may have happened"
    return replace(
        result,
        reason="; ".join(filter(None, (result.reason, missing))),
        probability=with_missing(result.probability, result.count, report),
    )

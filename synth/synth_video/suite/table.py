"""Scores gathered into cells, one for each condition and strength, as Markdown and as JSON."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import groupby

import numpy as np

from synth_video.suite.scoring import ClipScore
from synth_video.suite.suites import Label, label_of


@dataclass(frozen=True)
class Cell:
    """What became of all clips of one condition and strength."""

    condition: str
    strength: str
    clips: int
    exact: int
    not_counted: int
    wrong: int
    confidently_wrong: int
    missed: int
    """Of counted clips, as all below."""
    invented: int
    wrong_kind: int
    time_error_median_frames: float | None
    time_error_p95_frames: float | None
    place_offset_px: float | None
    """Of the ball's centre at collisions: median over the clips of the size of a clip's mean error,
    which is where the centre is taken to be."""
    place_scatter_px: float | None
    """The same, RMS about each clip's mean: how well the ball was followed."""


def cells_of(scores: Sequence[ClipScore]) -> list[Cell]:
    """Gather the scores of each condition and strength, in the order of the clips."""
    groups = groupby(scores, lambda score: label_of(score.clip))
    return [_cell(label, list(group)) for label, group in groups]


def total_of(scores: Sequence[ClipScore]) -> Cell:
    """Gather all scores."""
    return _cell(Label("all", ""), scores)


def markdown(scores: Sequence[ClipScore]) -> str:
    """Write a table, a line a cell, with the sum below."""
    rows = [[name for name, _, _ in _COLUMNS], [align for _, align, _ in _COLUMNS]]
    for cell in (*cells_of(scores), total_of(scores)):
        rows.append([text(cell) for _, _, text in _COLUMNS])
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def shortfalls(scores: Sequence[ClipScore]) -> str:
    """Write a line for each clip that is not exact: truth, answer and reason."""
    return "".join(_shortfall(score) for score in scores if score.outcome != "exact")


def scores_json(scores: Sequence[ClipScore]) -> str:
    """Write cells and single scores as JSON text."""
    gathered = {
        "total": asdict(total_of(scores)),
        "cells": [asdict(cell) for cell in cells_of(scores)],
        "clips": [asdict(score) for score in scores],
    }
    return json.dumps(gathered, indent=1) + "\n"


def _cell(label: Label, scores: Sequence[ClipScore]) -> Cell:
    def how_many(outcome: str) -> int:
        return sum(score.outcome == outcome for score in scores)

    late = np.abs([error for score in scores for error in score.time_errors_frames])
    off = [np.array(score.position_errors_px) for score in scores if score.position_errors_px]
    about = np.concatenate([np.zeros(0), *(errors - errors.mean() for errors in off)])
    return Cell(
        condition=label.condition,
        strength=label.strength,
        clips=len(scores),
        exact=how_many("exact"),
        not_counted=how_many("not_counted"),
        wrong=how_many("wrong"),
        confidently_wrong=sum(score.confidently_wrong for score in scores),
        missed=sum(score.missed for score in scores),
        invented=sum(score.invented for score in scores),
        wrong_kind=sum(score.wrong_kind for score in scores),
        time_error_median_frames=float(np.median(late)) if late.size else None,
        time_error_p95_frames=float(np.percentile(late, 95)) if late.size else None,
        place_offset_px=float(np.median([abs(errors.mean()) for errors in off])) if off else None,
        place_scatter_px=float(np.sqrt(np.mean(about**2))) if off else None,
    )


def _shortfall(score: ClipScore) -> str:
    truth = f"true count {score.true_count}" if score.countable else "cannot be counted"
    if score.found_count is None:
        return f"- {score.clip}: {truth}; not counted: {score.reason}\n"
    chance = "unknown" if score.probability is None else f"{score.probability:.0%}"
    return (
        f"- {score.clip}: {truth}; counted {score.found_count} with probability {chance}, "
        f"{score.missed} missed, {score.invented} invented, {score.wrong_kind} of a wrong kind\n"
    )


def _decimals(value: float | None) -> str:
    return "" if value is None else f"{value:.3f}"


_COLUMNS: Sequence[tuple[str, str, Callable[[Cell], str]]] = (
    ("Condition", "---", lambda cell: cell.condition),
    ("Strength", "---", lambda cell: cell.strength),
    ("Clips", "---:", lambda cell: str(cell.clips)),
    ("Exact", "---:", lambda cell: str(cell.exact)),
    ("Not counted", "---:", lambda cell: str(cell.not_counted)),
    ("Wrong", "---:", lambda cell: str(cell.wrong)),
    ("Confidently wrong", "---:", lambda cell: str(cell.confidently_wrong)),
    ("Missed", "---:", lambda cell: str(cell.missed)),
    ("Invented", "---:", lambda cell: str(cell.invented)),
    ("Wrong kind", "---:", lambda cell: str(cell.wrong_kind)),
    ("Time error, median", "---:", lambda cell: _decimals(cell.time_error_median_frames)),
    ("95 %", "---:", lambda cell: _decimals(cell.time_error_p95_frames)),
    ("Centre, px", "---:", lambda cell: _decimals(cell.place_offset_px)),
    ("Scatter, px", "---:", lambda cell: _decimals(cell.place_scatter_px)),
)

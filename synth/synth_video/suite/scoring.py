"""Answers against truths: collisions matched one to one, clip by clip, and from files."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import Any, Literal

import numpy as np
from scipy.optimize import linear_sum_assignment

from count_video.errors import UsageError
from count_video.records import Floats

# ---- matching ------------------------------------------------------------------------------------
# Which collision found is which of the truth.
#
# Both are places on the axis of frames. A pair may be matched when it lies within the window of the
# true collision::
#
#     truth       |        |            |
#     window    [---]    [---]       [--+--]
#     found      x     x   x x
#                1         2              3     1 and 2 matched, 3 missed, two found are invented
#
# As many as possible are matched, each at most once, and among such matchings the one with the
# smallest sum of squared distances. Squares keep the order of time: two pairs that cross cost more
# than the same four uncrossed.

LEAST_WINDOW_FRAMES = 1.25
"""Half of the 2.5 frames by which resolved collisions are apart at least."""
MOST_WINDOW_FRAMES = 6.0
"""A collision that lies far from all others is still not found this far off: bodies that creep
together at a hundredth of a pixel a frame meet within a few frames, no more."""


def windows(true_frames: Sequence[float]) -> Floats:
    """Reach of each true collision: half the way to its nearest neighbour, within the limits."""
    frames = np.asarray(true_frames, dtype=float)
    gaps = np.concatenate([[np.inf], np.diff(frames), [np.inf]])
    half = np.minimum(gaps[:-1], gaps[1:]) / 2
    return np.asarray(np.clip(half[: len(frames)], LEAST_WINDOW_FRAMES, MOST_WINDOW_FRAMES))


def match(true_frames: Sequence[float], found_frames: Sequence[float]) -> list[tuple[int, int]]:
    """Pair true and found collisions.

    Parameters
    ----------
    true_frames, found_frames
        Frame coordinates, each in order of time.

    Returns
    -------
    list of (int, int)
        Places in the two sequences, in order of time.
    """
    if not (len(true_frames) and len(found_frames)):
        return []
    true, found = np.asarray(true_frames, dtype=float), np.asarray(found_frames, dtype=float)
    apart = np.abs(true[:, None] - found)
    possible = apart <= windows(true_frames)[:, None]
    # A pair beyond the window costs more than all others together, so none is taken needlessly.
    forbidden = (len(true) + 1) * MOST_WINDOW_FRAMES**2
    rows, columns = linear_sum_assignment(np.where(possible, apart**2, forbidden))
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return [(row, column) for row, column in pairs if possible[row, column]]


# ---- one clip ------------------------------------------------------------------------------------
# One clip's answer against its truth.
#
# The conventions, once: truth comes before found; times are frame coordinates, and an error is
# found less true; what does not apply is None, and no pair has no error.

Outcome = Literal["exact", "not_counted", "wrong"]
CONFIDENT = 0.9
"""A wrong count with a probability above this is the worst that can happen."""


@dataclass(frozen=True)
class ClipScore:
    """How well one clip was counted."""

    clip: str
    """Name without folder and suffix."""
    countable: bool
    """Whether the clip shows what a count needs."""
    true_count: int
    found_count: int | None
    """None without a count."""
    outcome: Outcome
    """``exact``: the count is right, or rightly missing; ``not_counted``: a count was due."""
    confidently_wrong: bool
    probability: float | None
    """Of the count; None without one."""
    missed: int
    """True collisions without a partner. This and all below is of counted clips; else 0 or ()."""
    invented: int
    """Found collisions without a partner."""
    wrong_kind: int
    """Pairs of different kinds."""
    time_errors_frames: tuple[float, ...]
    """Of each pair, in order of time."""
    position_errors_px: tuple[float, ...]
    """Of the ball's centre at each pair's collision, where the truth has it."""
    reason: str | None
    """What was said against a count."""


def score(clip: str, truth: Mapping[str, Any], found: Mapping[str, Any]) -> ClipScore:
    """Compare what ``count-video --json`` said of a clip with its truth.

    Parameters
    ----------
    clip
        The clip's name.
    truth
        Object of the clip's ``.truth.json``: ``count`` and ``events``; ``expect`` and ``accept``
        (counts that are right) where it has them.
    found
        Object that the command printed.
    """
    counted = found["status"] == "counted"
    count = found["count"] if counted else None
    chance = found["probability"].get(str(count)) if counted else None
    outcome = _outcome(truth, count)
    true_events = truth.get("events", [])
    hits = found["collisions"][:count] if counted else []
    pairs = [
        (true_events[i], hits[j])
        for i, j in match([e["frame"] for e in true_events], [h["frame"] for h in hits])
    ]
    placed = [(e, h) for e, h in pairs if _has_place(e, h)]
    return ClipScore(
        clip=clip,
        countable=_countable(truth),
        true_count=truth["count"],
        found_count=count,
        outcome=outcome,
        confidently_wrong=outcome == "wrong" and (chance is None or chance > CONFIDENT),
        probability=chance,
        missed=len(true_events) - len(pairs) if counted else 0,
        invented=len(hits) - len(pairs),
        wrong_kind=sum(event["kind"] != hit["kind"] for event, hit in pairs),
        time_errors_frames=tuple(hit["frame"] - event["frame"] for event, hit in pairs),
        position_errors_px=tuple(h["position_px"] - e["ball_px"] for e, h in placed),
        reason=found["reason"],
    )


def _countable(truth: Mapping[str, Any]) -> bool:
    return bool(truth.get("expect", "counted") == "counted")


def _outcome(truth: Mapping[str, Any], count: int | None) -> Outcome:
    if count is None:
        return "not_counted" if _countable(truth) else "exact"
    if not _countable(truth):
        # No collision at all is as true of such a clip as no answer.
        return "exact" if count in truth.get("accept", [0]) else "wrong"
    return "exact" if count in truth.get("accept", [truth["count"]]) else "wrong"


def _has_place(event: Mapping[str, Any], hit: Mapping[str, Any]) -> bool:
    return event.get("ball_px") is not None and hit.get("position_px") is not None


# ---- files ---------------------------------------------------------------------------------------
# Read truths and answers from their files, and score each clip that has both.

RESULTS = "results.jsonl"
NO_ANSWER: dict[str, Any] = {
    "status": "not_counted",
    "reason": "there is no answer",
    "count": None,
    "probability": {},
    "collisions": [],
}
_TRUTH = ".truth.json"


def score_folder(folder: Path, results: Path) -> list[ClipScore]:
    """Score all clips of a folder, sorted by name; a clip without an answer is not counted.

    Parameters
    ----------
    folder
        Holds a ``NAME.truth.json`` for each clip.
    results
        What ``count-video --json`` printed: one object a line.

    Raises
    ------
    UsageError
        A file cannot be read, or there is nothing to score.
    """
    answers = _answers(results)
    truths = sorted(folder.glob(f"*{_TRUTH}"))
    if not truths:
        raise UsageError(f"{folder} holds no truths ({_TRUTH}); name the folder of a suite")
    names = [truth.name.removesuffix(_TRUTH) for truth in truths]
    if not answers.keys() & set(names):
        raise UsageError(f"{results} has no answer for any clip; {how_to_count(folder)}")
    return [
        score(name, _object(truth.read_text("utf-8"), truth), answers.get(name, NO_ANSWER))
        for name, truth in zip(names, truths, strict=True)
    ]


def how_to_count(folder: Path) -> str:
    """Return the command that makes the answers."""
    return f"count the clips with: count-video --json {folder} > {folder / RESULTS}"


def _answers(results: Path) -> dict[str, dict[str, Any]]:
    """Answers by the clip's name, without folder and suffix; the last of several holds."""
    try:
        lines = results.read_text("utf-8").splitlines()
    except OSError as error:
        advice = how_to_count(results.parent)
        raise UsageError(f"cannot read {results}: {error.strerror}; {advice}") from error
    objects = [_object(line, results) for line in lines if line.strip()]
    return {PurePath(found["clip"]).stem: found for found in objects}


def _object(text: str, source: Path) -> dict[str, Any]:
    try:
        found = json.loads(text)
    except ValueError as error:
        raise UsageError(f"{source} is no JSON: {error}; make it again") from error
    if not isinstance(found, dict):
        raise UsageError(f"{source} does not hold objects; make it again")
    return found

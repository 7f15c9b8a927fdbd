"""One clip's answer against its truth.

The conventions, once: truth comes before found; times are frame coordinates, and an error is found
less true; what does not apply is None, and no pair has no error.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from synth_video.suite.matching import match

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

"""Clips with their truth, what the command answers to them, and how far the two agree."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

from count_video.cli import EXIT_COUNTED, EXIT_NOT_COUNTED, main

FIXTURES = Path(__file__).parents[2] / "fixtures"
MEDIAN_TIME_ERROR_FRAMES = 0.25
"""A tenth of the shortest interval that counts as resolved, 2.5 frames."""

Answer = dict[str, Any]
Truth = dict[str, Any]


def fixture_clips() -> list[Path]:
    """All fixtures, sorted by name."""
    return sorted(FIXTURES.glob("*.mp4"))


def truth_of(clip: Path) -> Truth:
    """What a clip really shows, from the file beside it."""
    text = clip.with_suffix(".truth.json").read_text("utf-8")
    truth: Truth = json.loads(text)
    return truth


@cache
def answer(clip: Path, *options: str) -> Answer:
    """What ``count-video --json`` says of one clip; its exit code must fit."""
    out = io.StringIO()
    with redirect_stdout(out), redirect_stderr(io.StringIO()):
        code = main(["--json", *options, str(clip)])
    (line,) = out.getvalue().splitlines()
    said: Answer = json.loads(line)
    assert code == (EXIT_COUNTED if said["status"] == "counted" else EXIT_NOT_COUNTED)
    return said


def burst(said: Answer) -> list[dict[str, Any]]:
    """The collisions that make up the count, in order of time."""
    collisions: list[dict[str, Any]] = said["collisions"]
    return collisions[: said["count"]]


def time_errors(events: Sequence[Truth], said: Answer) -> list[float]:
    """Distance in frames of each collision of the burst from its true place."""
    return [
        abs(event["frame"] - collision["frame"])
        for event, collision in zip(events, burst(said), strict=True)
    ]


def assert_counted(said: Answer, truth: Truth, *, first_frame: float = 0.0) -> None:
    """Check count, kinds and times against the truth; the clip began at ``first_frame`` of it."""
    events = [{**event, "frame": event["frame"] - first_frame} for event in truth["events"]]
    assert (said["status"], said["count"]) == ("counted", truth["count"]), said["reason"]
    assert [c["kind"] for c in burst(said)] == [event["kind"] for event in events]
    errors = time_errors(events, said)
    assert median(errors) <= MEDIAN_TIME_ERROR_FRAMES
    # Each lies nearer to its own collision than to any other, or another one was found.
    reaches = half_intervals([event["frame"] for event in events])
    assert [e for e, reach in zip(errors, reaches, strict=True) if e >= reach] == []


def half_intervals(frames: Sequence[float]) -> list[float]:
    """Half the distance from each collision to its nearest neighbour."""
    gaps = [b - a for a, b in pairwise(frames)]
    nearest = map(min, [float("inf"), *gaps], [*gaps, float("inf")])
    return [gap / 2 for gap in nearest]

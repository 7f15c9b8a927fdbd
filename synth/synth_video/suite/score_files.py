"""Read truths and answers from their files, and score each clip that has both."""

from __future__ import annotations

import json
from pathlib import Path, PurePath
from typing import Any

from count_video.errors import UsageError
from synth_video.suite.scoring import ClipScore, score

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

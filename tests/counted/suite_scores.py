"""Clips and tracks of the suite and their scores on file: run this file to write the scores anew.

python tests/counted/suite_scores.py
"""

from __future__ import annotations

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import stored_tracks
from counting import answer, truth_of

from synth_video.film import render_clip
from synth_video.suite.condition import Strength
from synth_video.suite.scoring import ClipScore, score
from synth_video.suite.suites import Take, conditions_of

CLIPS_FILE = Path(__file__).with_name("suite_scores.json")
TRACKS_FILE = Path(__file__).with_name("suite_track_scores.json")
CHOSEN: tuple[tuple[str, Strength, int], ...] = (
    ("noise", "ordinary", 0),
    ("contrast", "ordinary", 0),
    ("flicker", "ordinary", 5),
    ("drift", "ordinary", 3),
    ("shake", "ordinary", 4),
    ("perspective", "full", 2),
    ("blur", "full", 1),
    ("compressed", "full", 5),
    ("copies", "full", 2),
    ("ramp", "full", 1),
    ("late", "full", 2),
    ("early", "full", 0),
)
"""Short clips, of conditions that fail in different ways."""
OUTCOMES = ("confidently_wrong", "wrong", "not_counted", "exact")
"""From the worst to the best."""

Record = dict[str, Any]


def takes() -> list[Take]:
    """The chosen clips."""
    return [Take(conditions_of("all", [name])[0], s, number) for name, s, number in CHOSEN]


def scored(take: Take, folder: Path) -> ClipScore:
    """Render a clip, count it, and compare."""
    clip = folder / take.name
    render_clip(take.scene, take.seed, clip)
    return score(clip.stem, truth_of(clip), answer(clip))


def record_of(found: ClipScore) -> Record:
    """What is kept of a score."""
    errors = [abs(error) for error in found.time_errors_frames]
    return {
        "outcome": "confidently_wrong" if found.confidently_wrong else found.outcome,
        "wrong_kind": found.wrong_kind,
        "mean_time_error_frames": round(sum(errors) / len(errors), 4) if errors else None,
    }


def on_file(file: Path) -> dict[str, Record]:
    """The scores on file by the clip's name."""
    kept: dict[str, Record] = json.loads(file.read_text("utf-8"))
    return kept


def write_anew() -> None:
    """Score the chosen clips and all stored tracks, and put the scores on file."""
    with TemporaryDirectory() as folder:
        _put_on_file(CLIPS_FILE, [scored(take, Path(folder)) for take in takes()])
    tracks = stored_tracks.on_file().values()
    _put_on_file(TRACKS_FILE, [stored_tracks.counted(track) for track in tracks])


def _put_on_file(file: Path, found: list[ClipScore]) -> None:
    kept = {one.clip: record_of(one) for one in found}
    lines = ",\n".join(f' "{name}": {json.dumps(record)}' for name, record in kept.items())
    file.write_text(f"{{\n{lines}\n}}\n", "utf-8")


if __name__ == "__main__":
    write_anew()

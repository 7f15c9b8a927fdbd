"""Every fixture, through the whole command, against its truth and what docs/ say of it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from accuracy import errors_frames, resolved_clips
from counting import Truth, answer, assert_counted, burst, fixture_clips, truth_of

from pages import page, section

CLIPS = fixture_clips()
RESOLVED = resolved_clips()
UNRESOLVED = [clip for clip in CLIPS if clip not in RESOLVED]
SLOW = {"ratio100-count29", "plain-table1"}
"""Resolved clips at 1:100, which take long; a third, ratio100-count31, is counted every time."""
SCALE_ERROR = 0.04
"""Of the ball's diameter: its rim is blurred by about a pixel at either side, of fifty or more."""
ONE_FRAME = 1.0
"""Of collisions that follow each other faster, no frame lies in the flights between them."""
STANDARDISED_AT_MOST = 1.5
"""RMS of errors over their uncertainties; 1 if these are true. Neighbours share what is known of
the motion, so of thirty errors only some five are independent: one in a hundred has more."""
SAME_ERROR_FRAMES = 0.05
"""Another machine's rounding and another build's decoder move a time by less."""
ACCURACY_ROW = re.compile(
    r"^\| `(?P<clip>[\w.-]+)` \| (?P<true>\d+) \| (?P<counted>\d+) \| (?P<median>[\d.]+) frames "
    r"\| (?P<largest>[\d.]+) frames \|$",
    re.MULTILINE,
)


def cases(clips: Iterable[Path]) -> list[Any]:
    """Clips as the cases of a test; those that take long run with the slow ones."""
    return [
        pytest.param(clip, id=clip.stem, marks=[pytest.mark.slow] if clip.stem in SLOW else [])
        for clip in clips
    ]


def test_the_fixtures_hold_the_counts_that_they_are_for() -> None:
    truths = [truth_of(clip) for clip in RESOLVED]
    known = {(round(truth["mass_ratio"]), truth["count"]) for truth in truths}
    assert known >= {(1, 3), (16, 12), (100, 31), (100, 29)}


@pytest.mark.parametrize("clip", cases(RESOLVED))
def test_a_resolved_clip_is_counted_exactly_with_kinds_and_times(clip: Path) -> None:
    assert_counted(answer(clip), truth_of(clip))


@pytest.mark.parametrize("clip", cases(RESOLVED))
def test_what_a_resolved_clip_shows_was_seen_and_nothing_made_up(clip: Path) -> None:
    said, truth = answer(clip), truth_of(clip)
    assert (said["seen"], said["between_frames"]) == (truth["count"], 0)
    assert all(collision["seen"] for collision in burst(said))
    assert said["count_after_burst"] == len(truth["events_after_burst"])
    assert said["frames_decoded"] == said["frames_promised"] == len(truth["frames"])
    assert said["wall_side"] == wall_side(truth)
    assert max(said["probability"], key=said["probability"].__getitem__) == str(truth["count"])


@pytest.mark.parametrize("clip", cases(UNRESOLVED))
def test_an_unresolved_clip_is_counted_right_or_said_to_be_in_doubt(clip: Path) -> None:
    said = answer(clip)
    in_doubt = said["status"] == "not_counted" and said["count"] is None and said["reason"]
    assert in_doubt or said["count"] == truth_of(clip)["count"]


@pytest.mark.parametrize("clip", cases(UNRESOLVED))
def test_an_unresolved_clip_claims_to_have_seen_what_its_frames_show(clip: Path) -> None:
    said = answer(clip)
    if said["count"] is None:
        pytest.skip("not counted: nothing is claimed")
    stated, true = burst(said), [event["frame"] for event in truth_of(clip)["events"]]
    assert (said["seen"], said["between_frames"]) == (
        sum(one["seen"] for one in stated),
        sum(not one["seen"] for one in stated),
    )
    between = zip(true, true[1:], true[2:], strict=False)
    close = [n for n, (a, b, c) in enumerate(between, 1) if max(b - a, c - b) < ONE_FRAME]
    assert not any(stated[n]["seen"] for n in close)
    errors = [
        (one["frame"] - at) / one["frame_sigma"] for one, at in zip(stated, true, strict=True)
    ]
    assert np.sqrt(np.mean(np.square(errors))) < STANDARDISED_AT_MOST


@pytest.mark.parametrize("clip", cases(CLIPS))
def test_the_scale_comes_from_the_ball(clip: Path) -> None:
    said, truth = answer(clip), truth_of(clip)
    diameter_px = ball_diameter_px(truth)
    assert said["ball_diameter_px"] == pytest.approx(diameter_px, rel=SCALE_ERROR)
    assert said["millimetres_per_px"] == pytest.approx(40.0 / said["ball_diameter_px"])


def test_the_command_as_a_process_counts_a_folder_one_line_a_clip(tmp_path: Path) -> None:
    shortest = min(RESOLVED, key=lambda clip: len(truth_of(clip)["frames"]))
    for name in ("one.mp4", "two.mp4"):
        shutil.copy(shortest, tmp_path / name)
    command = [sys.executable, "-m", "count_video", "--json", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    said = [json.loads(line) for line in done.stdout.splitlines()]
    counts = [(Path(one["clip"]).name, one["count"]) for one in said]
    assert counts == [(name, truth_of(shortest)["count"]) for name in ("one.mp4", "two.mp4")]
    assert done.stderr == ""


def table_of_accuracy() -> dict[str, re.Match[str]]:
    return {row["clip"]: row for row in ACCURACY_ROW.finditer(page("docs/accuracy.md"))}


def test_the_table_of_accuracy_has_every_resolved_clip() -> None:
    rows = table_of_accuracy()
    assert sorted(rows) == [clip.name for clip in RESOLVED]
    assert all(int(rows[clip.name]["true"]) == truth_of(clip)["count"] for clip in RESOLVED)


@pytest.mark.parametrize("clip", cases(RESOLVED))
def test_the_table_of_accuracy_promises_no_more_than_is_measured(clip: Path) -> None:
    row = table_of_accuracy()[clip.name]
    assert int(row["counted"]) == answer(clip)["count"]
    middle, largest = errors_frames(clip)
    assert middle <= float(row["median"]) + SAME_ERROR_FRAMES
    assert largest <= float(row["largest"]) + 2 * SAME_ERROR_FRAMES


def test_every_key_of_the_json_object_is_documented() -> None:
    said = answer(resolved_clips()[0])
    documented = set(re.findall(r"`(\w+)`", section("docs/result.md", "The JSON object")))
    assert set(said) | set(said["collisions"][0]) <= documented


def wall_side(truth: Truth) -> str:
    """Side of the wall: stated, or where it stands from the ball."""
    frame = truth["frames"][0]
    if "wall_side" in truth:
        return str(truth["wall_side"])
    return "left" if frame["wall"][0] < frame["ball_centre"][0] else "right"


def ball_diameter_px(truth: Truth) -> float:
    """Diameter of the ball: stated, or from its outline at rest."""
    if "ball_diameter_px" in truth:
        return float(truth["ball_diameter_px"])
    frame = truth["frames"][0]
    return float(frame["ball_outline_right"][0] - frame["ball_outline_left"][0])

"""The tables and figures of docs/ against what the program does now."""

from __future__ import annotations

import re

from accuracy import errors_frames, resolved_clips
from counting import answer, truth_of

from pages import page, section

SAME_ERROR_FRAMES = 0.05
"""Another machine's rounding and another build's decoder move a time by less."""
ACCURACY_ROW = re.compile(
    r"^\| `(?P<clip>[\w.-]+)` \| (?P<true>\d+) \| (?P<counted>\d+) \| (?P<median>[\d.]+) frames "
    r"\| (?P<largest>[\d.]+) frames \|$",
    re.MULTILINE,
)


def test_the_table_of_accuracy_promises_no_more_than_is_measured() -> None:
    rows = {row["clip"]: row for row in ACCURACY_ROW.finditer(page("docs/accuracy.md"))}
    assert sorted(rows) == [clip.name for clip in resolved_clips()]
    for clip in resolved_clips():
        row = rows[clip.name]
        assert int(row["true"]) == truth_of(clip)["count"]
        assert int(row["counted"]) == answer(clip)["count"]
        middle, largest = errors_frames(clip)
        assert middle <= float(row["median"]) + SAME_ERROR_FRAMES
        assert largest <= float(row["largest"]) + 2 * SAME_ERROR_FRAMES


def test_every_key_of_the_json_object_is_documented() -> None:
    said = answer(resolved_clips()[0])
    documented = set(re.findall(r"`(\w+)`", section("docs/result.md", "The JSON object")))
    assert set(said) | set(said["collisions"][0]) <= documented

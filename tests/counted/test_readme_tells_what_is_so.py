"""README.md's output, tables and figures against what the program does now."""

from __future__ import annotations

import re
import shlex

import pytest
from accuracy import errors_frames, resolved_clips
from counting import FIXTURES, answer, truth_of

from count_video.cli import main

TOP = FIXTURES.parent
README = (TOP / "README.md").read_text("utf-8")
SAME_ERROR_FRAMES = 0.05
"""Another machine's rounding and another build's decoder move a time by less."""
ACCURACY_ROW = re.compile(
    r"^\| `(?P<clip>[\w.-]+)` \| (?P<true>\d+) \| (?P<counted>\d+) \| (?P<median>[\d.]+) frames "
    r"\| (?P<largest>[\d.]+) frames \|$",
    re.MULTILINE,
)


def shown_call() -> tuple[list[str], str]:
    """Return the arguments of the call that README shows, and the output below it."""
    block = re.search(r"```console\n\$ count-video (.*?)\n(.*?)```", README, re.S)
    assert block is not None, "README shows a call and its output"
    return shlex.split(block[1]), block[2]


def without_digits(text: str) -> list[str]:
    """Return the lines with every number replaced, however many signs it takes."""
    return [" ".join(re.sub(r"-?\d+(\.\d+)?", "#", line).split()) for line in text.splitlines()]


def test_the_output_shown_is_what_the_command_prints(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(TOP)
    arguments, shown = shown_call()
    assert main(arguments) == 0
    printed = capsys.readouterr().out
    # Counts and sentences stand as printed; measured places may differ in their last digits.
    exact = [line for line in shown.splitlines() if re.search("collisions|Kinds|Evidence", line)]
    assert len(exact) == 3
    assert set(exact) <= set(printed.splitlines())
    left_out = "..."
    assert set(without_digits(shown)) - {left_out} <= set(without_digits(printed))


def test_every_picture_shown_is_there() -> None:
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", README)
    assert pictures
    assert [picture for picture in pictures if not (TOP / picture).is_file()] == []


def test_every_link_into_the_checkout_leads_somewhere() -> None:
    links = re.findall(r"(?<!!)\[[^]]+\]\((?!https?:)([^)#]+)\)", README)
    assert [link for link in links if not (TOP / link).exists()] == []
    assert links


def test_the_table_of_accuracy_promises_no_more_than_is_measured() -> None:
    rows = {row["clip"]: row for row in ACCURACY_ROW.finditer(README)}
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
    section = re.search(r"^## The JSON object\n(.*?)^## ", README, re.S | re.M)
    assert section is not None
    documented = set(re.findall(r"`(\w+)`", section[1]))
    assert set(said) | set(said["collisions"][0]) <= documented

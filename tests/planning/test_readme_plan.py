"""README.md's plan, its table of rates and its picture against what the command does now."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import cv2
import numpy as np
import pytest

import count_video
from count_video.cli import main
from count_video.planning.whole import Plan

TOP = Path(__file__).parents[2]
README = (TOP / "README.md").read_text("utf-8")
RATE_ROW = re.compile(
    r"^ *\| 1:(?P<ratio>\d+) \| (?P<gap>\d+) cm \| (?P<count>\d+) \| (?P<interval>[\d.]+) ms "
    r"\| (?P<rate>\d+) \|$",
    re.MULTILINE,
)
SAME_PICTURE_LEVELS = 6.0
"""Mean difference in grey levels that other versions of the drawing library make."""


def shown_plan() -> tuple[list[str], str]:
    """Return the arguments of the plan that README shows, and the output below it."""
    block = re.search(r"```console\n\$ count-video (--plan .*?)\n(.*?)```", README, re.S)
    assert block is not None, "README shows a plan and its output"
    return shlex.split(block[1]), block[2]


def test_the_plan_shown_is_what_the_command_prints(capsys: pytest.CaptureFixture[str]) -> None:
    arguments, shown = shown_plan()
    assert main(arguments) == 0
    assert capsys.readouterr().out == shown


def test_the_rates_to_film_at_are_planned() -> None:
    rows = list(RATE_ROW.finditer(README))
    assert len(rows) >= 5
    for row in rows:
        plan: Plan = count_video.plan(
            int(row["ratio"]), 1, gap_m=int(row["gap"]) / 100, chart=False, trials=2
        )
        assert int(row["count"]) == plan.burst.count
        assert row["interval"] == f"{1e3 * plan.burst.shortest_s:.1f}"
        assert int(row["rate"]) == plan.framing.rate_needed_fps


def test_the_picture_shown_is_made_by_the_command_below_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (command,) = re.findall(r"`count-video (--plan [^`]* -o plans/)`", README)
    arguments = shlex.split(command)
    assert main([*arguments[:-1], str(tmp_path)]) == 0
    capsys.readouterr()
    made, kept = (
        cv2.imread(str(folder / "plan.png"), cv2.IMREAD_GRAYSCALE)
        for folder in (tmp_path, TOP / "fixtures")
    )
    assert made is not None
    assert kept is not None
    assert made.shape == kept.shape
    assert np.abs(made.astype(float) - kept).mean() <= SAME_PICTURE_LEVELS


def test_every_key_of_a_plan_is_documented(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*shown_plan()[0], "--json", "--trials", "2"]) == 0
    output = json.loads(capsys.readouterr().out)
    section = re.search(r"^## The JSON object\n(.*?)^## ", README, re.S | re.M)
    assert section is not None
    documented = set(re.findall(r"`(\w+)`", section[1]))
    inner = {*output["camera"], *output["spread"], *output["proposals"][0]}
    assert set(output) | inner <= documented


def test_the_counts_named_before_the_plan_are_so() -> None:
    section = README.partition("## Before you film\n")[2][:400]
    named = re.findall(r"(\d\d) at (?:a gap of )?(\d) cm", " ".join(section.split()))
    assert len(named) == 4
    for count, gap_cm in named:
        plan = count_video.plan(1050, 10.5, gap_m=int(gap_cm) / 100, chart=False)
        assert plan.burst.count == int(count)

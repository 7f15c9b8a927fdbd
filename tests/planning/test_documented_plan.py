"""The plan and the table of rates of docs/filming.md against what the command does now."""

from __future__ import annotations

import json
import re
import shlex

import pytest

import count_video
from count_video.cli import main
from count_video.planning.plan import Plan
from pages import blocks, page, section

FILMING = page("docs/filming.md")
RATE_ROW = re.compile(
    r"^ *\| 1:(?P<ratio>\d+) \| (?P<gap>\d+) cm \| (?P<count>\d+) \| (?P<interval>[\d.]+) ms "
    r"\| (?P<rate>\d+) \|$",
    re.MULTILINE,
)


def shown_plan() -> tuple[list[str], str]:
    """Return the arguments of the plan that the page shows, and the output below it."""
    (block,) = blocks(FILMING, "console")
    call, _, shown = block.partition("\n")
    return shlex.split(call)[2:], shown


def test_the_rates_to_film_at_are_planned() -> None:
    rows = list(RATE_ROW.finditer(FILMING))
    assert len(rows) >= 5
    for row in rows:
        plan: Plan = count_video.plan(
            int(row["ratio"]), 1, gap_m=int(row["gap"]) / 100, chart=False, trials=2
        )
        assert int(row["count"]) == plan.burst.count
        assert row["interval"] == f"{1e3 * plan.burst.shortest_s:.1f}"
        assert int(row["rate"]) == plan.framing.rate_needed_fps


def test_every_key_of_a_plan_is_documented(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*shown_plan()[0], "--json", "--trials", "2"]) == 0
    output = json.loads(capsys.readouterr().out)
    documented = set(re.findall(r"`(\w+)`", section("docs/result.md", "The JSON object of a plan")))
    inner = {*output["camera"], *output["spread"], *output["proposals"][0]}
    assert set(output) | inner <= documented


def test_the_counts_named_before_the_plan_are_so() -> None:
    opening = section("docs/filming.md", "Plan before you film")[:400]
    named = re.findall(r"(\d\d) at (?:a gap of )?(\d) cm", " ".join(opening.split()))
    assert len(named) == 4
    for count, gap_cm in named:
        plan = count_video.plan(1050, 10.5, gap_m=int(gap_cm) / 100, chart=False)
        assert plan.burst.count == int(count)

"""The paper's campaign, rendered and counted by the commands that docs/campaigns.md shows."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from count_video import cli as count_cli
from count_video.batch.summary import summarise
from count_video.reports.exports import campaign_json
from pages import blocks, page, section
from synth_video import cli as synth_cli
from synth_video.campaign import CAMPAIGNS, film, takes_of, write_lists

CAMPAIGNS_PAGE = "docs/campaigns.md"
PAPER = CAMPAIGNS["paper-30"]
SHORT = 14
"""A trial that makes a short clip, of a phone's; its count is 29."""
WRITTEN = 5e-12
"""Numbers are written with twelve digits: half of the last one, as a share of the number."""


def documented_example() -> tuple[list[list[str]], list[str]]:
    """Return the commands of the campaign's example, and the lines that it shows."""
    (block,) = blocks(page(CAMPAIGNS_PAGE), "console")
    lines = block.splitlines()
    commands = [shlex.split(line[2:]) for line in lines if line.startswith("$ ")]
    return commands, [line for line in lines if line and not line.startswith(("$ ", "..."))]


def test_a_short_trial_of_the_papers_campaign_is_counted_as_it_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    takes = [takes_of(PAPER, PAPER.seed)[SHORT]]
    write_lists(takes, PAPER.seed, tmp_path)
    assert len(list(film(takes, tmp_path, workers=1))) == 1
    results = tmp_path / "results"
    assert count_cli.main([str(tmp_path), "-o", str(results), "--jobs", "1"]) == 0
    found = {
        take.name: json.loads((results / f"{take.name}.json").read_text("utf-8"))["count"]
        for take in takes
    }
    truth = json.loads((tmp_path / "campaign.truth.json").read_text("utf-8"))
    assert found == truth["counts"]
    said = json.loads((results / "campaign.json").read_text("utf-8"))
    assert {key: said[key] for key in ("trials", "maximum", "minimum", "mean", "theory")} == {
        "trials": 1,
        "maximum": truth["maximum"],
        "minimum": truth["minimum"],
        "mean": truth["mean"],
        "theory": 31,
    }


@pytest.mark.slow
def test_the_readmes_campaign_runs_as_printed_and_gives_the_papers_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    commands, shown = documented_example()
    mains = {"synth-video": synth_cli.main, "count-video": count_cli.main}
    for program, *arguments in commands:
        capsys.readouterr()
        assert mains[program](arguments) == 0
    printed = iter(capsys.readouterr().out.splitlines())
    for line in shown:
        assert line in printed, "in this order"
    truth = json.loads(Path("trials/campaign.truth.json").read_text("utf-8"))
    said = json.loads(Path("results/campaign.json").read_text("utf-8"))
    for key in ("trials", "maximum", "minimum", "mean", "sd_population"):
        assert said[key] == pytest.approx(truth[key], rel=WRITTEN)


def test_the_page_names_every_key_of_the_campaigns_json() -> None:
    documented = section(CAMPAIGNS_PAGE, "campaign.json")
    keys = json.loads(campaign_json([], summarise([])))
    assert [key for key in keys if f"`{key}`" not in documented] == []

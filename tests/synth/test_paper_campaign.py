"""The campaign whose true counts have the paper's figures."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from statistics import fmean, pstdev

import pytest

from count_video.errors import UsageError
from synth_video.campaign import (
    APART_FRAMES,
    CAMPAIGNS,
    PHONE_RATE,
    Target,
    film,
    search,
    takes_of,
    target_named,
    true_counts,
    write_lists,
)
from synth_video.cli import main

PAPER = CAMPAIGNS["paper-30"]
EASY = replace(PAPER, trials=2, maximum=31, minimum=30, mean="30.50", sd_population="0.50")
"""Two trials: found within a few seeds."""


def test_the_true_counts_have_the_papers_figures() -> None:
    counts = true_counts(PAPER, PAPER.seed)
    assert len(counts) == 30
    assert (max(counts), min(counts)) == (31, 28)
    assert f"{fmean(counts):.2f} {pstdev(counts):.2f}" == "30.57 0.80"


@pytest.mark.parametrize("counts", [[31] * 30, [31] * 22 + [30] * 4 + [29] * 3 + [27], [31] * 3])
def test_other_counts_do_not_meet_the_papers_figures(counts: list[int]) -> None:
    assert not PAPER.met_by(counts)


def test_the_search_finds_the_first_seed_that_meets_its_target() -> None:
    seed = search(EASY)
    assert EASY.met_by(true_counts(EASY, seed))
    assert not any(EASY.met_by(true_counts(EASY, before)) for before in range(seed))


def test_the_search_from_shortly_before_finds_the_papers_seed() -> None:
    assert search(PAPER, PAPER.seed - 20) == PAPER.seed


@pytest.mark.slow
def test_the_search_can_be_run_again(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", "paper-30", "--search"]) == 0
    assert capsys.readouterr().out.startswith(f"seed {PAPER.seed}: ")


def test_no_trial_is_like_another_and_none_depends_on_the_others() -> None:
    setups = [PAPER.hands.setup(PAPER.seed, trial) for trial in range(30)]
    assert len(set(setups)) == 30
    assert PAPER.hands.setup(PAPER.seed, 17) == setups[17]
    assert PAPER.hands.setup(PAPER.seed + 1, 17) != setups[17]


def test_some_trials_are_filmed_fast_enough_and_some_by_a_phone() -> None:
    takes = takes_of(PAPER, PAPER.seed)
    rates = [take.scene.camera.capture_fps for take in takes]
    assert sum(rate >= 1000 for rate in rates) >= 15
    assert 3 <= rates.count(PHONE_RATE) <= 12
    assert [take.count for take in takes] == true_counts(PAPER, PAPER.seed)


def test_the_clips_the_manifest_and_the_truth_belong_together(tmp_path: Path) -> None:
    small = ("camera.width_px=160", "camera.height_px=60", "clip.max_frames=3000")
    takes = [
        take for take in takes_of(PAPER, PAPER.seed, small) if take.scene.camera.capture_fps < 300
    ]
    write_lists(takes, PAPER.seed, tmp_path)
    assert [take.name for take in film(takes[:2], tmp_path, workers=2)] == [
        take.name for take in takes[:2]
    ]
    lines = list(csv.DictReader((tmp_path / "manifest.csv").read_text("utf-8").splitlines()))
    truth = json.loads((tmp_path / "campaign.truth.json").read_text("utf-8"))
    assert [line["masses"] for line in lines] == ["1.05 0.0105"] * len(takes)
    for take, line in zip(takes[:2], lines, strict=False):
        assert (tmp_path / line["clip"]).is_file()
        of_clip = json.loads((tmp_path / f"{take.name}.truth.json").read_text("utf-8"))
        assert of_clip["count"] == truth["counts"][take.name] == take.count
        assert (
            of_clip["capture_fps"] == float(line["capture_fps"]) == truth["capture_fps"][take.name]
        )


def test_a_fast_camera_separates_the_collisions() -> None:
    assert APART_FRAMES > 2.5
    target = Target(4, 31, 28, "30.00", "1.00", seed=PAPER.seed)
    rates = [take.scene.camera.capture_fps for take in takes_of(target, PAPER.seed)]
    assert rates[2] == 1000.0, "a wide gap needs no fast camera"


def test_an_unknown_campaign_is_said_with_those_that_there_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(UsageError, match="there are: paper-30"):
        target_named("paper-31")
    assert main(["campaign", "paper-31", "x"]) == 2
    assert "paper-30" in capsys.readouterr().err

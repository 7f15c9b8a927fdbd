"""What a campaign keeps, what it counts again, and what it leaves as it is."""

from __future__ import annotations

import csv
import errno
import json
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from stub_campaign import StubCampaign, files_in

from count_video import outputs
from tiers import rest_slow


def table_rows(results: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((results / "trials.csv").read_text("utf-8").splitlines()))


def test_a_campaign_keeps_a_result_a_clip_a_table_and_a_summary(campaign: StubCampaign) -> None:
    campaign.add(trial1="count 31", trial2="count 30", trial10="count 31")
    done = campaign.here("--masses", "1050", "10.5")
    assert (done.returncode, done.stderr) == (0, "")
    kept = {file.name for file in campaign.results.iterdir() if file.is_file()}
    trials = {"trial1.json", "trial2.json", "trial10.json"}
    together = {"trials.csv", "campaign.json", "campaign.html", "campaign.png"}
    assert kept == trials | together
    assert all(name in done.stdout for name in together), "it says what it wrote"
    summary = json.loads((campaign.results / "campaign.json").read_text("utf-8"))
    assert (summary["trials"], summary["counted"], summary["theory"]) == (3, 3, 31)
    rows = table_rows(campaign.results)
    assert [row["name"] for row in rows] == ["trial1", "trial2", "trial10"]
    table = [line.split()[:2] for line in done.stdout.splitlines()[1:4]]
    assert table == [["trial1", "31"], ["trial2", "30"], ["trial10", "31"]]


def test_the_kept_result_is_the_object_that_json_prints(campaign: StubCampaign) -> None:
    campaign.add(a="count 31", b="bad now")
    printed = campaign.here("--json").stdout.splitlines()
    kept = [(campaign.results / name).read_text("utf-8") for name in ("a.json", "b.json")]
    assert kept == [f"{line}\n" for line in printed]


@pytest.mark.parametrize(
    ("full", "said", "lost", "kept"),
    [
        ("campaign.html", "campaign.html", "none", ": the results of the trials are kept"),
        ("*.png", "campaign.html, campaign.png", "a.json", ": 1 of the 2 results is kept"),
        ("*.csv", "campaign.html, trials.csv, campaign.json, campaign.png", "*.json", ""),
    ],
)
def test_what_a_full_disk_kept_of_a_campaign_is_said_and_what_not(
    campaign: StubCampaign,
    monkeypatch: pytest.MonkeyPatch,
    full: str,
    said: str,
    lost: str,
    kept: str,
) -> None:
    def appearing(target: Path) -> AbstractContextManager[Path]:
        if target.match(full) or (target.match(lost) and target.stem in "ab"):
            raise OSError(errno.ENOSPC, "full")
        return whole(target)

    whole = outputs.appearing
    monkeypatch.setattr(outputs, "appearing", appearing)
    campaign.add(a="count 31", b="count 30")
    done = campaign.here()
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    why = f"count-video: {campaign.results}: {said} could not be written (full)"
    assert last == f"{why}; free space on that disk and start again{kept}"


def test_a_second_run_counts_only_what_changed(campaign: StubCampaign) -> None:
    campaign.add(a="count 31", b="count 30", c="count 29")
    first = campaign.here()
    before = files_in(campaign.results)
    again = campaign.here()
    assert again.stdout == first.stdout
    assert files_in(campaign.results) == before
    assert campaign.worked() == {"a.mp4": 1, "b.mp4": 1, "c.mp4": 1}
    campaign.add(b="count 28")
    campaign.here()
    assert campaign.worked() == {"a.mp4": 1, "b.mp4": 2, "c.mp4": 1}
    campaign.here("--capture-fps", "960")
    assert campaign.worked() == {"a.mp4": 2, "b.mp4": 3, "c.mp4": 2}
    campaign.here("--capture-fps", "960", "--fresh")
    assert campaign.worked() == {"a.mp4": 3, "b.mp4": 4, "c.mp4": 3}


def test_pages_that_are_asked_for_later_are_drawn_without_a_second_count(
    campaign: StubCampaign,
) -> None:
    campaign.add(a="count 31", b="count 30", bad="bad now")
    campaign.here()
    done = campaign.here("--pages")
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert "bad.mp4: the file is cut off" in done.stderr
    assert "31 collisions" in (campaign.results / "a.html").read_text("utf-8")
    assert campaign.worked() == {"a.mp4": 1, "b.mp4": 1, "bad.mp4": 1}
    kept = files_in(campaign.results)
    campaign.here("--pages")
    assert files_in(campaign.results) == kept
    (campaign.results / "a.html").unlink()
    (campaign.results / ".count-video" / "a.jsonl").write_text("damaged", "utf-8")
    campaign.here("--pages")
    assert "31 collisions" in (campaign.results / "a.html").read_text("utf-8")
    assert campaign.worked()["a.mp4"] == 2, "what was followed is lost, so it is counted again"


def test_results_of_other_clips_of_the_same_names_are_replaced_with_a_word(
    campaign: StubCampaign,
) -> None:
    campaign.add(a="count 31", b="count 30")
    assert campaign.here().stderr == ""
    (campaign.top / "other").mkdir()
    other = StubCampaign(campaign.top / "other")
    other.add(a="count 29")
    done = other.here(results=campaign.results)
    assert done.stderr.count("\n") == 1
    assert "replaces 1 result of other clips of the same names (a first)" in done.stderr
    assert other.here(results=campaign.results).stderr == ""


def test_a_manifest_is_not_written_over_by_the_table(campaign: StubCampaign) -> None:
    campaign.add(a="count 31")
    campaign.here()
    table = campaign.results / "trials.csv"
    table.write_text(f"clip\n{campaign.clips / 'a.mp4'}\n", "utf-8")
    done = campaign.here(str(table))
    assert done.returncode == 2
    assert "would overwrite this manifest" in done.stderr
    assert table.read_text("utf-8").startswith("clip\n")


@pytest.mark.parametrize("name", ["trials.csv", "campaign.html", "a.json"])
def test_a_file_of_somebody_else_is_left_as_it_is(campaign: StubCampaign, name: str) -> None:
    campaign.add(a="count 31")
    campaign.results.mkdir()
    (campaign.results / name).write_text("mine", "utf-8")
    done = campaign.here()
    assert done.returncode in (1, 2)
    assert "not written by this program" in " ".join((done.stdout + done.stderr).split())
    assert (campaign.results / name).read_text("utf-8") == "mine"


@pytest.mark.parametrize("damage", rest_slow(['{"clip": "x"}', "[" * 5000, "[]", "", "\udcff"], 2))
def test_a_result_that_was_damaged_is_counted_again(campaign: StubCampaign, damage: str) -> None:
    campaign.add(a="count 31")
    first = campaign.here().stdout
    content = damage.encode("utf-8", "surrogatepass")
    (campaign.results / "a.json").write_bytes(content)
    place = campaign.results / ".count-video" / "a.jsonl"
    line, _, followed = place.read_text("ascii").partition("\n")
    forged = json.loads(line) | {"result": damage}
    place.write_text(f"{json.dumps(forged)}\n{followed}", "ascii")
    again = campaign.here()
    assert (again.stdout, again.stderr) == (first, "")
    assert campaign.worked() == {"a.mp4": 2}

"""What a campaign does as real processes: failures, interruptions, and two runs at once."""

from __future__ import annotations

import csv
import hashlib
import json
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from stub_campaign import COMMAND, StubCampaign, files_in

from tiers import rest_slow

POLL_S = 0.02
PATIENCE_S = 60.0


def wait_for(condition: object) -> None:
    """Wait until a callable says true; fail if it never does."""
    assert callable(condition)
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(POLL_S)


def children(process: int) -> set[int]:
    tasks = Path(f"/proc/{process}/task")
    return {
        int(child) for file in tasks.glob("*/children") for child in file.read_text("ascii").split()
    }


def alive(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text("ascii").rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def table_rows(results: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((results / "trials.csv").read_text("utf-8").splitlines()))


def test_a_campaign_keeps_a_result_a_clip_a_table_and_a_summary(campaign: StubCampaign) -> None:
    campaign.add(trial1="count 31", trial2="count 30", trial10="count 31")
    done = campaign.run("--masses", "1050", "10.5")
    assert (done.returncode, done.stderr) == (0, "")
    kept = {file.name for file in campaign.results.iterdir() if file.is_file()}
    trials = {"trial1.json", "trial2.json", "trial10.json"}
    together = {"trials.csv", "campaign.json", "campaign.html", "campaign.png"}
    assert kept == trials | together
    summary = json.loads((campaign.results / "campaign.json").read_text("utf-8"))
    assert (summary["trials"], summary["counted"], summary["theory"]) == (3, 3, 31)
    rows = table_rows(campaign.results)
    assert [row["name"] for row in rows] == ["trial1", "trial2", "trial10"]
    table = [line.split()[:2] for line in done.stdout.splitlines()[1:4]]
    assert table == [["trial1", "31"], ["trial2", "30"], ["trial10", "31"]]


def test_the_kept_result_is_the_object_that_json_prints(campaign: StubCampaign) -> None:
    campaign.add(a="count 31", b="bad now")
    printed = campaign.run("--json").stdout.splitlines()
    kept = [(campaign.results / name).read_text("utf-8") for name in ("a.json", "b.json")]
    assert kept == [f"{line}\n" for line in printed]


def test_a_bad_clip_a_fault_and_a_dying_worker_are_rows_and_stop_no_other(
    campaign: StubCampaign,
) -> None:
    campaign.add(
        a="count 31",
        bad="bad now",
        dies="die always",
        fault="fault now",
        y="count 30",
        z="count 29",
    )
    done = campaign.run("--jobs", "2")
    assert done.returncode == 1
    summary = json.loads((campaign.results / "campaign.json").read_text("utf-8"))
    assert summary["histogram"] == {"29": 1, "30": 1, "31": 1}
    reasons = {doubt["name"]: doubt["reason"] for doubt in summary["need_a_person"]}
    assert list(reasons) == ["bad", "dies", "fault"]
    assert reasons["bad"] == "the file is cut off; copy it again"
    assert "worker died" in reasons["dies"]
    assert "ZeroDivisionError: a fault of the program" in reasons["fault"]
    rows = table_rows(campaign.results)
    assert [row["name"] for row in rows[:3]] == ["bad", "dies", "fault"], "they come first"


def test_a_worker_that_is_killed_costs_only_a_retry(campaign: StubCampaign) -> None:
    campaign.add(a="count 31", b="die once count 30", c="count 29", d="count 28")
    done = campaign.run("--jobs", "2")
    assert done.returncode == 0
    assert json.loads((campaign.results / "campaign.json").read_text("utf-8"))["counted"] == 4


def test_a_second_run_counts_only_what_changed(campaign: StubCampaign) -> None:
    campaign.add(a="count 31", b="count 30", c="count 29")
    first = campaign.run()
    before = files_in(campaign.results)
    again = campaign.run()
    assert again.stdout == first.stdout
    assert files_in(campaign.results) == before
    assert campaign.worked() == {"a.mp4": 1, "b.mp4": 1, "c.mp4": 1}
    campaign.add(b="count 28")
    campaign.run()
    assert campaign.worked() == {"a.mp4": 1, "b.mp4": 2, "c.mp4": 1}
    campaign.run("--capture-fps", "960")
    assert campaign.worked() == {"a.mp4": 2, "b.mp4": 3, "c.mp4": 2}
    campaign.run("--capture-fps", "960", "--fresh")
    assert campaign.worked() == {"a.mp4": 3, "b.mp4": 4, "c.mp4": 3}


def test_pages_that_are_asked_for_later_are_drawn_without_a_second_count(
    campaign: StubCampaign,
) -> None:
    campaign.add(a="count 31", b="count 30", bad="bad now")
    campaign.run()
    done = campaign.run("--pages")
    assert (done.returncode, done.stderr) == (1, "")
    assert "31 collisions" in (campaign.results / "a.html").read_text("utf-8")
    assert campaign.worked() == {"a.mp4": 1, "b.mp4": 1, "bad.mp4": 2}
    kept = files_in(campaign.results)
    campaign.run("--pages")
    assert files_in(campaign.results) == kept
    (campaign.results / "a.html").unlink()
    (campaign.results / ".count-video" / "a.json").write_text("damaged", "utf-8")
    campaign.run("--pages")
    assert "31 collisions" in (campaign.results / "a.html").read_text("utf-8")
    assert campaign.worked()["a.mp4"] == 2, "what was followed is lost, so it is counted again"


def test_results_of_other_clips_of_the_same_names_are_replaced_with_a_word(
    campaign: StubCampaign,
) -> None:
    campaign.add(a="count 31", b="count 30")
    assert campaign.run().stderr == ""
    (campaign.top / "other").mkdir()
    other = StubCampaign(campaign.top / "other")
    other.add(a="count 29")
    done = other.run(results=campaign.results)
    assert done.stderr.count("\n") == 1
    assert "replaces 1 result of other clips of the same names (a first)" in done.stderr
    assert other.run(results=campaign.results).stderr == ""


def test_a_manifest_is_not_written_over_by_the_table(campaign: StubCampaign) -> None:
    campaign.add(a="count 31")
    campaign.run()
    table = campaign.results / "trials.csv"
    table.write_text(f"clip\n{campaign.clips / 'a.mp4'}\n", "utf-8")
    command = [sys.executable, str(COMMAND), str(table), "-o", str(campaign.results)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "would overwrite this manifest" in done.stderr
    assert table.read_text("utf-8").startswith("clip\n")


@pytest.mark.parametrize("name", rest_slow(["a.json", "campaign.html", "trials.csv"]))
def test_a_file_of_somebody_else_is_left_as_it_is(campaign: StubCampaign, name: str) -> None:
    campaign.add(a="count 31")
    campaign.results.mkdir()
    (campaign.results / name).write_text("mine", "utf-8")
    done = campaign.run()
    assert done.returncode in (1, 2)
    assert "not written by this program" in " ".join((done.stdout + done.stderr).split())
    assert (campaign.results / name).read_text("utf-8") == "mine"


@pytest.mark.parametrize("damage", rest_slow(['{"clip": "x"}', "[]", "[" * 5000, "", "\udcff"]))
def test_a_result_that_was_damaged_is_counted_again(campaign: StubCampaign, damage: str) -> None:
    campaign.add(a="count 31")
    first = campaign.run().stdout
    content = damage.encode("utf-8", "surrogatepass")
    (campaign.results / "a.json").write_bytes(content)
    record = campaign.results / ".count-video" / "written"
    lines = map(json.loads, filter(None, record.read_text("ascii").splitlines()))
    (kept,) = [line for line in lines if line["name"] == "a.json"]
    forged = kept | {"result": hashlib.sha256(content.rstrip(b"\n")).hexdigest()}
    with record.open("a", encoding="ascii") as stream:
        stream.write(f"{json.dumps(forged)}\n")
    again = campaign.run()
    assert (again.stdout, again.stderr) == (first, "")
    assert campaign.worked() == {"a.mp4": 2}


def test_a_second_run_into_the_same_folder_says_so_and_stops(campaign: StubCampaign) -> None:
    campaign.add(a="count 31 sleep 600")
    with campaign.start() as first:
        wait_for(campaign.worked)
        second = campaign.run()
        first.send_signal(signal.SIGINT)
        first.communicate()
    assert second.returncode == 2
    assert second.stdout == ""
    assert "another run is at work in this folder" in second.stderr
    assert campaign.worked() == {"a.mp4": 1}


def test_an_interruption_keeps_what_is_done_and_leaves_no_process(campaign: StubCampaign) -> None:
    campaign.add(a="count 31", b="count 30 sleep 600", c="count 29 sleep 600")
    with campaign.start() as process:
        wait_for(lambda: (campaign.results / "a.json").exists() and len(campaign.worked()) == 3)
        family = children(process.pid)
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert complaint == "count-video: interrupted\n"
    assert family
    wait_for(lambda: not any(map(alive, family)))
    assert json.loads((campaign.results / "a.json").read_text("utf-8"))["count"] == 31


def test_workers_end_when_the_command_is_killed(campaign: StubCampaign) -> None:
    campaign.add(a="count 31 sleep 600", b="count 31 sleep 600")
    with campaign.start() as process:
        wait_for(lambda: len(campaign.worked()) == 2)
        family = children(process.pid)
        process.kill()
        wait_for(lambda: not any(map(alive, family)))
    assert len(family) >= 2
    campaign.add(a="count 31", b="count 31")
    assert campaign.run().returncode == 0, "the lock went with its process"


@pytest.mark.parametrize("kills", rest_slow([3, 20]))
def test_kills_at_random_moments_lose_no_result_and_change_no_file(
    campaign: StubCampaign, kills: int
) -> None:
    campaign.add(**{f"trial{k}": f"count {28 + k % 4} sleep 0.05" for k in range(12)})
    campaign.add(bad="bad now", doubt="count 30 chance 0.6")
    began = time.monotonic()
    campaign.run("--jobs", "2", results=campaign.top / "undisturbed")
    lasts_s = time.monotonic() - began
    chance = random.Random(kills)
    shutil.rmtree(campaign.results, ignore_errors=True)
    for _ in range(kills):
        campaign.log.unlink(missing_ok=True)
        finished = {file.stem for file in campaign.results.glob("*.json")} - {"campaign"}
        with campaign.start() as process:
            try:
                process.wait(chance.uniform(0.2, 1.0) * lasts_s)
            except subprocess.TimeoutExpired:
                process.kill()
        assert not {f"{name}.mp4" for name in finished} & set(campaign.worked())
        for file in campaign.results.glob("*.json"):
            json.loads(file.read_text("utf-8"))
    campaign.run()
    assert files_in(campaign.results) == files_in(campaign.top / "undisturbed")


def test_a_full_disk_is_told_in_the_rows_and_the_rest_is_finished(campaign: StubCampaign) -> None:
    small = campaign.top / "small"
    small.mkdir()
    # 40 kB hold some of the results, not all: each takes a block or two for itself and its record.
    script = f'mount -t tmpfs -o size=40k none {small} && exec "$@"'
    command = ["unshare", "-rm", "sh", "-c", script, "sh"]
    if not shutil.which("unshare") or subprocess.run([*command, "true"], check=False).returncode:
        pytest.skip("needs a system on which anybody may mount a small disk")
    campaign.add(**{f"trial{k}": "count 31" for k in range(10)})
    process = campaign.start(results=small / "results")
    process.kill()
    process.communicate()
    arguments = process.args
    assert isinstance(arguments, list)
    done = subprocess.run([*command, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    lines = done.stdout.splitlines()
    assert [line.split()[1] for line in lines[1:11]] == ["31"] * 10, "all are counted and shown"
    assert "the result could not be written (No space left on device)" in " ".join(
        done.stdout.split()
    )
    assert "No space left on device" in done.stderr

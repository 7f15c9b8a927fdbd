"""What a campaign does as real processes: failures, interruptions, and two runs at once."""

from __future__ import annotations

import csv
import json
import random
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
from stub_campaign import StubCampaign, files_in

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


@pytest.mark.parametrize("kills", rest_slow([2, 20]))
def test_kills_at_random_moments_lose_no_result_and_change_no_file(
    campaign: StubCampaign, kills: int
) -> None:
    campaign.add(**{f"trial{k}": f"count {28 + k % 4} sleep 0.05" for k in range(8)})
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


def test_a_full_disk_is_said_in_the_rows_and_the_rest_is_finished(campaign: StubCampaign) -> None:
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

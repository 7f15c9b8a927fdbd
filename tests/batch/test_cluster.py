"""A campaign on a real Dask cluster: a scheduler and two worker processes on this machine."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import pytest
from stub_campaign import COMMAND, StubCampaign, files_in

from count_video.batch import executor

pytest.importorskip("distributed")

PATIENCE_S = 60.0
LOCAL = "tcp://127.0.0.1:0"


@dataclass(frozen=True)
class Cluster:
    """Processes of a cluster."""

    address: str
    scheduler: subprocess.Popen[str]
    workers: list[subprocess.Popen[str]]


def dask(stack: ExitStack, log: Path, *arguments: str) -> subprocess.Popen[str]:
    """Start a part of the cluster, to be ended with the stack."""
    environment = os.environ | {"STUB_LOG": str(log.with_name("work.log")), "PYTHONUNBUFFERED": "1"}
    elsewhere = log.with_suffix("")
    elsewhere.mkdir()
    with log.open("w", encoding="utf-8") as stream:
        process = stack.enter_context(
            subprocess.Popen(
                [sys.executable, "-m", *arguments],
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                text=True,
                cwd=elsewhere,
            )
        )
    stack.callback(process.kill)
    return process


def said(log: Path, pattern: str) -> str:
    """Wait for a line in a log; return what the pattern's group holds."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        found = re.search(pattern, log.read_text("utf-8"))
        if found is not None:
            return found[1]
        time.sleep(0.05)
    raise AssertionError(f"{log.name} never said {pattern}: {log.read_text('utf-8')}")


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    with ExitStack() as stack:
        log = tmp_path / "scheduler.txt"
        module = "distributed.cli.dask_scheduler"
        scheduler = dask(stack, log, module, "--host", LOCAL, "--no-dashboard", "--no-show")
        address = said(log, r"Scheduler at: +(tcp://\S+)")
        logs = [tmp_path / f"worker{number}.txt" for number in range(2)]
        arguments = ("distributed.cli.dask_worker", address, "--nthreads", "1")
        options = ("--no-dashboard", "--no-nanny", "--preload", str(COMMAND))
        workers = [dask(stack, log, *arguments, *options) for log in logs]
        for log in logs:
            said(log, r"(Registered to)")
        yield Cluster(address, scheduler, workers)


def test_a_cluster_gives_the_files_of_a_local_run_and_a_killed_worker_costs_only_a_retry(
    cluster: Cluster, campaign: StubCampaign
) -> None:
    campaign.add(**{f"trial{k}": f"count {28 + k % 4} sleep 0.2" for k in range(6)})
    campaign.add(bad="bad now")
    with campaign.start("--scheduler", cluster.address) as process:
        end = time.monotonic() + PATIENCE_S
        while len(campaign.worked()) < 3 and time.monotonic() < end:
            time.sleep(0.02)
        cluster.workers[0].send_signal(signal.SIGKILL)
        out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1
    assert len(err.splitlines()) == 1, "the bad clip, and nothing else"
    assert "bad.mp4" in err
    begun = campaign.worked()
    assert sum(begun.values()) > len(begun), "a clip was begun again"
    local = campaign.run(results=campaign.top / "local")
    table, _, _ = out.partition("  Written")  # which names the folder
    assert table == local.stdout.partition("  Written")[0]
    assert files_in(campaign.results) == files_in(campaign.top / "local")
    campaign.log.unlink()
    assert campaign.run("--scheduler", cluster.address).stdout == out
    assert campaign.worked() == {}, "all is known already"


@pytest.mark.slow  # it waits for a cluster to be missed; the same law without one is quick
def test_a_scheduler_that_dies_costs_the_clips_not_yet_done_and_no_result(
    cluster: Cluster, campaign: StubCampaign
) -> None:
    campaign.add(**{f"trial{k}": "count 31 sleep 0.3" for k in range(10)})
    with campaign.start("--scheduler", cluster.address) as process:
        end = time.monotonic() + PATIENCE_S
        while len(campaign.worked()) < 6 and time.monotonic() < end:
            time.sleep(0.02)
        cluster.scheduler.send_signal(signal.SIGKILL)
        _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1
    rows = json.loads((campaign.results / "campaign.json").read_text("utf-8"))
    assert rows["trials"] == 10
    assert 0 < rows["counted"] < 10
    assert all("scheduler" in clip["reason"] for clip in rows["need_a_person"])
    complaints = err.splitlines()
    assert len(complaints) == 10 - rows["counted"], err
    assert all("scheduler" in line for line in complaints)
    campaign.log.unlink()
    assert campaign.run().returncode == 0
    assert sum(campaign.worked().values()) == 10 - rows["counted"]


def test_paths_are_those_of_the_command_not_of_the_workers(
    cluster: Cluster, campaign: StubCampaign
) -> None:
    campaign.add(a="count 31")
    command = [sys.executable, str(COMMAND), "clips", "-o", "results"]
    done = subprocess.run(
        [*command, "--scheduler", cluster.address],
        cwd=campaign.top,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    kept = json.loads((campaign.results / "a.json").read_text("utf-8"))
    assert (kept["clip"], kept["count"]) == ("clips/a.mp4", 31)


def test_where_no_scheduler_answers_the_command_says_so(
    campaign: StubCampaign, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(executor, "CONNECT_TIMEOUT_S", 1)  # nobody will ever answer there
    campaign.add(a="count 31")
    done = campaign.here("--scheduler", "tcp://127.0.0.1:1")
    assert done.returncode == 2
    assert "no Dask scheduler answers at tcp://127.0.0.1:1" in done.stderr

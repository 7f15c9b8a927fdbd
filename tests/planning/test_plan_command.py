"""``count-video --plan`` as a person types it."""

from __future__ import annotations

import csv
import io
import json
import re
import xml.etree.ElementTree as ET
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
import pytest

import count_video
from count_video import pipeline
from count_video.cli import main
from count_video.outputs import HIDDEN
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.planning.request import PlanRequest, Tolerances, read_request
from count_video.reports.page import PageMedia, clip_page

TOP = Path(__file__).parents[2]
PAPER = ["--plan", "1050", "10.5", "--thread", "1.0", "--release", "0.09", "--gap", "0.03"]
LABELS = ("Theory", "Kinds", "Shortest", "Last", "Burst", "Camera", "Film at", "Picture")


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that holds the plan of the paper's trials."""
    folder = tmp_path_factory.mktemp("planned") / "plans" / "first"
    with redirect_stdout(io.StringIO()):
        assert main([*PAPER, "--capture-fps", "240", "-o", str(folder)]) == 0
    return folder


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 0
    output = capsys.readouterr()
    assert output.err == ""
    return output.out


def test_the_count_comes_first_and_everything_asked_for_follows(
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = answer(capsys, *PAPER, "--capture-fps", "240")
    lines = text.splitlines()
    assert lines[0] == "1050 and 10.5, gap 30 mm, release 90 mm: 31 collisions"
    output = [line.strip() for line in lines]
    for label in (*LABELS, "How sure", "A table", "Change"):
        assert any(line.startswith(label) for line in output), label
    assert max(map(len, lines)) <= 80
    assert "Number of trials" not in text


@pytest.mark.parametrize("thread", ["0.019", "0.1"])
def test_no_release_is_proposed_that_is_longer_than_a_thread(
    thread: str, capsys: pytest.CaptureFixture[str]
) -> None:
    set_up = ["--thread", thread, "--release", "0.015", "--gap", "0.008"]
    output = json.loads(answer(capsys, "--plan", "1050", "10.5", *set_up, "--json"))
    releases = [one["value"] for one in output["proposals"] if one["change"] == "release"]
    assert all(release < float(thread) for release in releases)


def test_trials_add_the_table(capsys: pytest.CaptureFixture[str]) -> None:
    text = answer(capsys, *PAPER, "--trials", "30", "--seed", "5")
    figures = dict(re.findall(r"^(\w[\w ]+?)  +([\d.]+)", text, re.M))
    assert figures["Number of trials"] == "30"
    assert "\n  of these counted " in text
    assert 29.5 <= float(figures["Mean value"]) <= 31
    rows = [line.split() for line in text.partition("Collisions  trials")[2].splitlines()]
    assert sum(int(row[1]) for row in rows if row) == 30


def test_json_is_one_line_and_says_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    line = answer(capsys, *PAPER, "--capture-fps", "240", "--json", "--trials", "30")
    assert line.count("\n") == 1
    output = json.loads(line)
    motion = simulate(Setup(wall_gap_m=0.03))
    assert (output["count"], output["theory"]) == (motion.count, 31)
    assert output["last_s"] == pytest.approx(motion.burst[-1].time_s)
    assert output["camera"]["way"] == "inferred"
    assert 0.9 < output["camera"]["chance"] < 1
    assert sum(output["spread"]["histogram"].values()) == output["spread"]["trials"]
    assert len(output["table"]["counts"]) == 30
    assert output["request"]["gap_m"] == 0.03


def test_what_is_not_known_is_null(capsys: pytest.CaptureFixture[str]) -> None:
    output = json.loads(answer(capsys, *PAPER, "--json"))
    assert (output["camera"], output["table"]) == (None, None)


def test_what_is_left_out_has_the_defaults_that_help_names(
    capsys: pytest.CaptureFixture[str],
) -> None:
    output = json.loads(answer(capsys, "--plan", "1050", "10.5", "--json"))["request"]
    plain = PlanRequest(1050, 10.5)
    assert output["gap_m"] == plain.gap_m == 0.03
    assert output["release_m"] == plain.release_m == 0.09
    assert output["heavy_thread_m"] == output["light_thread_m"] == 1.0
    assert (output["restitution"], output["damping_per_s"], output["seed"]) == (1.0, 0.0, 0)
    off = Tolerances()
    named = f"gap={off.gap_m} release={off.release_m} thread={off.thread_m} mass={off.mass} "
    named += f"restitution={off.restitution} scatter={off.scatter}"
    assert main(["--help"]) == 0
    assert f"(default: {named})" in " ".join(capsys.readouterr().out.split())


def test_every_option_arrives(capsys: pytest.CaptureFixture[str]) -> None:
    more = "--thread 1.2 1.1 --restitution 0.98 --damping 0.01 --ball-diameter-mm 30 --seed 7"
    off = "--tolerance gap=0.002 --tolerance scatter=0 --trials 12"
    output = json.loads(answer(capsys, *PAPER, *more.split(), *off.split(), "--json"))["request"]
    assert (output["heavy_thread_m"], output["light_thread_m"]) == (1.2, 1.1)
    assert (output["restitution"], output["damping_per_s"], output["seed"]) == (0.98, 0.01, 7)
    assert output["ball_diameter_m"] == pytest.approx(0.03)
    assert (output["tolerances"]["gap_m"], output["tolerances"]["scatter"]) == (0.002, 0.0)
    assert output["tolerances"]["release_m"] == Tolerances().release_m
    assert output["trials"] == 12


def test_a_folder_gets_map_pictures_page_and_plan(planned: Path) -> None:
    names = [HIDDEN, "plan.csv", "plan.html", "plan.json", "plan.png", "plan.svg"]
    assert sorted(file.name for file in planned.iterdir()) == names
    assert (planned / "plan.png").read_bytes().startswith(b"\x89PNG")
    drawing = ET.parse(planned / "plan.svg")
    identifiers = {node.get("id") for node in drawing.iter()}
    assert {"tolerance", "count", "circle"} <= identifiers
    with (planned / "plan.csv").open(encoding="ascii") as file:
        cells = list(csv.DictReader(file))
    for cell in cells[:: len(cells) // 40]:
        gap_m, release_m = float(cell["gap_m"]), float(cell["release_m"])
        impossible = gap_m > release_m
        assert (cell["count"] == "") == impossible
        if not impossible:
            setup = Setup(wall_gap_m=gap_m, release_m=release_m)
            assert int(cell["count"]) == simulate(setup).count
    assert read_request(planned / "plan.json") == PlanRequest(1050.0, 10.5, capture_fps=240.0)
    page = (planned / "plan.html").read_text("utf-8")
    words = re.sub(r"base64,[\w+/=]+", "", page)
    assert "http" not in words.replace("http-equiv", "")


def test_the_same_plan_makes_the_same_files_and_replaces_those_of_another(
    capsys: pytest.CaptureFixture[str], planned: Path, tmp_path: Path
) -> None:
    for plan in (["--plan", "4", "1", "--gap", "0.02"], [*PAPER, "--capture-fps", "240"]):
        answer(capsys, *plan, "-o", str(tmp_path))
    files = sorted(planned.glob("plan.*"))
    assert len(files) == 5
    for file in files:
        assert file.read_bytes() == (tmp_path / file.name).read_bytes(), file.name


@pytest.mark.parametrize(
    "arguments",
    [
        "--plan 1050",
        "--plan 10.5 1050",
        "--plan 1050 -10.5",
        "--plan 1050 0",
        "--plan 1050 10.5 --gap 0.1",
        "--plan 1050 10.5 --gap -0.03",
        "--plan 1050 10.5 --gap 0",
        "--plan 1050 10.5 --gap 3cm",
        "--plan 1050 10.5 --thread 1 1 1",
        "--plan 1050 10.5 --restitution 1.2",
        "--plan 1050 10.5 --damping 5",
        "--plan 1050 10.5 --trials 1",
        "--plan 1050 10.5 --tolerance gap",
        "--plan 1050 10.5 --tolerance gap=-1",
        "--plan 1050 10.5 --tolerance mass=2",
        "--plan 1050 10.5 --tolerance colour=1",
        "--plan 1050 10.5 --seed -1",
        "--plan 1050 10.5 --capture-fps 0",
        "--plan 1050 10.5 trial.mp4",
        "--plan 1050 10.5 --theory 1050 10.5",
        "--plan 1050 10.5 --masses 1050 10.5",
        "--plan 1050 10.5 --start 5",
        "--plan 1050 10.5 --format svg -o out",
        "--plan 1e9 1",
        "--plan 100 1 --thread 0.05",
        "--plan 100 1 --restitution 0.1",
        "--plan 1 1 --restitution 0",
        "--plan 10000 1 --restitution 0.95 --json",
        "--plan 100 1 --damping 3.11",
        "trial.mp4 --gap 0.03",
        "trial.mp4 --trials 30",
        "clips/ --plan-file plan.json -o out",
        "--theory 1050 10.5 --plan-file plan.json",
    ],
)
def test_nonsense_gets_one_clear_line_and_exit_code_2(
    arguments: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "clips").mkdir()
    assert main(arguments.split()) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith("count-video: ")
    assert output.err.count("\n") == 1


def test_a_folder_that_cannot_be_written_is_named(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    folder = tmp_path / "file" / "plans"
    assert main([*PAPER, "-o", str(folder)]) == 2
    assert str(folder) in capsys.readouterr().err


@pytest.mark.parametrize("name", ["plan.json", "plan.csv", "plan.html", "plan.png", "plan.svg"])
def test_nothing_that_somebody_else_wrote_is_replaced(
    name: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / name).write_text("mine", "utf-8")
    assert main([*PAPER, "-o", str(tmp_path)]) == 2
    output = capsys.readouterr()
    assert (output.out, output.err.count("\n")) == ("", 1)
    assert str(tmp_path / name) in output.err
    assert (tmp_path / name).read_text("utf-8") == "mine"
    assert [file.name for file in tmp_path.glob("plan.*")] == [name]


def test_a_counted_clip_is_held_against_its_plan(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = tmp_path / "plan.json"
    plan.write_text(answer(capsys, "--plan", "1050", "10.5", "--gap", "0.03", "--json"), "utf-8")
    clip = TOP / "fixtures/ratio100-count29.mp4"  # the ball hangs 5 cm from the wall
    worked = pipeline.work_through(clip, pipeline.TrialSettings(capture_fps=2000.0))
    monkeypatch.setattr(pipeline, "work_through", lambda *_: worked)  # it is counted once
    call = [str(clip), "--capture-fps", "2000", "--plan-file", str(plan)]
    output = json.loads(answer(capsys, *call, "--json"))
    assert output["count"] == 29
    assert (output["plan"]["planned_count"], output["plan"]["found_count"]) == (31, 29)
    assert output["plan"]["explained_by"] == ["gap_mm"]
    (gap,) = [one for one in output["plan"]["quantities"] if one["name"] == "gap_mm"]
    assert abs(gap["found"] - 50) <= 2 * gap["sigma"]
    assert gap["sigma"] < 0.5
    held = count_video.count(clip, capture_fps=2000).compared(plan)
    page = clip_page(held.answer, PageMedia(b"", np.zeros(0), np.zeros(0), {}))
    assert "the gap alone makes it 29" in " ".join(page.split())


@pytest.mark.parametrize("kept", [[], ["-o", "kept"]])
def test_a_plan_that_cannot_be_read_is_refused_before_the_clip_is_counted(
    kept: list[str],
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    clip = str(TOP / "fixtures/ratio1-count3.mp4")
    assert main([clip, "--plan-file", "missing.json", *kept]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.count("missing.json") == 1
    assert list(tmp_path.iterdir()) == []

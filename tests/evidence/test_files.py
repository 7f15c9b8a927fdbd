"""The files of a clip, its tables, and what is not done without being asked for."""

from __future__ import annotations

import csv
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from evidence_made import CLIP, Made, count_with_evidence

from count_video import cli
from count_video.errors import UsageError
from count_video.evidence import EvidenceSettings
from count_video.outputs import HIDDEN
from count_video.pipeline import TrialSettings
from count_video.reports.exports import (
    COLLISION_COLUMNS,
    TRACK_COLUMNS,
    collisions_array,
    table_csv,
)
from tiers import rest_slow

SMALL = CLIP.with_name("ratio1-count3.mp4")
PANELS = ("energy", "enlarged", "phase-circle", "space-time", "velocities")
SUFFIXES = sorted(
    [
        *("annotated.mp4", "collisions.csv", "html", "png", "strip.jpg", "track.csv"),
        *(f"{panel}.png" for panel in PANELS),
    ]
)


def read_csv(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text("utf-8").splitlines()))


def visible(folder: Path) -> list[Path]:
    """List what a person sees of a folder: not the record of what was written."""
    return [file for file in folder.iterdir() if file.name != HIDDEN]


def test_the_folder_holds_these_files_and_no_others(made: Made) -> None:
    assert sorted(file.name for file in visible(made.folder)) == [
        f"{CLIP.stem}.{suffix}" for suffix in SUFFIXES
    ]


def test_the_answer_is_the_same_with_evidence_and_without(made: Made) -> None:
    assert made.result == made.trial.result


def test_the_track_table_has_a_row_a_frame_in_px_and_mm(made: Made) -> None:
    rows = read_csv(made.file("track.csv"))
    assert tuple(rows[0]) == TRACK_COLUMNS.names
    assert [int(row["frame"]) for row in rows] == list(range(made.result.frames_decoded or 0))
    assert made.result.millimetres_per_px is not None
    for row in rows:
        assert float(row["time_s"]) == pytest.approx(int(row["frame"]) / 480.0, abs=1e-6)
        assert row["quality"] == "both"
        expected_mm = float(row["ball_px"]) * made.result.millimetres_per_px
        assert float(row["ball_mm"]) == pytest.approx(expected_mm, abs=1e-4)
        assert 0 < float(row["ball_sigma_px"]) < 1


def test_the_collision_table_has_a_row_a_collision(made: Made) -> None:
    rows = read_csv(made.file("collisions.csv"))
    assert tuple(rows[0]) == COLLISION_COLUMNS.names
    assert [int(row["number"]) for row in rows] == list(range(1, 13))
    assert {row["in_burst"] for row in rows} == {"yes"}
    kinds = [collision.kind for collision in made.result.collisions]
    assert [row["kind"] for row in rows] == kinds


def test_what_is_not_known_is_an_empty_cell(made: Made) -> None:
    first = replace(made.result.collisions[0], time_s=None)
    text = table_csv(collisions_array(replace(made.result, collisions=(first,))))
    (row,) = csv.DictReader(text.splitlines())
    assert row["time_s"] == ""


def test_a_clip_in_which_nothing_is_found_has_a_page_alone(tmp_path: Path) -> None:
    settings = TrialSettings(start=0, end=5)
    result = count_with_evidence(CLIP, settings, EvidenceSettings(tmp_path))
    assert result.status == "not_counted"
    (page,) = visible(tmp_path)
    assert result.reason is not None
    assert "not counted" in page.read_text("utf-8")


def test_a_folder_that_cannot_be_made_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", "utf-8")
    with pytest.raises(UsageError) as refusal:
        count_with_evidence(CLIP, TrialSettings(end=5), EvidenceSettings(tmp_path / "file" / "x"))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "arguments",
    rest_slow([[str(SMALL)], ["--theory", "100", "1"], [str(SMALL), "--json"]], quick=2),
)
def test_nothing_of_this_is_paid_for_without_being_asked_for(arguments: list[str]) -> None:
    program = (
        "import sys; from count_video.cli import main; code = main(sys.argv[1:]); "
        "assert code == 0; names = ('matplotlib', 'jinja2', 'PIL', 'count_video.evidence'); "
        "print([name for name in names if name in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], capture_output=True, text=True, check=True
    )
    assert done.stderr.strip() == "[]"


def test_the_theory_is_printed_with_all_its_parts(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--theory", "1050", "10.5"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("1050 and 10.5: 31 collisions\n")
    assert "0.09966865249 rad" in text  # arctan 1/10
    assert "0.199337305 rad" in text  # arccos 99/101
    assert "3.089728227 to 3.18939688" in text
    for count in (3, 31, 314, 3141, 31415, 314159, 3141592, 31415926):
        assert f" {count} " in text


def test_the_theory_goes_into_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--theory", "100", "1", "-o", str(tmp_path), "--format", "svg"]) == 0
    assert [file.name for file in visible(tmp_path)] == ["theory.svg"]
    assert "31 collisions" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("masses", "hint"),
    [
        (("1e99", "1e-99"), ""),
        (("1", "1"), ""),
        (("1e-99", "1e99"), "the first mass is the smaller"),
    ],
)
def test_the_theory_of_any_masses_fits_into_its_picture(
    masses: tuple[str, str], hint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # A layout that does not fit is a warning of matplotlib, which is an error here.
    assert cli.main(["--theory", *masses, "-o", str(tmp_path)]) == 0
    assert (tmp_path / "theory.png").stat().st_size > 10_000
    said = capsys.readouterr().err
    assert (len(said.splitlines()), hint in said) == (bool(hint), True)


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["clip.mp4", "--theory", "1", "1"],
        ["a.mp4", "b.mp4", "--corrections", "c.json"],
        ["--theory", "1", "1", "--json"],
        ["clip.mp4", "--pages"],
        ["clip.mp4", "--format", "gif"],
    ],
)
def test_what_makes_no_sense_together_is_refused(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1


def test_the_command_says_what_it_drew_of_the_theory(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["--theory", "100", "1", "-o", str(tmp_path)]) == 0
    said = " ".join(capsys.readouterr().out.partition("Written")[2].split())
    assert said.replace(" ", "") == str(tmp_path / "theory.png").replace(" ", "")

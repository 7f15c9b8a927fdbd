"""The Python in the pages and in examples/ runs."""

from __future__ import annotations

import runpy
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from count_video import pipeline
from pages import PAGES, TOP, blocks

EXAMPLES = [
    pytest.param(code, id=f"{path.name}-{number}")
    for path in PAGES
    for number, code in enumerate(blocks(path.read_text("utf-8"), "python"), 1)
]
CELL_S = 240
"""No cell of a notebook takes so long."""

work_once = cache(pipeline.work_through)


def start(file: Path, *arguments: str, folder: Path = TOP) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(file), *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def run(file: Path, *arguments: str, folder: Path = TOP) -> str:
    done = start(file, *arguments, folder=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def count_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Spare examples of the same clip and settings another count."""
    monkeypatch.setattr(pipeline, "work_through", work_once)


@pytest.mark.usefixtures("count_once")
@pytest.mark.parametrize("code", EXAMPLES)
def test_code_in_a_page_runs_and_prints(
    code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    script = tmp_path / "example.py"
    script.write_text(code, "utf-8")
    if "__main__" in code:  # it starts processes
        assert run(script) != ""
        return
    monkeypatch.chdir(TOP)
    runpy.run_path(str(script))
    assert capsys.readouterr().out != ""


def test_the_example_of_one_clip_counts_it_and_keeps_its_tables(tmp_path: Path) -> None:
    clip = TOP / "fixtures/ratio1-count3.mp4"
    printed = run(TOP / "examples/one_clip.py", str(clip), "1", "1", folder=tmp_path)
    assert "3 collisions" in printed
    assert "theory: 3" in printed
    assert (tmp_path / "evidence" / f"{clip.stem}.html").is_file()


def test_masses_that_are_no_numbers_are_one_line_of_the_example() -> None:
    done = start(TOP / "examples/one_clip.py", "clip.mp4", "heavy", "1")
    assert done.returncode == 1
    assert done.stderr == "HEAVY and LIGHT must be two numbers, for example 16 1\n"


def test_the_example_of_thirty_trials_prints_the_papers_table(tmp_path: Path) -> None:
    clips = [TOP / "fixtures" / f"{name}.mp4" for name in ("ratio1-count3", "ratio16-count12")]
    for clip in clips:
        (tmp_path / clip.name).write_bytes(clip.read_bytes())
    done = start(TOP / "examples/thirty_trials.py", str(tmp_path))
    said = {f"{clips[0].name}: counted 3", f"{clips[1].name}: counted 12"}
    assert {line.removeprefix(f"{tmp_path}/") for line in done.stderr.splitlines()} == said
    printed = done.stdout
    rows = {line[:25].strip(): line[25:].split() for line in printed.splitlines()}
    assert rows["Number of trials"] == ["2", "30"]
    assert rows["Maximum value"] == ["12", "31"]
    assert rows["Minimum value"] == ["3", "28"]
    assert rows["Mean value"] == ["7.50", "30.57"]
    assert rows["Standard deviation"] == ["4.50", "0.80"]


def test_the_notebook_runs_from_top_to_bottom() -> None:
    nbformat = pytest.importorskip("nbformat", reason="comes with the extra 'notebook'")
    client = pytest.importorskip("nbclient", reason="comes with the extra 'notebook'")
    pytest.importorskip("ipykernel", reason="comes with the extra 'notebook'")
    notebook = nbformat.read(TOP / "examples/one_clip.ipynb", as_version=4)
    where = {"metadata": {"path": TOP / "examples"}}
    client.NotebookClient(notebook, resources=where, timeout=CELL_S).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    shown = "".join(str(output.get("data", "")) for output in outputs)
    assert "12 collisions" in shown
    assert "image/png" in shown
